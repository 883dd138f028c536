// Camera rays through a pinhole or a thin lens, where in a pixel and on the lens they go, and when. Same picture plane
// as Mitsuba's `perspective` and `thinlens`.
#include <bit>
#include <cmath>

#include "myrialux/math/warp.h"
#include "myrialux/receivers/receivers.h"

namespace myrialux {
namespace {

Vec3 on_lens(const Camera& camera, Vec2 lens) { return Vec3{lens.x, lens.y, 0} * camera.aperture_radius; }
/// f(camera to world at the sample's time); a camera that stands is not copied.
template <class F>
auto with_placement(const Camera& camera, const CameraSample& sample, const F& f) {
  return camera.moves() ? f(camera.at(sample.time)) : f(camera.to_world);
}
/// Rows of the grid of cells that a pixel's samples are jittered in: as square as the factors of spp allow.
int cell_rows(int spp) {
  int rows = static_cast<int>(std::sqrt(static_cast<double>(spp)));
  while (spp % rows != 0) --rows;
  return rows;
}
/// Place of k in a permutation of {0, ..., n - 1} drawn by rng: bijections of the next power of two, again until below
/// n.
std::uint32_t permuted(std::uint32_t k, std::uint32_t n, Rng& rng);

}  // namespace

CameraSample camera_sample(const Camera& camera, int width, std::uint64_t pixel, int k, int spp, RandomKey key) {
  CameraSample sample{.film = film_position(width, pixel, k, spp, key)};
  const auto n = static_cast<std::uint32_t>(spp), place = static_cast<std::uint32_t>(k);
  const std::uint64_t item = pixel * (std::uint64_t{n} + 1);  // of the pixel; those of its samples follow
  if (camera.aperture_radius > 0) {
    Rng order(key, Stage::lens, item), jitter(key, Stage::lens, item + 1 + place);
    const auto rows = static_cast<std::uint32_t>(cell_rows(spp)), columns = n / rows;
    const std::uint32_t cell = permuted(place, n, order), column = cell % columns, row = cell / columns;
    const float x = (static_cast<float>(column) + jitter.next()) / static_cast<float>(columns);
    const float y = (static_cast<float>(row) + jitter.next()) / static_cast<float>(rows);
    sample.lens = sample_disc({x, y});
  }
  if (camera.moves()) {
    Rng order(key, Stage::shutter, item), jitter(key, Stage::shutter, item + 1 + place);
    const double share = (permuted(place, n, order) + static_cast<double>(jitter.next())) / n;
    sample.time = camera.shutter_open + share * (camera.shutter_close - camera.shutter_open);
  }
  return sample;
}

Vec3 lens_point(const Camera& camera, const CameraSample& sample) {
  return with_placement(camera, sample,
                        [&](const Transform& to_world) { return to_world.point(on_lens(camera, sample.lens)); });
}

Ray camera_ray(const Camera& camera, int width, int height, const CameraSample& sample) {
  // Camera space: +z forward, +x to the left and +y to the top of the picture; the plane z = 1 is 2 tan(fov / 2) wide.
  const float half = std::tan(camera.fov_x_deg * (kPi / 360));
  const float w = static_cast<float>(width), h = static_cast<float>(height);
  const float x = sample.film.x / w + camera.principal_x, y = sample.film.y / h + camera.principal_y;
  const Vec3 centre{(1 - 2 * x) * half, (1 - 2 * y) * half * h / w, 1};  // through the lens's centre: not bent
  const bool has_lens = camera.aperture_radius > 0;
  const Vec3 local = normalize(has_lens ? centre * camera.focus_distance - on_lens(camera, sample.lens) : centre);
  const float near_t = camera.near_clip / local.z, far_t = camera.far_clip / local.z;
  return with_placement(camera, sample, [&](const Transform& to_world) {
    Ray ray;
    ray.direction = normalize(to_world.vector(local));
    ray.origin = to_world.point(on_lens(camera, sample.lens)) + ray.direction * near_t;
    ray.t_max = far_t - near_t;
    return ray;
  });
}

Vec2 film_position(int width, std::uint64_t pixel, int k, int spp, RandomKey key) {
  const int rows = cell_rows(spp), columns = spp / rows;
  const auto n = static_cast<std::uint64_t>(spp);
  const std::uint32_t shift = Rng(key, Stage::film, pixel).below(static_cast<std::uint32_t>(spp));
  const auto cell = static_cast<int>((static_cast<std::uint64_t>(k) + shift) % n);
  Rng rng(key, Stage::camera, pixel * n + static_cast<std::uint64_t>(k));
  const int column = cell % columns, row = cell / columns;
  const auto x = static_cast<float>(pixel % static_cast<std::uint64_t>(width));
  const std::uint64_t line = pixel / static_cast<std::uint64_t>(width);
  const auto y = static_cast<float>(line);
  // Rounding must not carry a sample into the next pixel.
  const auto inside = [](float base, float fraction) {
    return std::min(base + fraction, std::nextafter(base + 1, base));
  };
  return {inside(x, (static_cast<float>(column) + rng.next()) / static_cast<float>(columns)),
          inside(y, (static_cast<float>(row) + rng.next()) / static_cast<float>(rows))};
}

namespace {

std::uint32_t permuted(std::uint32_t k, std::uint32_t n, Rng& rng) {
  const int bits = std::bit_width(n - 1), half = std::max(1, bits / 2);
  const std::uint32_t mask = static_cast<std::uint32_t>((std::uint64_t{1} << bits) - 1);
  const std::uint32_t flip = rng.next_uint(), shift = rng.next_uint();
  const std::uint32_t factor_1 = rng.next_uint() | 1, factor_2 = rng.next_uint() | 1;  // odd: invertible modulo 2^bits
  do {
    k = (k ^ flip) & mask;
    k = (k * factor_1) & mask;
    k ^= k >> half;
    k = (k * factor_2) & mask;
    k ^= k >> half;
    k = (k + shift) & mask;
  } while (k >= n);
  return k;
}

}  // namespace

}  // namespace myrialux
