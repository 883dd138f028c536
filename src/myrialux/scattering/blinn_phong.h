// Diffuse reflection plus a Blinn-Phong lobe, the model of MTL files' Kd, Ks, Ns:
//   f = Kd / pi + Ks (n + 2) (n + 4) / (8 pi (n + 2^(-n/2))) cos^n(h),   h: half vector to the normal. [blinn77]
// Normalised so that Ks is the lobe's albedo at normal incidence, its largest. docs/decisions/0007
#pragma once

#include "myrialux/scattering/lobes.h"

namespace myrialux {

/// Exponent with the fall-off of Beckmann facets of width alpha, 2 / alpha^2 - 2 [walter07]; 0 from alpha = 1 on.
inline float blinn_phong_exponent(float alpha) { return std::max(0.0f, 2 / (alpha * alpha) - 2); }
inline float blinn_phong_alpha(float exponent) { return std::sqrt(2 / (exponent + 2)); }

/// Value of the lobe at its peak for Ks = 1, 1/sr.
float blinn_phong_peak(float exponent);

/// Fills exponent and sampling weight from alpha and colours. Where both colours together exceed 1 in a channel, as a
/// texture may make them, both are scaled down.
void prepare_blinn_phong(Bsdf& bsdf);

/// f |cos wi| of the chosen lobes. Zero unless wi.z > 0 and wo.z > 0.
Rgb evaluate_blinn_phong(const Bsdf& bsdf, Vec3 wi, Vec3 wo, ChosenLobes lobes);
float blinn_phong_pdf_omega(const Bsdf& bsdf, Vec3 wi, Vec3 wo, ChosenLobes lobes);
BsdfSample sample_blinn_phong(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, ChosenLobes lobes);

}  // namespace myrialux
