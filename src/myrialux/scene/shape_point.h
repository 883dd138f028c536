// Points on shapes from the shapes' own coordinates: position, normals, uv, and how far rounding may have moved them.
// Positions do not come from a ray (origin + t d), so their error does not grow with the length of the ray.
#pragma once

#include <array>
#include <cstdint>

#include "myrialux/scene/scene.h"

namespace myrialux {

using Point3d = std::array<double, 3>;

/// A point on a shape, world space. ng and n are as Mitsuba has them: ng by winding, n interpolated and not turned to
/// ng's side; both turned by Shape::flip_normals.
struct ShapePoint {
  Vec3 p, ng, n;
  Vec2 uv;
  float offset = 0;  ///< a ray that starts at p +- offset ng cannot meet the shape again by rounding; see below
};

/// What an instance does to its group, prepared once.
struct Placement {
  explicit Placement(const Transform& instance_to_world);
  Transform to_world, from_world, normal_to_world;
  std::array<double, 9> spread;     ///< |M| |M^-1|, row major: how rounding in the group's space grows on the way back
  std::array<double, 3> spread_at;  ///< |M| |M^-1 t|, the share of the translation t
  double spread_max;                ///< largest row sum of `spread`
};

/// Barycentric weights (1 - b1 - b2, b1, b2) of the three corners. `placement` is null for shapes in the world.
/// Triangles without area get ng = 0; the loader drops them.
ShapePoint point_on_triangle(const Mesh& mesh, bool flip_normals, std::uint32_t triangle, double b1, double b2,
                             const Placement* placement = nullptr);

/// `object`: a point on the unit shape (in the quadric's own space), exact to double precision.
ShapePoint point_on_quadric(const Quadric& quadric, bool flip_normals, const Point3d& object,
                            const Placement* placement = nullptr);

/// uv of a point of the unit shape. Sphere (phi, theta) / (2 pi, pi), disc (r, phi / 2 pi), cylinder (phi / 2 pi, z).
Vec2 quadric_uv(Quadric::Kind kind, const Point3d& object);

/// M p in double precision.
Point3d transform_point(const Transform& m, const Point3d& p);
Point3d transform_vector(const Transform& m, const Point3d& v);

}  // namespace myrialux
