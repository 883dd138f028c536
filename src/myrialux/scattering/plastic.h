// A dielectric coat, smooth or rough, over a diffuse base: Mitsuba's plastic and roughplastic.
// The coat scatters light once by reflection; what enters it is scattered by the base, any number of times.
#pragma once

#include "myrialux/scattering/lobes.h"

namespace myrialux {

/// Fills what evaluation of plastic needs beyond the parameters: index factors, mean reflectances, sampling weights.
void prepare_plastic(Bsdf& bsdf);

/// f |cos wi| of the chosen lobes; the smooth coat is a delta lobe and gives 0. Zero unless wi.z > 0 and wo.z > 0.
Rgb evaluate_plastic(const Bsdf& bsdf, Vec3 wi, Vec3 wo, ChosenLobes lobes);
float plastic_pdf_omega(const Bsdf& bsdf, Vec3 wi, Vec3 wo, ChosenLobes lobes);
BsdfSample sample_plastic(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, ChosenLobes lobes);

/// Probability with which sampling prefers the coat where both parts are chosen: its share of the reflected light.
float coat_probability(const Bsdf& bsdf, float cos_o);

}  // namespace myrialux
