// Looks up and samples environment maps. Density: piecewise constant over the patches between texels, each by the mean
// of its corners times its solid angle, so that radiance / density is bounded (by 4 corners / mean and the sine's
// slope).
#include "myrialux/emitters/environment.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "myrialux/base/error.h"

namespace myrialux {

namespace {

constexpr double kTwoPi = 6.283185307179586;
/// Larger maps are sampled by a coarser table of at most this many columns and half as many rows.
constexpr int kMaxColumns = 2048;

/// Cells [first, last] of a table of n_cells that patch i of n_patches overlaps.
struct Overlap {
  int first, last;
};
Overlap overlap(int i, int n_patches, int n_cells) {
  if (n_patches <= n_cells) return {i, i};
  const auto cell = [&](std::int64_t k) { return static_cast<int>(k * n_cells / n_patches); };
  return {cell(i), std::min(n_cells - 1, static_cast<int>((std::int64_t{i + 1} * n_cells - 1) / n_patches))};
}

}  // namespace

EnvironmentMap::EnvironmentMap(const Scene& scene, const EnvmapEmitter& emitter)
    : image_(scene.textures[index(emitter.image)].image.get()),
      scale_(emitter.scale),
      to_world_(emitter.to_world),
      from_world_(emitter.to_world.inverse()) {
  const int w = image_->width, h = image_->height;
  if (w < 1 || h < 2)
    throw Error(ErrorKind::input, "environment map '" + scene.textures[index(emitter.image)].name +
                                      "' is too small; it needs at least 1 x 2 pixels");
  const int columns = std::min(w, kMaxColumns), rows = std::min(h - 1, kMaxColumns / 2);
  std::vector<float> weights(static_cast<std::size_t>(columns) * rows);
  double sum[3] = {};
  for (int j = 0; j + 1 < h; ++j) {
    // Solid angle of the patch: its columns' share of the zone between two parallels.
    const double zone = std::cos(kTwoPi / 2 * j / (h - 1)) - std::cos(kTwoPi / 2 * (j + 1) / (h - 1));
    const double omega = kTwoPi / w * zone;
    const Overlap y = overlap(j, h - 1, rows);
    for (int i = 0; i < w; ++i) {
      const int right = i + 1 < w ? i + 1 : 0;
      const Rgb c =
          (image_->texel(i, j) + image_->texel(right, j) + image_->texel(i, j + 1) + image_->texel(right, j + 1)) *
          (0.25f * scale_);
      sum[0] += omega * c.r, sum[1] += omega * c.g, sum[2] += omega * c.b;
      const float weight = static_cast<float>(omega) * std::max(0.0f, luminance(c));
      const Overlap x = overlap(i, w, columns);
      for (int row = y.first; row <= y.last; ++row)
        for (int column = x.first; column <= x.last; ++column)
          weights[static_cast<std::size_t>(row) * columns + column] += weight;
    }
  }
  integral_ = {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
  patches_ = Distribution2D(weights, static_cast<std::size_t>(columns), static_cast<std::size_t>(rows));
}

Rgb EnvironmentMap::radiance(Vec3 d) const { return bilinear(polar(d).uv) * scale_; }

EnvironmentMap::Sample EnvironmentMap::sample(Vec2 u) const {
  if (patches_.sum() <= 0) return {};
  const Distribution2D::Sample s = patches_.sample(u);
  prefetch(s.uv);
  float sine = 0;
  Sample out;
  out.direction = direction(s.uv, sine);
  if (!(sine > 0)) return out;
  out.pdf_omega = s.pdf_uv / (2 * kPi * kPi * sine);
  return out;
}

float EnvironmentMap::pdf_omega(Vec3 d) const {
  if (patches_.sum() <= 0) return 0;
  const Polar at = polar(d);
  return at.sine > 0 ? patches_.pdf_uv(at.uv) / (2 * kPi * kPi * at.sine) : 0;
}

EnvironmentMap::Polar EnvironmentMap::polar(Vec3 d) const {
  const Vec3 v = from_world_.vector(d);
  const double x = v.x, y = v.y, z = v.z, sine = std::hypot(x, z);
  double u = std::atan2(x, -z) / kTwoPi - 0.5 / image_->width;
  u -= std::floor(u);
  return {{static_cast<float>(u), static_cast<float>(std::atan2(sine, y) * 2 / kTwoPi)},
          static_cast<float>(sine / std::hypot(sine, y))};
}

Vec3 EnvironmentMap::direction(Vec2 uv, float& sine) const {
  const double phi = kTwoPi * (uv.x + 0.5 / image_->width), theta = kTwoPi / 2 * uv.y, s = std::sin(theta);
  sine = static_cast<float>(s);
  const Vec3 v{static_cast<float>(std::sin(phi) * s), static_cast<float>(std::cos(theta)),
               static_cast<float>(-std::cos(phi) * s)};
  return normalize(to_world_.vector(v));
}

/// Asks for the texels around: of large maps they lie in main memory, as far away as the sines of a direction take.
void EnvironmentMap::prefetch(Vec2 uv) const {
  const int w = image_->width, h = image_->height;
  const int x = std::clamp(static_cast<int>(uv.x * static_cast<float>(w)), 0, w - 1);
  const int y = std::clamp(static_cast<int>(uv.y * static_cast<float>(h - 1)), 0, h - 2);
  image_->prefetch(x, y), image_->prefetch(x, y + 1);
}

Rgb EnvironmentMap::bilinear(Vec2 uv) const {
  const int w = image_->width, h = image_->height;
  const float x = uv.x * static_cast<float>(w), y = uv.y * static_cast<float>(h - 1);
  const int x0 = std::clamp(static_cast<int>(x), 0, w - 1), y0 = std::clamp(static_cast<int>(y), 0, h - 2);
  const int x1 = x0 + 1 < w ? x0 + 1 : 0;
  const float fx = std::clamp(x - static_cast<float>(x0), 0.0f, 1.0f);
  const float fy = std::clamp(y - static_cast<float>(y0), 0.0f, 1.0f);
  const Rgb top = image_->texel(x0, y0) * (1 - fx) + image_->texel(x1, y0) * fx;
  const Rgb bottom = image_->texel(x0, y0 + 1) * (1 - fx) + image_->texel(x1, y0 + 1) * fx;
  return top * (1 - fy) + bottom * fy;
}

}  // namespace myrialux
