// Cones of directions: the smallest cone around two others. Angles by atan2, since acos loses small ones.
#pragma once

#include "myrialux/math/vec.h"

namespace myrialux {

struct Cone {
  Vec3 axis;          ///< unit
  float cos_angle{};  ///< of the half angle; -1: all directions
};

/// Contains both; rounded outwards by a few units in the last place of the cosine.
inline Cone join(const Cone& a, const Cone& b) {
  if (a.cos_angle <= -1 || b.cos_angle <= -1) return {a.axis, -1};
  if (a.axis == b.axis) return {a.axis, std::min(a.cos_angle, b.cos_angle)};
  const Vec3 normal = cross(a.axis, b.axis);
  const float between = std::atan2(length(normal), dot(a.axis, b.axis));
  const float half_a = std::acos(a.cos_angle), half_b = std::acos(b.cos_angle);
  constexpr float kSlack = 3e-7f;  // of a cosine
  if (half_a >= between + half_b) return a;
  if (half_b >= between + half_a) return b;
  const float half = (between + half_a + half_b) / 2;
  if (half >= kPi || length(normal) == 0) return {a.axis, -1};
  // The new axis: a's, turned towards b's.
  const Vec3 across = cross(normalize(normal), a.axis);
  const float turn = half - half_a;
  return {normalize(a.axis * std::cos(turn) + across * std::sin(turn)), std::max(std::cos(half) - kSlack, -1.0f)};
}

}  // namespace myrialux
