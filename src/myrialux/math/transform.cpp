// Composes, inverts and applies affine maps in double precision.
#include "myrialux/math/transform.h"

#include <cmath>

#include "myrialux/base/error.h"

namespace myrialux {

Transform::Transform() : m_{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1} {}

Transform Transform::translate(Vec3 d) { return Transform({1, 0, 0, d.x, 0, 1, 0, d.y, 0, 0, 1, d.z, 0, 0, 0, 1}); }

Transform Transform::scale(Vec3 f) { return Transform({f.x, 0, 0, 0, 0, f.y, 0, 0, 0, 0, f.z, 0, 0, 0, 0, 1}); }

Transform Transform::rotate(Vec3 axis, float degrees) {
  const double norm = std::sqrt(double(axis.x) * axis.x + double(axis.y) * axis.y + double(axis.z) * axis.z);
  const double x = axis.x / norm, y = axis.y / norm, z = axis.z / norm;
  const double angle = double(degrees) * 3.14159265358979323846 / 180, c = std::cos(angle), s = std::sin(angle);
  const double k = 1 - c;
  return Transform({x * x * k + c, x * y * k - z * s, x * z * k + y * s, 0,  //
                    y * x * k + z * s, y * y * k + c, y * z * k - x * s, 0,  //
                    z * x * k - y * s, z * y * k + x * s, z * z * k + c, 0,  //
                    0, 0, 0, 1});
}

Transform Transform::look_at(Vec3 origin, Vec3 target, Vec3 up) {
  const Vec3 z = normalize(target - origin);
  const Vec3 x = normalize(cross(up, z));
  const Vec3 y = cross(z, x);
  return Transform({x.x, y.x, z.x, origin.x, x.y, y.y, z.y, origin.y, x.z, y.z, z.z, origin.z, 0, 0, 0, 1});
}

Vec3 Transform::point(Vec3 p) const {
  const auto row = [&](int r) {
    return static_cast<float>(m_[4 * r] * p.x + m_[4 * r + 1] * p.y + m_[4 * r + 2] * p.z + m_[4 * r + 3]);
  };
  return {row(0), row(1), row(2)};
}

Vec3 Transform::vector(Vec3 v) const {
  const auto row = [&](int r) {
    return static_cast<float>(m_[4 * r] * v.x + m_[4 * r + 1] * v.y + m_[4 * r + 2] * v.z);
  };
  return {row(0), row(1), row(2)};
}

double Transform::determinant3() const {
  return m_[0] * (m_[5] * m_[10] - m_[6] * m_[9]) - m_[1] * (m_[4] * m_[10] - m_[6] * m_[8]) +
         m_[2] * (m_[4] * m_[9] - m_[5] * m_[8]);
}

bool Transform::is_affine() const { return m_[12] == 0 && m_[13] == 0 && m_[14] == 0 && m_[15] == 1; }

Transform Transform::inverse() const {
  const double det = determinant3();
  if (!(std::fabs(det) > 1e-300)) throw Error(ErrorKind::input, "transform cannot be inverted (determinant is 0)");
  const double d = 1 / det;
  std::array<double, 16> r{};
  r[0] = (m_[5] * m_[10] - m_[6] * m_[9]) * d, r[1] = (m_[2] * m_[9] - m_[1] * m_[10]) * d;
  r[2] = (m_[1] * m_[6] - m_[2] * m_[5]) * d, r[4] = (m_[6] * m_[8] - m_[4] * m_[10]) * d;
  r[5] = (m_[0] * m_[10] - m_[2] * m_[8]) * d, r[6] = (m_[2] * m_[4] - m_[0] * m_[6]) * d;
  r[8] = (m_[4] * m_[9] - m_[5] * m_[8]) * d, r[9] = (m_[1] * m_[8] - m_[0] * m_[9]) * d;
  r[10] = (m_[0] * m_[5] - m_[1] * m_[4]) * d;
  for (int i = 0; i < 3; ++i) r[4 * i + 3] = -(r[4 * i] * m_[3] + r[4 * i + 1] * m_[7] + r[4 * i + 2] * m_[11]);
  r[15] = 1;
  return Transform(r);
}

Transform Transform::normal_transform() const {
  const std::array<double, 16> i = inverse().m_;
  return Transform({i[0], i[4], i[8], 0, i[1], i[5], i[9], 0, i[2], i[6], i[10], 0, 0, 0, 0, 1});
}

Transform operator*(const Transform& a, const Transform& b) {
  std::array<double, 16> r{};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k) r[4 * i + j] += a.rows()[4 * i + k] * b.rows()[4 * k + j];
  return Transform(r);
}

}  // namespace myrialux
