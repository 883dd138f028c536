// Affine maps of points, vectors and normals; composed and inverted in double precision.
#pragma once

#include <array>

#include "myrialux/math/vec.h"

namespace myrialux {

/// 4x4 matrix, row major, column vectors: p' = M p. The last row is (0 0 0 1) for all maps a scene may hold.
class Transform {
 public:
  Transform();  ///< identity
  explicit Transform(const std::array<double, 16>& rows) : m_(rows) {}
  static Transform translate(Vec3 offset);
  static Transform scale(Vec3 factors);
  /// Rotation by `degrees` about `axis` (not zero), counter-clockwise when the axis points at the viewer.
  static Transform rotate(Vec3 axis, float degrees);
  /// Maps the origin to `origin` and +z to `target`; +x points left of the viewer, as Mitsuba has it.
  static Transform look_at(Vec3 origin, Vec3 target, Vec3 up);

  Vec3 point(Vec3 p) const;
  Vec3 vector(Vec3 v) const;
  /// Normals by the inverse transpose; not normalised. Costs an inversion: hoist `normal_transform()` in loops.
  Vec3 normal(Vec3 n) const { return normal_transform().vector(n); }
  Transform normal_transform() const;
  /// Throws Error (input) when singular.
  Transform inverse() const;
  double determinant3() const;  ///< of the upper left 3x3 part; negative for mirrors
  bool is_affine() const;
  const std::array<double, 16>& rows() const { return m_; }
  bool operator==(const Transform&) const = default;

 private:
  std::array<double, 16> m_;
};

/// First b, then a.
Transform operator*(const Transform& a, const Transform& b);

}  // namespace myrialux
