// The BSDFs that the tests go through: every kind, both distributions, a row of roughnesses.
#pragma once

#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "myrialux/scattering/bsdf.h"

namespace myrialux::testing {

inline const std::vector<float> kAlphas{0.05f, 0.2f, 0.5f, 0.9f};

struct BsdfCase {
  std::string name;
  Material material;
  BsdfParams params;
  Bsdf bsdf(float sharp_alpha = kDefaultSharpAlpha) const { return make_bsdf(material, params, sharp_alpha); }
};

inline void PrintTo(const BsdfCase& c, std::ostream* out) { *out << c.name; }

inline std::string name_of(BsdfKind kind) {
  switch (kind) {
    case BsdfKind::diffuse:
      return "diffuse";
    case BsdfKind::conductor:
      return "conductor";
    case BsdfKind::rough_conductor:
      return "roughconductor";
    case BsdfKind::plastic:
      return "plastic";
    case BsdfKind::rough_plastic:
      return "roughplastic";
    case BsdfKind::blinn_phong:
      return "blinnphong";
    case BsdfKind::dielectric:
      return "dielectric";
    case BsdfKind::thin_dielectric:
      return "thindielectric";
    case BsdfKind::rough_dielectric:
      return "roughdielectric";
    case BsdfKind::null:
      return "null";
  }
  return "";
}

inline bool is_dielectric(BsdfKind kind) {
  return kind == BsdfKind::dielectric || kind == BsdfKind::thin_dielectric || kind == BsdfKind::rough_dielectric;
}

inline bool is_rough(BsdfKind kind) {
  return kind == BsdfKind::rough_conductor || kind == BsdfKind::rough_plastic || kind == BsdfKind::rough_dielectric ||
         kind == BsdfKind::blinn_phong;
}

/// Colours of make_mitsuba_values.py.
inline BsdfCase make_case(BsdfKind kind, Microfacets distribution, float alpha, float eta = 1.5046f,
                          bool nonlinear = false) {
  BsdfCase c;
  c.material.kind = kind;
  c.material.distribution = distribution;
  c.material.eta = eta;
  c.material.nonlinear = nonlinear;
  c.material.eta_metal = {0.2f, 0.92f, 1.1f};
  c.material.k_metal = {3.9f, 2.45f, 2.14f};
  c.params.material = static_cast<MaterialId>(0);
  c.params.alpha = alpha;
  c.params.specular = {0.9f, 0.7f, 0.5f};
  c.params.reflectance = is_dielectric(kind) ? Rgb{0.8f, 0.9f, 0.6f} : Rgb{0.2f, 0.5f, 0.8f};
  c.name = name_of(kind);
  if (kind == BsdfKind::blinn_phong)
    c.name += "_" + std::to_string(static_cast<int>(std::lround(alpha * 1000)));
  else if (is_rough(kind))
    c.name += (distribution == Microfacets::ggx ? "_ggx_" : "_beckmann_") +
              std::to_string(static_cast<int>(std::lround(alpha * 100)));
  return c;
}

/// @param exponent Ns of an MTL file; diffuse and glossy parts of the colours above, scaled to reflect no more than 1
inline BsdfCase blinn_phong(float exponent) {
  return make_case(BsdfKind::blinn_phong, Microfacets::beckmann, std::sqrt(2 / (exponent + 2)));
}

/// Same, but nothing is absorbed where the model has a choice: white colours, a perfectly reflecting metal.
inline BsdfCase lossless(BsdfCase c) {
  c.material.eta_metal = {0, 0, 0};
  c.material.k_metal = {1, 1, 1};
  c.params.reflectance = c.params.specular = gray(1);
  return c;
}

inline std::vector<BsdfCase> all_cases() {
  std::vector<BsdfCase> cases;
  for (const BsdfKind kind : {BsdfKind::diffuse, BsdfKind::conductor, BsdfKind::plastic, BsdfKind::dielectric,
                              BsdfKind::thin_dielectric, BsdfKind::null})
    cases.push_back(make_case(kind, Microfacets::ggx, 0));
  for (const BsdfKind kind : {BsdfKind::rough_conductor, BsdfKind::rough_plastic, BsdfKind::rough_dielectric})
    for (const Microfacets distribution : {Microfacets::beckmann, Microfacets::ggx})
      for (const float alpha : kAlphas) cases.push_back(make_case(kind, distribution, alpha));
  for (const float exponent : {0.5f, 3.0f, 48.0f, 1000.0f}) cases.push_back(blinn_phong(exponent));
  return cases;
}

inline Vec3 direction(float theta_deg, float phi_deg) {
  const float t = theta_deg * kPi / 180, p = phi_deg * kPi / 180;
  return {std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
}

inline std::string name_of(Lobes lobes) {
  return lobes == Lobes::wide ? "wide" : lobes == Lobes::sharp ? "sharp" : "all";
}

}  // namespace myrialux::testing
