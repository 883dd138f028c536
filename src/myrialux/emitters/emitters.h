// Sampling of a scene's emitters: towards a point (next-event estimation) and outwards (light walks), with densities.
#pragma once

#include <memory>
#include <optional>

#include "myrialux/base/ids.h"
#include "myrialux/math/vec.h"
#include "myrialux/scene/scene.h"

namespace myrialux {

/// A direction from a point towards an emitter.
struct DirectSample {
  Vec3 wi;  ///< unit, from the shaded point
  Vec3 to;  ///< end point on the emitter, offset off its surface; meaningless if distant
  bool is_distant = false, is_delta = false;
  float distance = 0;   ///< infinity if distant
  float pdf_omega = 0;  ///< selection included; for delta emitters the probability of the selection alone
  Rgb radiance;         ///< Le towards the point; for delta emitters intensity / d^2 or irradiance
};

/// A ray leaving an emitter.
struct EmissionSample {
  EmitterId emitter = kNone<EmitterId>;
  enum class Kind : std::uint8_t { area, distant, point } kind = Kind::area;
  Vec3 p, n;         ///< start (on the emitter, or on the disc around the scene) and its normal (area: emission side)
  float offset = 0;  ///< as in SurfacePoint (area)
  Ray ray;           ///< offset off the surface; direction of travel
  Rgb power;         ///< Le |cos| / pdf (position, direction, selection): power carried by this one walk, W
  /// The same emission as a depth-0 virtual light: the sampled position or direction, all outgoing directions.
  /// area: radiant intensity along the normal, W/sr (Le A / selection); point: intensity; distant: irradiance, W m^-2.
  Rgb light;
};

class Emitters {
 public:
  /// Needs the scene's bounds for environment and directional emitters.
  /// @throws Error (input) when the scene has no emitter or all are black.
  Emitters(const Scene& scene, const Box3& bounds);
  ~Emitters();
  Emitters(Emitters&&) noexcept;

  /// Le leaving an area emitter at p towards -direction (direction of travel of the viewing ray). 0 from behind.
  Rgb emitted(EmitterId emitter, Vec2 uv, Vec3 n, Vec3 direction) const;
  /// Radiance of the environment seen along `direction`; 0 without one.
  Rgb environment(Vec3 direction) const;
  bool has_environment() const { return environment_ != kNone<EmitterId>; }

  /// Picks an emitter by power and a direction to it.
  std::optional<DirectSample> sample_direct(Vec3 p, float u_pick, Vec2 u) const;
  /// Density with which sample_direct(p) gives the direction to the point (p_on, ng) of an area emitter.
  float direct_pdf_omega(Vec3 p, EmitterId emitter, Vec3 p_on, Vec3 ng, std::uint32_t primitive) const;
  /// The same for the environment.
  float environment_pdf_omega(Vec3 direction) const;

  /// Picks an emitter by power, a place on it and a direction.
  EmissionSample sample_emission(float u_pick, Vec2 u_position, Vec2 u_direction) const;

  Rgb power() const;  ///< of all emitters together, W
  Rgb power(EmitterId emitter) const;
  float probability(EmitterId emitter) const;  ///< of being picked

 private:
  struct State;
  std::unique_ptr<const State> state_;
  EmitterId environment_ = kNone<EmitterId>;
};

}  // namespace myrialux
