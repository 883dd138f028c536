// Evaluates and samples coats over diffuse bases. Sources: [jakob10] (documentation of plastic and roughplastic) for
// the models, [walter07] for the rough coat.
#include "myrialux/scattering/plastic.h"

#include "myrialux/math/warp.h"
#include "myrialux/scattering/fresnel.h"
#include "myrialux/scattering/microfacet.h"
#include "myrialux/scattering/rough_transmittance.h"

namespace myrialux {
namespace {

float coat_transmittance(const Bsdf& bsdf, float cos_theta);
Rgb base_reflectance(const Bsdf& bsdf);
float coat_choice(const Bsdf& bsdf, float cos_o, ChosenLobes lobes);

}  // namespace

void prepare_plastic(Bsdf& bsdf) {
  bsdf.inverse_eta_squared = 1 / (bsdf.eta * bsdf.eta);
  const float base = mean(bsdf.reflectance), coat = mean(bsdf.specular);
  bsdf.specular_weight = base + coat > 0 ? coat / (base + coat) : 0;
  if (bsdf.kind == BsdfKind::plastic) {
    bsdf.fdr_internal = fresnel_diffuse_reflectance(1 / bsdf.eta);
    return;
  }
  const RoughTransmittance table = rough_transmittance(bsdf.distribution, bsdf.alpha, bsdf.eta);
  bsdf.transmittance_row = table.row;
  bsdf.transmittance_mix = table.mix;
  bsdf.fdr_internal = table.internal_reflectance;
}

Rgb evaluate_plastic(const Bsdf& bsdf, Vec3 wi, Vec3 wo, ChosenLobes lobes) {
  if (!(wi.z > 0 && wo.z > 0)) return {};
  Rgb f_cos;
  if (lobes.diffuse) {
    const float through = coat_transmittance(bsdf, wi.z) * coat_transmittance(bsdf, wo.z);
    f_cos = base_reflectance(bsdf) * (kInvPi * wi.z * bsdf.inverse_eta_squared * through);
  }
  if (lobes.gloss && bsdf.kind == BsdfKind::rough_plastic) {
    const Vec3 m = normalize(wi + wo);
    const float d = microfacet_density(bsdf.distribution, bsdf.alpha, m);
    const float g = smith_g1(bsdf.distribution, bsdf.alpha, wi, m) * smith_g1(bsdf.distribution, bsdf.alpha, wo, m);
    f_cos += bsdf.specular * (fresnel_dielectric(dot(wo, m), bsdf.eta).reflectance * d * g / (4 * wo.z));
  }
  return f_cos;
}

float plastic_pdf_omega(const Bsdf& bsdf, Vec3 wi, Vec3 wo, ChosenLobes lobes) {
  if (!(wi.z > 0 && wo.z > 0)) return 0;
  const float p_coat = coat_choice(bsdf, wo.z, lobes);
  float density = 0;
  if (lobes.diffuse) density += (1 - p_coat) * cosine_hemisphere_pdf_omega(wi.z);
  if (lobes.gloss && bsdf.kind == BsdfKind::rough_plastic) {
    const Vec3 m = normalize(wi + wo);
    density += p_coat * visible_normal_pdf_omega(bsdf.distribution, bsdf.alpha, wo, m) / (4 * dot(wi, m));
  }
  return density;
}

BsdfSample sample_plastic(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, ChosenLobes lobes) {
  if (!(wo.z > 0) || !lobes.any()) return {};
  const float p_coat = coat_choice(bsdf, wo.z, lobes);
  const bool coat = u_lobe < p_coat;
  BsdfSample s;
  s.is_sharp = coat && bsdf.sharp_gloss;
  if (coat && bsdf.kind == BsdfKind::plastic) {
    s.wi = reflect(wo);
    s.is_delta = true;
    s.weight = bsdf.specular * (fresnel_dielectric(wo.z, bsdf.eta).reflectance / p_coat);
    return s;
  }
  s.wi = coat ? reflect(wo, sample_visible_normal(bsdf.distribution, bsdf.alpha, wo, u)) : sample_cosine_hemisphere(u);
  s.pdf_omega = plastic_pdf_omega(bsdf, s.wi, wo, lobes);
  if (s.pdf_omega > 0) s.weight = evaluate_plastic(bsdf, s.wi, wo, lobes) * (1 / s.pdf_omega);
  return s;
}

float coat_probability(const Bsdf& bsdf, float cos_o) {
  const float through = coat_transmittance(bsdf, cos_o);
  const float coat = (1 - through) * bsdf.specular_weight, base = through * (1 - bsdf.specular_weight);
  return coat + base > 0 ? coat / (coat + base) : 0;
}

namespace {

/// Share of light along a direction that passes the coat.
float coat_transmittance(const Bsdf& bsdf, float cos_theta) {
  if (bsdf.kind == BsdfKind::plastic) return 1 - fresnel_dielectric(cos_theta, bsdf.eta).reflectance;
  return external_transmittance(bsdf.transmittance_row, bsdf.transmittance_mix, cos_theta);
}

/// Reflectance of the base with scattering back and forth below the coat.
Rgb base_reflectance(const Bsdf& bsdf) {
  const Rgb returned = bsdf.nonlinear ? bsdf.reflectance * bsdf.fdr_internal : gray(bsdf.fdr_internal);
  return bsdf.reflectance / (gray(1) - returned);
}

float coat_choice(const Bsdf& bsdf, float cos_o, ChosenLobes lobes) {
  if (!lobes.diffuse || !lobes.gloss) return lobes.gloss ? 1 : 0;
  return coat_probability(bsdf, cos_o);
}

}  // namespace
}  // namespace myrialux
