// What it costs to stand for lights by one: intensity times (diagonal^2 + c^2 (1 - cos half angle)^2). [walter05]
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "myrialux/clusters/cone.h"

namespace myrialux {

/// Lights taken together while a tree is built bottom-up.
struct LightGroup {
  Box3 box;                ///< as LightNode::box
  Vec3 axis;               ///< unit; of the cone of normals
  float half_angle = 0;    ///< radians
  float intensity = 0;     ///< sum of importance
  std::uint32_t id = 0;    ///< of its node, the builder's numbering
  std::uint32_t slot = 0;  ///< the builder's place for the next merge that has this group as its first part
};

/// Half angle of the cone around two others, without its axis; to 1e-4 rad.
inline float joined_half_angle(const LightGroup& a, const LightGroup& b) {
  // arccosine after Abramowitz and Stegun 4.4.45
  const float x = std::clamp(dot(a.axis, b.axis), -1.0f, 1.0f), m = std::fabs(x);
  const float small = std::sqrt(1 - m) * (1.5707288f + m * (-0.2121144f + m * (0.0742610f - m * 0.0187293f)));
  const float between = x < 0 ? kPi - small : small;
  return std::min(std::max({(between + a.half_angle + b.half_angle) / 2, a.half_angle, b.half_angle}), kPi);
}

/// The measure by which pairs are joined, smallest first. Never falls as groups grow. @param c2 square of the scene's
/// diagonal; 0 for lights without a cosine. @param least added to the square, > 0: lights in one place pair by
/// intensity
inline float join_cost(const LightGroup& a, const LightGroup& b, float c2, float least) {
  const Vec3 d = max(a.box.upper, b.box.upper) - min(a.box.lower, b.box.lower);
  // 1 - cos h = 2 sin^2 (h / 2), the sine by its series
  const float s = joined_half_angle(a, b) / 2, s2 = s * s;
  const float sine = s * (1 + s2 * (-1.0f / 6 + s2 * (1.0f / 120 - s2 * (1.0f / 5040)))), fall = 2 * sine * sine;
  return (a.intensity + b.intensity) * (length_squared(d) + c2 * fall * fall + least);
}

/// Both as one; id and slot are left to the builder.
inline LightGroup join(const LightGroup& a, const LightGroup& b) {
  LightGroup g;
  g.box = a.box;
  g.box.add(b.box);
  const Cone cone = join(Cone{a.axis, std::cos(a.half_angle)}, Cone{b.axis, std::cos(b.half_angle)});
  g.axis = cone.axis;
  g.half_angle = joined_half_angle(a, b);
  g.intensity = a.intensity + b.intensity;
  return g;
}

}  // namespace myrialux
