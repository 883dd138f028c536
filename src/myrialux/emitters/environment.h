// Environment map: radiance by direction (Mitsuba's orientation), and directions drawn in proportion to it, nearly.
// Internal to emitters/.
#pragma once

#include "myrialux/math/distribution.h"
#include "myrialux/math/transform.h"
#include "myrialux/scene/scene.h"

namespace myrialux {

/// Latitude-longitude map, +y up in its own space; u = atan2(x, -z) / 2 pi, v = acos(y) / pi, row 0 at the top.
/// Texels lie at the centres of w columns around, and on h rows from pole to pole (first and last on the poles).
class EnvironmentMap {
 public:
  EnvironmentMap() = default;
  EnvironmentMap(const Scene& scene, const EnvmapEmitter& emitter);
  Rgb radiance(Vec3 direction) const;
  struct Sample {
    Vec3 direction;  ///< unit, towards the environment
    float pdf_omega = 0;
  };
  Sample sample(Vec2 u) const;
  float pdf_omega(Vec3 direction) const;
  Rgb integral() const { return integral_; }  ///< of the radiance over all directions, W m^-2

 private:
  struct Polar {
    Vec2 uv;  ///< u shifted by half a column: patches between texels start at multiples of 1 / w
    float sine;
  };
  Polar polar(Vec3 direction) const;
  Vec3 direction(Vec2 uv, float& sine) const;
  Rgb bilinear(Vec2 uv) const;
  void prefetch(Vec2 uv) const;

  const Image* image_ = nullptr;
  float scale_ = 1;
  Transform to_world_, from_world_;
  Distribution2D patches_;  ///< over uv, in proportion to mean luminance x area on the sphere of the bilinear patches
  Rgb integral_;
};

}  // namespace myrialux
