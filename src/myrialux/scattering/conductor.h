// Metals, smooth and rough: Mitsuba's conductor and roughconductor. Source: [walter07] with complex Fresnel factors.
#pragma once

#include "myrialux/scattering/lobes.h"

namespace myrialux {

/// f |cos wi| of the rough metal; the smooth one gives 0. Zero unless wi.z > 0 and wo.z > 0.
Rgb evaluate_conductor(const Bsdf& bsdf, Vec3 wi, Vec3 wo);
float conductor_pdf_omega(const Bsdf& bsdf, Vec3 wi, Vec3 wo);
BsdfSample sample_conductor(const Bsdf& bsdf, Vec3 wo, Vec2 u);

}  // namespace myrialux
