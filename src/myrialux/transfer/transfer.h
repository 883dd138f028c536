// One matrix entry without occlusion, T(i, j): plain scalar form, the twin of the vectorised kernels.
#pragma once

#include "myrialux/lights/virtual_lights.h"
#include "myrialux/receivers/receivers.h"

namespace myrialux {

/// Radiance leaving receiver i along wo because of light j if nothing stood between, W m^-2 sr^-1 (beta not included).
/// Geometry term clamped: 1 / d^2 becomes min(1 / d^2, 1 / clamp_distance^2); clamp_distance 0 = no clamping.
Rgb transfer(const World& world, const Receivers& receivers, ReceiverId i, const VirtualLights& lights, LightId j,
             float clamp_distance);

/// False where the entry is zero whatever the clamping; such entries are "don't care". Active means, with the
/// direction d = p_light - p_receiver (not normalised; distant lights: -n):
///   receiver: d . ng and d . n have the same sign, both positive unless its BSDF lets light through;
///   light, oriented or glossy: the same of -d with the light's ng and n; spot: within its cone; point, distant:
///   always.
bool is_active(const World& world, const Receivers& receivers, ReceiverId i, const VirtualLights& lights, LightId j);

/// Whether wide lobes carry light from one side of the surface to the other (rough glass).
bool transmits(const World& world, const BsdfParams& bsdf);

/// Both ends of the shadow segment of an entry, off their surfaces. Distant lights: `to` is a direction.
struct Segment {
  Vec3 from, to;
  bool distant;
};
Segment shadow_segment(const Receivers& receivers, ReceiverId i, const VirtualLights& lights, LightId j);

}  // namespace myrialux
