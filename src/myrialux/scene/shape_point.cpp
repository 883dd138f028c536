// Computes points on shapes in double precision and bounds what rounding to float, Embree's transform of rays into
// instances and its triangle test [moller97] (edges, their cross product and T / den, all in float) can move.
#include "myrialux/scene/shape_point.h"

#include <algorithm>
#include <cmath>

namespace myrialux {

namespace {

/// Unit roundoff of float.
constexpr double kRoundoff = 0x1p-24;
/// Coordinate errors: p rounded once, the offset origin once more. With 1, 2, 2 for the three constants here 12022 of
/// 1e7 rays met the triangle they left, with 2, 4, 2 none (tests/trace/offset_test.cpp); these leave twice that room.
constexpr double kPointUlps = 3;
/// Embree's 3x4 transform of the ray's origin: three products and three sums a coordinate.
constexpr double kPlacementUlps = 5;
/// Triangle test: rounded edges (1), cross product (3), difference to the origin (1), dot product (3).
constexpr double kTriangleUlps = 8;
/// The cross product of a sliver's edges loses 1 / sine of the angle between them; slivers sharper than this would ask
/// for offsets beyond their own width.
constexpr double kMaxSliver = 64;

Point3d minus(const Point3d& a, const Point3d& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point3d cross(const Point3d& a, const Point3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double norm(const Point3d& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }
Point3d widen(Vec3 v) { return {v.x, v.y, v.z}; }
Vec3 narrow(const Point3d& p) { return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}; }
Vec3 unit(const Point3d& a, double sign);
/// Bound, along ng, of the rounding of coordinates at p (and of the instance's transform there).
double coordinate_error(const Point3d& p, Vec3 ng, const Placement* placement);

}  // namespace

Placement::Placement(const Transform& instance_to_world)
    : to_world(instance_to_world),
      from_world(instance_to_world.inverse()),
      normal_to_world(instance_to_world.normal_transform()) {
  const auto &m = to_world.rows(), &inv = from_world.rows();
  spread_max = 0;
  for (int i = 0; i < 3; ++i) {
    double row = 0;
    spread_at[i] = 0;
    for (int k = 0; k < 3; ++k) spread_at[i] += std::fabs(m[4 * i + k] * inv[4 * k + 3]);
    for (int j = 0; j < 3; ++j) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += std::fabs(m[4 * i + k] * inv[4 * k + j]);
      spread[3 * i + j] = sum;
      row += sum;
    }
    spread_max = std::max(spread_max, row);
  }
}

ShapePoint point_on_triangle(const Mesh& mesh, bool flip_normals, std::uint32_t triangle, double b1, double b2,
                             const Placement* placement) {
  const std::uint32_t* corner = &mesh.indices[3 * std::size_t{triangle}];
  const double b0 = 1 - b1 - b2;
  // Corners lie anywhere: all that is known of them is asked for at once.
  for (int k = 0; k < 3; ++k) {
    if (!mesh.normals.empty()) __builtin_prefetch(&mesh.normals[corner[k]]);
    if (!mesh.uvs.empty()) __builtin_prefetch(&mesh.uvs[corner[k]]);
  }
  Point3d v[3];
  for (int k = 0; k < 3; ++k) {
    v[k] = widen(mesh.positions[corner[k]]);
    if (placement) v[k] = transform_point(placement->to_world, v[k]);
  }
  Point3d p;
  for (int i = 0; i < 3; ++i) p[i] = b0 * v[0][i] + b1 * v[1][i] + b2 * v[2][i];
  const double sign = flip_normals ? -1 : 1;
  // An instance that mirrors keeps the side that the group's winding chose, as its normals do.
  const double winding = placement && placement->to_world.determinant3() < 0 ? -sign : sign;
  const Point3d e1 = minus(v[1], v[0]), e2 = minus(v[2], v[0]), area2 = cross(e1, e2);

  ShapePoint s;
  s.p = narrow(p);
  s.ng = s.n = unit(area2, winding);
  if (!mesh.normals.empty()) {
    Point3d n{};
    for (int k = 0; k < 3; ++k) {
      const Vec3 at = mesh.normals[corner[k]];
      const double b = k == 0 ? b0 : k == 1 ? b1 : b2;
      n[0] += b * at.x, n[1] += b * at.y, n[2] += b * at.z;
    }
    if (placement) n = transform_vector(placement->normal_to_world, n);
    if (norm(n) > 0) s.n = unit(n, sign);
  }
  s.uv = {static_cast<float>(b1), static_cast<float>(b2)};
  if (!mesh.uvs.empty()) {
    const Vec2 t0 = mesh.uvs[corner[0]], t1 = mesh.uvs[corner[1]], t2 = mesh.uvs[corner[2]];
    s.uv = {static_cast<float>(b0 * t0.x + b1 * t1.x + b2 * t2.x),
            static_cast<float>(b0 * t0.y + b1 * t1.y + b2 * t2.y)};
  }
  const double l1 = norm(e1), l2 = norm(e2), extent = std::max({l1, l2, norm(minus(v[2], v[1]))});
  const double sliver = std::clamp(l1 * l2 / std::max(norm(area2), 1e-300), 1.0, kMaxSliver);
  const double stretch = placement ? placement->spread_max : 1;
  s.offset =
      static_cast<float>(coordinate_error(p, s.ng, placement) + kTriangleUlps * kRoundoff * extent * sliver * stretch);
  return s;
}

ShapePoint point_on_quadric(const Quadric& quadric, bool flip_normals, const Point3d& object,
                            const Placement* placement) {
  Point3d p = transform_point(quadric.to_world, object);
  Point3d n = quadric.kind == Quadric::Kind::disk ? Point3d{0, 0, 1} : object;
  if (quadric.kind == Quadric::Kind::cylinder) n[2] = 0;
  n = transform_vector(quadric.to_world.normal_transform(), n);
  if (placement) {
    p = transform_point(placement->to_world, p);
    n = transform_vector(placement->normal_to_world, n);
  }
  // Mitsuba turns the normals of mirrored spheres inwards; those of mirrored discs and cylinders stay.
  const bool inward = quadric.kind == Quadric::Kind::sphere && quadric.to_world.determinant3() < 0;
  ShapePoint s;
  s.p = narrow(p);
  s.ng = s.n = unit(n, flip_normals != inward ? -1 : 1);
  s.uv = quadric_uv(quadric.kind, object);
  s.offset = static_cast<float>(coordinate_error(p, s.ng, nullptr));  // rays meet quadrics in double, in world space
  return s;
}

Vec2 quadric_uv(Quadric::Kind kind, const Point3d& o) {
  constexpr double kTwoPi = 6.283185307179586;
  double phi = std::atan2(o[1], o[0]) / kTwoPi;
  if (phi < 0) phi += 1;
  const auto turn = static_cast<float>(phi);
  if (kind == Quadric::Kind::disk) return {static_cast<float>(std::hypot(o[0], o[1])), turn};
  if (kind == Quadric::Kind::cylinder) return {turn, static_cast<float>(o[2])};
  return {turn, static_cast<float>(std::atan2(std::hypot(o[0], o[1]), o[2]) * 2 / kTwoPi)};
}

Point3d transform_point(const Transform& m, const Point3d& p) {
  const auto& r = m.rows();
  Point3d q;
  for (int i = 0; i < 3; ++i) q[i] = r[4 * i] * p[0] + r[4 * i + 1] * p[1] + r[4 * i + 2] * p[2] + r[4 * i + 3];
  return q;
}

Point3d transform_vector(const Transform& m, const Point3d& v) {
  const auto& r = m.rows();
  Point3d q;
  for (int i = 0; i < 3; ++i) q[i] = r[4 * i] * v[0] + r[4 * i + 1] * v[1] + r[4 * i + 2] * v[2];
  return q;
}

namespace {

Vec3 unit(const Point3d& a, double sign) {
  const double length = norm(a);
  const double s = length > 0 ? sign / length : 0;
  return narrow({a[0] * s, a[1] * s, a[2] * s});
}

double coordinate_error(const Point3d& p, Vec3 ng, const Placement* placement) {
  double error = 0;
  for (int i = 0; i < 3; ++i) {
    double at = kPointUlps * std::fabs(p[i]);
    if (placement) {
      double moved = placement->spread_at[i];
      for (int j = 0; j < 3; ++j) moved += placement->spread[3 * i + j] * std::fabs(p[j]);
      at += kPlacementUlps * moved;
    }
    error += at * std::fabs(ng[i]);
  }
  return error * kRoundoff;
}

}  // namespace

}  // namespace myrialux
