// Maps from the unit square to directions and discs, each with its density beside it.
#pragma once

#include "myrialux/math/vec.h"

namespace myrialux {

/// Uniform on the unit disc; density 1 / pi per area. Concentric map [shirley97].
inline Vec2 sample_disc(Vec2 u) {
  const float a = 2 * u.x - 1, b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {};
  const bool wide = std::fabs(a) > std::fabs(b);
  const float r = wide ? a : b;
  const float phi = wide ? kPi / 4 * (b / a) : kPi / 2 - kPi / 4 * (a / b);
  return {r * std::cos(phi), r * std::sin(phi)};
}

/// Cosine-weighted on the hemisphere around +z.
inline Vec3 sample_cosine_hemisphere(Vec2 u) {
  const Vec2 d = sample_disc(u);
  return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}
inline float cosine_hemisphere_pdf_omega(float cos_theta) { return std::max(cos_theta, 0.0f) * kInvPi; }

/// Uniform on the unit sphere; density 1 / (4 pi) per solid angle.
inline Vec3 sample_sphere(Vec2 u) {
  const float z = 1 - 2 * u.x, r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Uniform in the cone around +z with cos(half angle) = cos_max; density 1 / (2 pi (1 - cos_max)).
inline Vec3 sample_cone(Vec2 u, float cos_max) {
  const float z = 1 - u.x * (1 - cos_max), r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}
/// The same for cones so narrow that 1 - cos(half angle) =: versine has to be known by itself; density
/// 1 / (2 pi versine).
inline Vec3 sample_narrow_cone(Vec2 u, float versine) {
  const float s = u.x * versine, r = std::sqrt(std::max(0.0f, s * (2 - s))), phi = 2 * kPi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), 1 - s};
}
inline float cone_pdf_omega(float cos_max) { return 1 / (2 * kPi * (1 - cos_max)); }

/// Uniform barycentric coordinates (b1, b2) of a triangle.
inline Vec2 sample_triangle(Vec2 u) {
  const float root = std::sqrt(u.x);
  return {1 - root, u.y * root};
}

}  // namespace myrialux
