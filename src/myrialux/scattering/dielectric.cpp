// Evaluates and samples dielectric boundaries. [walter07, eqs. 16-21], visible normals of [heitz14]
#include "myrialux/scattering/dielectric.h"

#include "myrialux/scattering/fresnel.h"
#include "myrialux/scattering/microfacet.h"

namespace myrialux {
namespace {

/// The microfacet that turns wi into wo, on the side of the normal, and the boundary it is part of.
struct Facet {
  Vec3 m;
  bool reflects = false;
  float eta = 1;               ///< index on the side of wi / index on the side of wo; 1 for reflection
  float cos_i = 0, cos_o = 0;  ///< dot(wi, m), dot(wo, m)
};

bool find_facet(const Bsdf& bsdf, Vec3 wi, Vec3 wo, Facet& facet);
float refraction_jacobian(float cos_i, float cos_o, float eta);
BsdfSample sample_smooth(const Bsdf& bsdf, Vec3 wo, float u_lobe, TransportMode mode);
BsdfSample sample_thin(const Bsdf& bsdf, Vec3 wo, float u_lobe);
BsdfSample sample_rough(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, TransportMode mode);

Vec3 refract(Vec3 wo, Vec3 m, const DielectricFresnel& f) {
  return m * (dot(wo, m) / f.eta_it + f.cos_transmitted) - wo / f.eta_it;
}

Vec3 to_upper(Vec3 w) { return w.z < 0 ? -w : w; }

}  // namespace

Rgb evaluate_dielectric(const Bsdf& bsdf, Vec3 wi, Vec3 wo) {
  Facet facet;
  if (bsdf.kind != BsdfKind::rough_dielectric || !find_facet(bsdf, wi, wo, facet)) return {};
  const float d = microfacet_density(bsdf.distribution, bsdf.alpha, facet.m);
  const float g =
      smith_g1(bsdf.distribution, bsdf.alpha, wi, facet.m) * smith_g1(bsdf.distribution, bsdf.alpha, wo, facet.m);
  const float f = fresnel_dielectric(facet.cos_o, bsdf.eta).reflectance;
  if (facet.reflects) return bsdf.specular * (f * d * g / (4 * std::fabs(wo.z)));
  const float radiance_factor = 1 / (facet.eta * facet.eta);
  return bsdf.transmittance * (radiance_factor * (1 - f) * d * g * std::fabs(facet.cos_o / wo.z) *
                               refraction_jacobian(facet.cos_i, facet.cos_o, facet.eta));
}

float dielectric_pdf_omega(const Bsdf& bsdf, Vec3 wi, Vec3 wo) {
  Facet facet;
  if (bsdf.kind != BsdfKind::rough_dielectric || !find_facet(bsdf, wi, wo, facet)) return 0;
  const float f = fresnel_dielectric(facet.cos_o, bsdf.eta).reflectance;
  const float density =
      visible_normal_pdf_omega(bsdf.distribution, bsdf.alpha, to_upper(wo), facet.m * std::copysign(1.0f, facet.m.z));
  return facet.reflects ? density * f / (4 * std::fabs(facet.cos_i))
                        : density * (1 - f) * refraction_jacobian(facet.cos_i, facet.cos_o, facet.eta);
}

BsdfSample sample_dielectric(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, TransportMode mode) {
  if (wo.z == 0) return {};
  switch (bsdf.kind) {
    case BsdfKind::dielectric:
      return sample_smooth(bsdf, wo, u_lobe, mode);
    case BsdfKind::thin_dielectric:
      return sample_thin(bsdf, wo, u_lobe);
    case BsdfKind::rough_dielectric:
      return sample_rough(bsdf, wo, u_lobe, u, mode);
    default: {  // null: goes straight on
      BsdfSample s;
      s.wi = -wo;
      s.weight = gray(1);
      s.is_delta = s.is_sharp = s.is_transmission = true;
      return s;
    }
  }
}

namespace {

/// False where no facet serves: grazing directions, or a facet that wi or wo sees from the wrong side.
bool find_facet(const Bsdf& bsdf, Vec3 wi, Vec3 wo, Facet& facet) {
  if (wi.z == 0 || wo.z == 0) return false;
  facet.reflects = wi.z * wo.z > 0;
  facet.eta = facet.reflects ? 1 : wo.z > 0 ? bsdf.eta : 1 / bsdf.eta;
  const Vec3 half = wo + wi * facet.eta;
  if (length_squared(half) == 0) return false;  // straight through an index of 1
  facet.m = to_upper(normalize(half));
  facet.cos_i = dot(wi, facet.m);
  facet.cos_o = dot(wo, facet.m);
  return facet.cos_i * wi.z > 0 && facet.cos_o * wo.z > 0;
}

/// Solid angle of m per solid angle of wi. [walter07, eq. 17]
float refraction_jacobian(float cos_i, float cos_o, float eta) {
  const float sum = cos_o + eta * cos_i;
  return eta * eta * std::fabs(cos_i) / (sum * sum);
}

BsdfSample sample_smooth(const Bsdf& bsdf, Vec3 wo, float u_lobe, TransportMode mode) {
  const DielectricFresnel f = fresnel_dielectric(wo.z, bsdf.eta);
  BsdfSample s;
  s.is_delta = s.is_sharp = true;
  if (u_lobe < f.reflectance) {
    s.wi = reflect(wo);
    s.weight = bsdf.specular;
    return s;
  }
  s.is_transmission = true;
  s.eta = f.eta_it;
  s.wi = refract(wo, {0, 0, 1}, f);
  s.weight = bsdf.transmittance * (mode == TransportMode::radiance ? 1 / (s.eta * s.eta) : 1);
  return s;
}

/// Two parallel boundaries, all reflections between them summed: R + T R T + ... = 2 R / (1 + R).
BsdfSample sample_thin(const Bsdf& bsdf, Vec3 wo, float u_lobe) {
  const float r = fresnel_dielectric(std::fabs(wo.z), bsdf.eta).reflectance;
  BsdfSample s;
  s.is_delta = s.is_sharp = true;
  s.is_transmission = !(u_lobe < 2 * r / (1 + r));
  s.wi = s.is_transmission ? -wo : reflect(wo);
  s.weight = s.is_transmission ? bsdf.transmittance : bsdf.specular;
  return s;
}

BsdfSample sample_rough(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, TransportMode mode) {
  const Vec3 m = sample_visible_normal(bsdf.distribution, bsdf.alpha, to_upper(wo), u);
  const DielectricFresnel f = fresnel_dielectric(dot(wo, m), bsdf.eta);
  const float density = visible_normal_pdf_omega(bsdf.distribution, bsdf.alpha, to_upper(wo), m);
  BsdfSample s;
  s.is_sharp = bsdf.sharp_gloss;
  s.is_transmission = !(u_lobe < f.reflectance);
  s.wi = s.is_transmission ? refract(wo, m, f) : reflect(wo, m);
  if (!(density > 0) || !((s.wi.z * wo.z > 0) != s.is_transmission)) return s;
  const float cos_i = dot(s.wi, m);
  Rgb factor = bsdf.specular;
  if (s.is_transmission) {
    s.eta = f.eta_it;
    s.pdf_omega = density * (1 - f.reflectance) * refraction_jacobian(cos_i, dot(wo, m), f.eta_it);
    factor = bsdf.transmittance * (mode == TransportMode::radiance ? 1 / (s.eta * s.eta) : 1);
  } else {
    s.pdf_omega = density * f.reflectance / (4 * std::fabs(cos_i));
  }
  const float seen_o =
      smith_g1(bsdf.distribution, bsdf.alpha, wo, m) / smith_g1_exact(bsdf.distribution, bsdf.alpha, wo, m);
  s.weight = factor * (smith_g1(bsdf.distribution, bsdf.alpha, s.wi, m) * seen_o);
  return s;
}

}  // namespace
}  // namespace myrialux
