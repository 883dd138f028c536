// Rotations as unit quaternions and back; slerp between them.
#include "myrialux/math/rigid_motion.h"

#include <cmath>

namespace myrialux {
namespace {

using Quaternion = std::array<double, 4>;  ///< w, x, y, z; unit

/// Of the linear part, its first column times `handedness`. The largest of |w|, |x|, |y|, |z| is the one a square root
/// is taken for, so that nothing small is divided by.
Quaternion quaternion_of(const Transform& m, double handedness);
Transform transform_of(const Quaternion& q, double handedness, const std::array<double, 3>& translation);
Quaternion slerp(const Quaternion& a, Quaternion b, double share);

}  // namespace

Transform rigid_between(const Transform& a, const Transform& b, double share) {
  const double handedness = a.determinant3() < 0 ? -1 : 1;
  std::array<double, 3> translation{};
  for (std::size_t r = 0; r < 3; ++r) translation[r] = (1 - share) * a.rows()[4 * r + 3] + share * b.rows()[4 * r + 3];
  return transform_of(slerp(quaternion_of(a, handedness), quaternion_of(b, handedness), share), handedness,
                      translation);
}

double rigidity_error(const Transform& transform) {
  const auto& m = transform.rows();
  double worst = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = i; j < 3; ++j) {
      const double product = m[i] * m[j] + m[4 + i] * m[4 + j] + m[8 + i] * m[8 + j];
      worst = std::max(worst, std::fabs(product - (i == j ? 1 : 0)));
    }
  return worst;
}

namespace {

Quaternion normalized(Quaternion q) {
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& c : q) c /= norm;
  return q;
}

Quaternion quaternion_of(const Transform& transform, double handedness) {
  const auto m = [&](std::size_t r, std::size_t c) { return transform.rows()[4 * r + c] * (c == 0 ? handedness : 1); };
  const double trace = m(0, 0) + m(1, 1) + m(2, 2);
  std::size_t largest = 0;  // 0: w, 1 + axis: that axis
  double four_squares = 1 + trace;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (const double of_axis = 1 + 2 * m(axis, axis) - trace; of_axis > four_squares)
      four_squares = of_axis, largest = 1 + axis;
  Quaternion q{};
  q[largest] = four_squares;  // all components times the same factor
  if (largest == 0) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t j = (axis + 1) % 3, k = (axis + 2) % 3;
      q[1 + axis] = m(k, j) - m(j, k);
    }
  } else {
    const std::size_t i = largest - 1, j = (i + 1) % 3, k = (i + 2) % 3;
    q[0] = m(k, j) - m(j, k), q[1 + j] = m(j, i) + m(i, j), q[1 + k] = m(k, i) + m(i, k);
  }
  return normalized(q);
}

Transform transform_of(const Quaternion& q, double handedness, const std::array<double, 3>& t) {
  const auto [w, x, y, z] = q;
  const double h = handedness;
  return Transform({h * (1 - 2 * (y * y + z * z)), 2 * (x * y - w * z), 2 * (x * z + w * y), t[0],  //
                    h * 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), t[1],    //
                    h * 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), t[2],    //
                    0, 0, 0, 1});
}

Quaternion slerp(const Quaternion& a, Quaternion b, double share) {
  double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  if (cosine < 0) {  // q and -q are one rotation: take the nearer
    cosine = -cosine;
    for (double& c : b) c = -c;
  }
  const double angle = std::acos(std::min(1.0, cosine)), sine = std::sin(angle);
  const bool is_small = angle < 1e-6;  // then the chord serves for the arc
  const double of_a = is_small ? 1 - share : std::sin((1 - share) * angle) / sine;
  const double of_b = is_small ? share : std::sin(share * angle) / sine;
  Quaternion q{};
  for (std::size_t c = 0; c < 4; ++c) q[c] = of_a * a[c] + of_b * b[c];
  return normalized(q);
}

}  // namespace
}  // namespace myrialux
