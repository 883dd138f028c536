// Area emitters: points uniform by area on a mesh or quadric, densities, radiance and power. Internal to emitters/.
#pragma once

#include <cstdint>

#include "myrialux/math/distribution.h"
#include "myrialux/scene/scene.h"
#include "myrialux/scene/shape_point.h"

namespace myrialux {

class AreaSampler {
 public:
  AreaSampler(const Scene& scene, const AreaEmitter& emitter);

  struct Sample {
    ShapePoint at;
    float pdf_area = 0;  ///< 0: no such point
  };
  /// Uniform by area (meshes, spheres, discs; cylinders if not sheared, else with the density it says).
  Sample sample(float u_pick, Vec2 u) const;
  /// Density of `sample` at a point of the surface.
  float pdf_area(Vec3 p_on) const;

  /// Towards p: spheres seen from outside by their cone, everything else by area. pdf_omega is 0 when nothing can
  /// arrive.
  struct Towards {
    ShapePoint at;
    Vec3 wi;  ///< unit, from p
    float distance = 0, pdf_omega = 0;
  };
  Towards sample_towards(Vec3 p, float u_pick, Vec2 u) const;
  float pdf_omega(Vec3 p, Vec3 p_on, Vec3 ng) const;

  Rgb radiance(Vec2 uv) const;
  double area() const { return area_; }
  Rgb power() const { return power_; }  ///< pi * integral of the radiance over the area, W

 private:
  struct Cone {
    Vec3 axis;  ///< unit, towards the centre
    double distance = 0;
    float versine = 0;  ///< 1 - cos of the half angle; 0: p is not outside
  };
  Cone cone_from(Vec3 p) const;
  Point3d object_point(Vec2 u) const;  ///< on the unit quadric
  Rgb mean_radiance() const;           ///< over the area

  const Scene& scene_;
  const Shape& shape_;
  const ColorSlot& radiance_;
  const Mesh* mesh_ = nullptr;  ///< or
  const Quadric* quadric_ = nullptr;
  Transform from_world_;          ///< quadrics
  Distribution1D triangle_pick_;  ///< by area
  bool is_sphere_ = false, emits_inwards_ = false;
  Point3d centre_{};
  double radius_ = 0;  ///< spheres
  double area_ = 0;
  Rgb power_;
};

}  // namespace myrialux
