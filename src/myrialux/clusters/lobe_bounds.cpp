// Upper bounds of wide lobes for one fixed direction. Microfacet lobes: D of the smallest possible half-vector angle,
// G1 of the fixed direction, the largest Fresnel reflectance; everything else 1. Distributions and shadowing after
// [walter07]. Blinn-Phong: the lobe of that half vector, times 1 for the cosine.
#include "myrialux/clusters/lobe_bounds.h"

#include "myrialux/scattering/blinn_phong.h"
#include "myrialux/scattering/fresnel.h"
#include "myrialux/scattering/microfacet.h"
#include "myrialux/scattering/rough_transmittance.h"

namespace myrialux {
namespace {

/// Coefficients of shape(); the angle below which the distribution does not fall yet.
void set_shape(const Bsdf& bsdf, LobeBounds& bounds) {
  const float alpha2 = bsdf.alpha * bsdf.alpha;
  bounds.alpha = bsdf.alpha;
  if (bsdf.distribution == Microfacets::ggx) {
    bounds.c1 = 2, bounds.c2 = 1, bounds.c3 = 0;
    bounds.t_least = alpha2 > 1 ? 1e6f : 0;
  } else {  // exp(-x) <= 1 / (1 + x + x^2 / 2 + x^3 / 6)
    bounds.c1 = 1, bounds.c2 = 0.5f, bounds.c3 = 1.0f / 6;
    bounds.t_least = std::max(0.0f, 2 * alpha2 - 1);
  }
}

/// With N = n / 2 + 2 = 1 / alpha^2 + 1 the lobe is (1 + t)^2 / (1 + t)^N, and (1 + t)^N is at least its binomial
/// series up to t^2 (N >= 2), up to t^3 for N >= 3.
void set_blinn_phong_shape(const Bsdf& bsdf, LobeBounds& bounds) {
  const float alpha2 = 2 / (bsdf.exponent + 2);
  bounds.alpha = std::sqrt(alpha2);
  bounds.c1 = 1 + alpha2, bounds.c2 = (1 + alpha2) / 2, bounds.c3 = alpha2 <= 0.5f ? (1 - alpha2 * alpha2) / 6 : 0;
  bounds.microfacets = false;
}

/// Diffuse base of plastic: transmission of the fixed side, internal scattering; transmission of the other side is 1.
Rgb plastic_base(const Bsdf& bsdf, float cos_v) {
  const float through = bsdf.kind == BsdfKind::plastic
                            ? 1 - fresnel_dielectric(cos_v, bsdf.eta).reflectance
                            : external_transmittance(bsdf.transmittance_row, bsdf.transmittance_mix, cos_v);
  const Rgb back = bsdf.nonlinear ? bsdf.reflectance * bsdf.fdr_internal : gray(bsdf.fdr_internal);
  return bsdf.reflectance / (gray(1) - back) * (bsdf.inverse_eta_squared * through * kInvPi);
}

/// Largest reflectance of a facet that turns v into any direction w above the surface: the angle between them is twice
/// that of incidence and at most a right angle plus v's, so cos^2 of incidence is at least (1 - sin v) / 2.
float largest_fresnel(const Bsdf& bsdf, float cos_v) {
  if (bsdf.kind != BsdfKind::rough_plastic) return 1;
  const float sin_v = std::sqrt(std::max(0.0f, 1 - cos_v * cos_v));
  return fresnel_dielectric(std::sqrt((1 - sin_v) / 2), bsdf.eta).reflectance;
}

}  // namespace

LobeBounds lobe_bounds(const Bsdf& bsdf, Vec3 fixed) {
  LobeBounds bounds;
  const bool rough_glass = bsdf.kind == BsdfKind::rough_dielectric;
  if (fixed.z == 0 || (fixed.z < 0 && !rough_glass)) return bounds;
  const bool blinn_phong = bsdf.kind == BsdfKind::blinn_phong;
  if (bsdf.kind == BsdfKind::diffuse || blinn_phong) bounds.diffuse = bsdf.reflectance * kInvPi;
  if (bsdf.kind == BsdfKind::plastic || bsdf.kind == BsdfKind::rough_plastic)
    bounds.diffuse = plastic_base(bsdf, fixed.z);

  if (blinn_phong && !bsdf.sharp_gloss) {
    set_blinn_phong_shape(bsdf, bounds);
    bounds.gloss = bsdf.specular * blinn_phong_peak(bsdf.exponent);
    return bounds;
  }
  const bool gloss = bsdf.kind == BsdfKind::rough_conductor || bsdf.kind == BsdfKind::rough_plastic || rough_glass;
  if (!gloss || bsdf.sharp_gloss) return bounds;
  set_shape(bsdf, bounds);
  const float shadowing = smith_g1(bsdf.distribution, bsdf.alpha, fixed, {0, 0, 1});
  constexpr float kFit = 1.0001f;  // Beckmann's fit of G1 passes 1 by this
  const float lobe = kFit * kInvPi / (bsdf.alpha * bsdf.alpha) * shadowing / std::fabs(fixed.z);
  bounds.gloss = bsdf.specular * (largest_fresnel(bsdf, fixed.z) * lobe / 4);
  if (!rough_glass) return bounds;

  // Refraction spreads into directions that the mirror says nothing about: its peak counts for all of them. With the
  // unit facet normal along i + eta o, |i + eta o| >= |1 - eta| [walter07, 16, 17]; eta^2 goes out for radiance.
  const float eta = std::max(bsdf.eta, 1 / bsdf.eta), peak = eta / std::max(eta - 1, 1e-3f);
  bounds.any = peak_gloss(bounds) + peak_gloss({{},
                                                bsdf.transmittance * (lobe * peak * peak),
                                                {},
                                                bounds.alpha,
                                                bounds.c1,
                                                bounds.c2,
                                                bounds.c3,
                                                bounds.t_least,
                                                true});
  bounds.gloss = {};
  return bounds;
}

float geometric_cosine_factor(const LobeBounds& bounds, float sine) {
  if (!bounds.microfacets) return 1;  // the cosine is left out, whichever it is
  // |w . ng| <= cos w + sine sin w, and sin w G1(w) / cos w <= 3.535 / alpha (Beckmann's fit; GGX: 2 / alpha).
  return 1 + sine * 3.535f / bounds.alpha;
}

Rgb peak_gloss(const LobeBounds& bounds) {
  const float t = bounds.t_least, x = t / (bounds.alpha * bounds.alpha);
  const float shape = (1 + t) * (1 + t) / (1 + x * (bounds.c1 + x * (bounds.c2 + x * bounds.c3)));
  return bounds.gloss * shape;
}

}  // namespace myrialux
