// Spot light: intensity by angle from its axis, as Mitsuba has it (falloff linear in the angle). Internal to emitters/.
#pragma once

#include <cmath>

#include "myrialux/math/warp.h"
#include "myrialux/scene/scene.h"

namespace myrialux {

class Spot {
 public:
  Spot(const Scene& scene, const SpotEmitter& emitter)
      : scene_(scene), emitter_(emitter), from_world_(emitter.to_world.inverse()) {
    position = emitter.to_world.point({});
    axis = normalize(emitter.to_world.vector({0, 0, 1}));
    cutoff_ = emitter.cutoff_deg * kPi / 180, beam_ = std::min(emitter.beam_deg * kPi / 180, cutoff_);
    cos_cutoff = std::cos(cutoff_);
    power = integrate();
  }

  Vec3 position, axis;
  float cos_cutoff = 0;
  Rgb power;  ///< integral of the intensity over all directions, W

  /// Intensity towards the unit direction w, W/sr; 0 outside the cone.
  Rgb intensity(Vec3 w) const {
    const float cosine = std::min(dot(w, axis), 1.0f);
    if (cosine <= cos_cutoff) return {};
    const float angle = std::acos(cosine), fall = cutoff_ - beam_;
    const float factor = angle <= beam_ || fall <= 0 ? 1 : (cutoff_ - angle) / fall;
    Rgb value = emitter_.intensity * factor;
    if (emitter_.texture != kNone<TextureId>) {
      const Vec3 local = from_world_.vector(w);
      const float s = 0.5f / (local.z * std::tan(cutoff_));
      value *= evaluate(scene_.textures[index(emitter_.texture)], {0.5f + local.x * s, 0.5f + local.y * s});
    }
    return value;
  }

 private:
  /// Midpoint rule over equal solid angles (relative error below 1e-4 without texture).
  Rgb integrate() const {
    constexpr int kAround = 64, kAcross = 256;
    const Frame frame(axis);
    const float versine = 1 - cos_cutoff;
    double sum[3] = {};
    for (int a = 0; a < kAcross; ++a)
      for (int b = 0; b < kAround; ++b) {
        const Vec2 u{(static_cast<float>(a) + 0.5f) / kAcross, (static_cast<float>(b) + 0.5f) / kAround};
        const Rgb c = intensity(frame.to_world(sample_narrow_cone(u, versine)));
        sum[0] += c.r, sum[1] += c.g, sum[2] += c.b;
      }
    const double share = 2 * double(kPi) * versine / (kAround * kAcross);
    return {static_cast<float>(sum[0] * share), static_cast<float>(sum[1] * share), static_cast<float>(sum[2] * share)};
  }

  const Scene& scene_;
  const SpotEmitter& emitter_;
  Transform from_world_;
  float cutoff_ = 0, beam_ = 0;
};

}  // namespace myrialux
