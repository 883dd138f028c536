// Chooses the model of a BSDF and the lobes that take part; the models themselves have a file each.
#include "myrialux/scattering/bsdf.h"

#include "myrialux/math/warp.h"
#include "myrialux/scattering/blinn_phong.h"
#include "myrialux/scattering/conductor.h"
#include "myrialux/scattering/dielectric.h"
#include "myrialux/scattering/fresnel.h"
#include "myrialux/scattering/lobes.h"
#include "myrialux/scattering/microfacet.h"
#include "myrialux/scattering/plastic.h"

namespace myrialux {
namespace {

/// The models, several kinds each.
enum class Model : std::uint8_t { diffuse, conductor, plastic, blinn_phong, dielectric };
Model model_of(BsdfKind kind);

Rgb clamp01(Rgb c) { return {std::clamp(c.r, 0.0f, 1.0f), std::clamp(c.g, 0.0f, 1.0f), std::clamp(c.b, 0.0f, 1.0f)}; }

}  // namespace

Bsdf make_bsdf(const Material& material, const BsdfParams& params, float sharp_alpha) {
  Bsdf bsdf;
  bsdf.kind = material.kind;
  bsdf.distribution = material.distribution;
  bsdf.nonlinear = material.nonlinear;
  bsdf.two_sided = material.two_sided;
  bsdf.alpha = std::max(params.alpha, kMinAlpha);
  bsdf.sharp_gloss = is_delta_kind(bsdf.kind) || (bsdf.kind != BsdfKind::diffuse && params.alpha < sharp_alpha);
  bsdf.eta = material.eta;
  bsdf.specular = params.specular;
  switch (model_of(bsdf.kind)) {
    case Model::diffuse:
      bsdf.reflectance = params.reflectance;
      break;
    case Model::conductor:
      bsdf.eta_metal = material.eta_metal;
      bsdf.k_metal = material.k_metal;
      break;
    case Model::plastic:
      bsdf.reflectance = params.reflectance;
      prepare_plastic(bsdf);
      break;
    case Model::blinn_phong:
      bsdf.reflectance = params.reflectance;
      prepare_blinn_phong(bsdf);
      break;
    case Model::dielectric:
      bsdf.transmittance = params.reflectance;  // see BsdfParams
      break;
  }
  return bsdf;
}

bool has_lobes(const Bsdf& bsdf, Lobes lobes) {
  const ChosenLobes chosen = choose_lobes(bsdf, lobes);
  if (chosen.diffuse && !is_black(bsdf.reflectance)) return true;
  if (!chosen.gloss) return false;
  return bsdf.kind == BsdfKind::null || !is_black(bsdf.specular) || !is_black(bsdf.transmittance);
}

Rgb evaluate(const Bsdf& bsdf, Vec3 wi, Vec3 wo, Lobes lobes) {
  const ChosenLobes chosen = choose_lobes(bsdf, lobes);
  if (!chosen.any()) return {};
  switch (model_of(bsdf.kind)) {
    case Model::diffuse:
      return wi.z > 0 && wo.z > 0 ? bsdf.reflectance * (kInvPi * wi.z) : Rgb{};
    case Model::conductor:
      return evaluate_conductor(bsdf, wi, wo);
    case Model::plastic:
      return evaluate_plastic(bsdf, wi, wo, chosen);
    case Model::blinn_phong:
      return evaluate_blinn_phong(bsdf, wi, wo, chosen);
    case Model::dielectric:
      return evaluate_dielectric(bsdf, wi, wo);
  }
  return {};
}

float pdf_omega(const Bsdf& bsdf, Vec3 wi, Vec3 wo, Lobes lobes) {
  const ChosenLobes chosen = choose_lobes(bsdf, lobes);
  if (!chosen.any()) return 0;
  switch (model_of(bsdf.kind)) {
    case Model::diffuse:
      return wo.z > 0 ? cosine_hemisphere_pdf_omega(wi.z) : 0;
    case Model::conductor:
      return conductor_pdf_omega(bsdf, wi, wo);
    case Model::plastic:
      return plastic_pdf_omega(bsdf, wi, wo, chosen);
    case Model::blinn_phong:
      return blinn_phong_pdf_omega(bsdf, wi, wo, chosen);
    case Model::dielectric:
      return dielectric_pdf_omega(bsdf, wi, wo);
  }
  return 0;
}

BsdfSample sample(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, Lobes lobes, TransportMode mode) {
  const ChosenLobes chosen = choose_lobes(bsdf, lobes);
  if (!chosen.any()) return {};
  switch (model_of(bsdf.kind)) {
    case Model::diffuse: {
      BsdfSample s;
      if (!(wo.z > 0)) return s;
      s.wi = sample_cosine_hemisphere(u);
      s.pdf_omega = cosine_hemisphere_pdf_omega(s.wi.z);
      if (s.pdf_omega > 0) s.weight = bsdf.reflectance;
      return s;
    }
    case Model::conductor:
      return sample_conductor(bsdf, wo, u);
    case Model::plastic:
      return sample_plastic(bsdf, wo, u_lobe, u, chosen);
    case Model::blinn_phong:
      return sample_blinn_phong(bsdf, wo, u_lobe, u, chosen);
    case Model::dielectric:
      return sample_dielectric(bsdf, wo, u_lobe, u, mode);
  }
  return {};
}

float sharp_probability(const Bsdf& bsdf, Vec3 wo) {
  const bool sharp = has_lobes(bsdf, Lobes::sharp), wide = has_lobes(bsdf, Lobes::wide);
  if (!sharp || !wide) return sharp ? 1 : 0;
  // Both kinds exist only in gloss over diffuse bases. Bounds keep both choices possible at grazing and black ends.
  constexpr float kLeast = 1e-3f;
  const float gloss =
      bsdf.kind == BsdfKind::blinn_phong ? bsdf.specular_weight : coat_probability(bsdf, std::clamp(wo.z, 0.0f, 1.0f));
  return std::clamp(gloss, kLeast, 1 - kLeast);
}

Rgb albedo(const Bsdf& bsdf) {
  switch (model_of(bsdf.kind)) {
    case Model::diffuse:
    case Model::plastic:
      return clamp01(bsdf.reflectance);
    case Model::blinn_phong:
      return clamp01(bsdf.reflectance + bsdf.specular);
    case Model::conductor:
      return clamp01(bsdf.specular * fresnel_conductor(1, bsdf.eta_metal, bsdf.k_metal));
    case Model::dielectric: {
      if (bsdf.kind == BsdfKind::null) return gray(1);
      const float r = fresnel_dielectric(1, bsdf.eta).reflectance;
      return clamp01(bsdf.specular * r + bsdf.transmittance * (1 - r));
    }
  }
  return {};
}

namespace {

Model model_of(BsdfKind kind) {
  switch (kind) {
    case BsdfKind::diffuse:
      return Model::diffuse;
    case BsdfKind::conductor:
    case BsdfKind::rough_conductor:
      return Model::conductor;
    case BsdfKind::plastic:
    case BsdfKind::rough_plastic:
      return Model::plastic;
    case BsdfKind::blinn_phong:
      return Model::blinn_phong;
    case BsdfKind::dielectric:
    case BsdfKind::thin_dielectric:
    case BsdfKind::rough_dielectric:
    case BsdfKind::null:
      break;
  }
  return Model::dielectric;
}

}  // namespace
}  // namespace myrialux
