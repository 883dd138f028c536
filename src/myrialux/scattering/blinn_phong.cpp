// Evaluates and samples Blinn-Phong lobes by their half vectors. [blinn77]
// Powers of the cosine are taken through the tangent, cos^n = exp(-n/2 log(1 + tan^2)), which keeps the small angles
// that matter under large exponents.
#include "myrialux/scattering/blinn_phong.h"

#include "myrialux/math/warp.h"

namespace myrialux {
namespace {

float lobe(float exponent, Vec3 wi, Vec3 wo);
float gloss_choice(const Bsdf& bsdf, ChosenLobes lobes);
Vec3 sample_half_vector(float exponent, Vec2 u);

}  // namespace

float blinn_phong_peak(float exponent) {
  // The integral of cos^n(h) cos wi over wi for wo along the normal is 8 pi (n + 2^(-n/2)) / ((n + 2) (n + 4)).
  return (exponent + 2) * (exponent + 4) / (8 * kPi * (exponent + std::exp2(-0.5f * exponent)));
}

void prepare_blinn_phong(Bsdf& bsdf) {
  bsdf.exponent = blinn_phong_exponent(bsdf.alpha);
  const float most = max_component(bsdf.reflectance + bsdf.specular);
  if (most > 1) bsdf.reflectance = bsdf.reflectance / gray(most), bsdf.specular = bsdf.specular / gray(most);
  const float base = mean(bsdf.reflectance), gloss = mean(bsdf.specular);
  bsdf.specular_weight = base + gloss > 0 ? gloss / (base + gloss) : 0;
}

Rgb evaluate_blinn_phong(const Bsdf& bsdf, Vec3 wi, Vec3 wo, ChosenLobes lobes) {
  if (!(wi.z > 0 && wo.z > 0)) return {};
  Rgb f_cos;
  if (lobes.diffuse) f_cos = bsdf.reflectance * (kInvPi * wi.z);
  if (lobes.gloss) f_cos += bsdf.specular * (blinn_phong_peak(bsdf.exponent) * lobe(bsdf.exponent, wi, wo) * wi.z);
  return f_cos;
}

float blinn_phong_pdf_omega(const Bsdf& bsdf, Vec3 wi, Vec3 wo, ChosenLobes lobes) {
  if (!(wi.z > 0 && wo.z > 0)) return 0;
  const float p_gloss = gloss_choice(bsdf, lobes);
  float density = 0;
  if (lobes.diffuse) density += (1 - p_gloss) * cosine_hemisphere_pdf_omega(wi.z);
  if (lobes.gloss) {
    const float pdf_half = (bsdf.exponent + 1) * 0.5f * kInvPi * lobe(bsdf.exponent, wi, wo);
    density += p_gloss * pdf_half / (2 * length(wi + wo));  // |wi + wo| = 2 wi . h
  }
  return density;
}

BsdfSample sample_blinn_phong(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, ChosenLobes lobes) {
  if (!(wo.z > 0) || !lobes.any()) return {};
  const bool gloss = u_lobe < gloss_choice(bsdf, lobes);
  BsdfSample s;
  s.is_sharp = gloss && bsdf.sharp_gloss;
  s.wi = gloss ? reflect(wo, sample_half_vector(bsdf.exponent, u)) : sample_cosine_hemisphere(u);
  s.pdf_omega = blinn_phong_pdf_omega(bsdf, s.wi, wo, lobes);
  if (s.pdf_omega > 0) s.weight = evaluate_blinn_phong(bsdf, s.wi, wo, lobes) * (1 / s.pdf_omega);
  return s;
}

namespace {

/// cos^n of the half vector's angle.
float lobe(float exponent, Vec3 wi, Vec3 wo) {
  const Vec3 h = wi + wo;
  return std::exp(-0.5f * exponent * std::log1p((h.x * h.x + h.y * h.y) / (h.z * h.z)));
}

float gloss_choice(const Bsdf& bsdf, ChosenLobes lobes) {
  if (!lobes.diffuse || !lobes.gloss) return lobes.gloss ? 1 : 0;
  return bsdf.specular_weight;
}

/// Density (n + 1) / (2 pi) cos^n per solid angle of the half vector.
Vec3 sample_half_vector(float exponent, Vec2 u) {
  const float log_cos2 = 2 * std::log1p(-u.x) / (exponent + 1), phi = 2 * kPi * u.y;
  const float sin_theta = std::sqrt(-std::expm1(log_cos2));
  return {sin_theta * std::cos(phi), sin_theta * std::sin(phi), std::exp(0.5f * log_cos2)};
}

}  // namespace
}  // namespace myrialux
