// Camera rays of a pinhole camera, and where in a pixel they go. Same picture plane as Mitsuba's `perspective`.
#include <cmath>

#include "myrialux/receivers/receivers.h"

namespace myrialux {

Ray camera_ray(const Camera& camera, int width, int height, Vec2 position) {
  // Camera space: +z forward, +x to the left and +y to the top of the picture; the plane z = 1 is 2 tan(fov / 2) wide.
  const float half = std::tan(camera.fov_x_deg * (kPi / 360));
  const float w = static_cast<float>(width), h = static_cast<float>(height);
  const float x = position.x / w + camera.principal_x, y = position.y / h + camera.principal_y;
  const Vec3 local = normalize({(1 - 2 * x) * half, (1 - 2 * y) * half * h / w, 1});
  Ray ray;
  ray.direction = normalize(camera.to_world.vector(local));
  const float near_t = camera.near_clip / local.z, far_t = camera.far_clip / local.z;
  ray.origin = camera.to_world.point({}) + ray.direction * near_t;
  ray.t_max = far_t - near_t;
  return ray;
}

Vec2 film_position(int width, std::uint64_t pixel, int k, int spp, RandomKey key) {
  int rows = static_cast<int>(std::sqrt(static_cast<double>(spp)));
  while (spp % rows != 0) --rows;
  const int columns = spp / rows;
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

}  // namespace myrialux
