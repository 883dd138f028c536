// Glass: smooth, thin and rough boundaries, and the boundary that is not there (Mitsuba's dielectric, thindielectric,
// roughdielectric, null). Both sides of the surface scatter: wo.z < 0 is inside. Source: [walter07]
#pragma once

#include "myrialux/scattering/lobes.h"

namespace myrialux {

/// f |cos wi| of rough glass, radiance along wo; all other kinds give 0.
Rgb evaluate_dielectric(const Bsdf& bsdf, Vec3 wi, Vec3 wo);
float dielectric_pdf_omega(const Bsdf& bsdf, Vec3 wi, Vec3 wo);
BsdfSample sample_dielectric(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, TransportMode mode);

}  // namespace myrialux
