// Evaluates and samples metals by their visible microfacet normals. [walter07], [heitz14]
#include "myrialux/scattering/conductor.h"

#include "myrialux/scattering/fresnel.h"
#include "myrialux/scattering/microfacet.h"

namespace myrialux {

Rgb evaluate_conductor(const Bsdf& bsdf, Vec3 wi, Vec3 wo) {
  if (bsdf.kind == BsdfKind::conductor || !(wi.z > 0 && wo.z > 0)) return {};
  const Vec3 m = normalize(wi + wo);
  const float d = microfacet_density(bsdf.distribution, bsdf.alpha, m);
  const float g = smith_g1(bsdf.distribution, bsdf.alpha, wi, m) * smith_g1(bsdf.distribution, bsdf.alpha, wo, m);
  const float reflected = d * g / (4 * wo.z);
  if (!(reflected > 0)) return {};
  return bsdf.specular * fresnel_conductor(dot(wo, m), bsdf.eta_metal, bsdf.k_metal) * reflected;
}

float conductor_pdf_omega(const Bsdf& bsdf, Vec3 wi, Vec3 wo) {
  if (bsdf.kind == BsdfKind::conductor || !(wi.z > 0 && wo.z > 0)) return 0;
  const Vec3 m = normalize(wi + wo);
  return visible_normal_pdf_omega(bsdf.distribution, bsdf.alpha, wo, m) / (4 * dot(wi, m));
}

BsdfSample sample_conductor(const Bsdf& bsdf, Vec3 wo, Vec2 u) {
  if (!(wo.z > 0)) return {};
  BsdfSample s;
  s.is_sharp = bsdf.sharp_gloss;
  if (bsdf.kind == BsdfKind::conductor) {
    s.wi = reflect(wo);
    s.is_delta = true;
    s.weight = bsdf.specular * fresnel_conductor(wo.z, bsdf.eta_metal, bsdf.k_metal);
    return s;
  }
  const Vec3 m = sample_visible_normal(bsdf.distribution, bsdf.alpha, wo, u);
  s.wi = reflect(wo, m);
  if (!(s.wi.z > 0)) return s;
  s.pdf_omega = visible_normal_pdf_omega(bsdf.distribution, bsdf.alpha, wo, m) / (4 * dot(wo, m));
  if (!(s.pdf_omega > 0)) return s;
  const float seen_o =
      smith_g1(bsdf.distribution, bsdf.alpha, wo, m) / smith_g1_exact(bsdf.distribution, bsdf.alpha, wo, m);
  s.weight = bsdf.specular * fresnel_conductor(dot(wo, m), bsdf.eta_metal, bsdf.k_metal) *
             (smith_g1(bsdf.distribution, bsdf.alpha, s.wi, m) * seen_o);
  return s;
}

}  // namespace myrialux
