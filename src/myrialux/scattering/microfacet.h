// Microfacet normals: density D, Smith masking G1 and sampling of visible normals, isotropic Beckmann and GGX.
// Sources: [walter07] for D and G1, [heitz14] for visible normals, [heitz18] (GGX) and [jakob14] (Beckmann) for
// sampling. All vectors are in the local frame, z = macroscopic normal; m has m.z > 0; alpha is the width of the
// slopes.
#pragma once

#include "myrialux/math/vec.h"
#include "myrialux/scene/scene.h"

namespace myrialux {

/// Smaller widths are raised to this one, so that the density stays finite in single precision.
inline constexpr float kMinAlpha = 1e-4f;

/// D(m): area of facets per solid angle of m and per area of the surface, 1/sr; integral of D(m) m.z is 1.
inline float microfacet_density(Microfacets kind, float alpha, Vec3 m) {
  const float cos2 = m.z * m.z, slope2 = (m.x * m.x + m.y * m.y) / (alpha * alpha);
  float d;
  if (kind == Microfacets::beckmann) {
    d = std::exp(-slope2 / cos2) / (kPi * alpha * alpha * cos2 * cos2);
  } else {
    const float t = slope2 + cos2;
    d = 1 / (kPi * alpha * alpha * t * t);
  }
  return d * m.z > 1e-20f ? d : 0;
}

/// Share of the facets with normal m that direction v sees. Beckmann: the rational fit of [walter07] (error < 0.35 %).
inline float smith_g1(Microfacets kind, float alpha, Vec3 v, Vec3 m) {
  if (dot(v, m) * v.z <= 0) return 0;
  const float sin2 = v.x * v.x + v.y * v.y;
  if (sin2 == 0) return 1;
  const float slope2 = alpha * alpha * sin2 / (v.z * v.z);
  if (kind == Microfacets::ggx) return 2 / (1 + std::sqrt(1 + slope2));
  const float a = 1 / std::sqrt(slope2);
  if (a >= 1.6f) return 1;
  return (3.535f * a + 2.181f * a * a) / (1 + 2.276f * a + 2.577f * a * a);
}

/// G1 without fits: what normalises the density of visible normals.
float smith_g1_exact(Microfacets kind, float alpha, Vec3 v, Vec3 m);

/// Density of sample_visible_normal(kind, alpha, v, u) per solid angle of m; v.z > 0.
inline float visible_normal_pdf_omega(Microfacets kind, float alpha, Vec3 v, Vec3 m) {
  return smith_g1_exact(kind, alpha, v, m) * std::fabs(dot(v, m)) * microfacet_density(kind, alpha, m) / v.z;
}

/// A normal among those that v sees, v.z > 0. Smooth in u but for the edges of the unit square.
Vec3 sample_visible_normal(Microfacets kind, float alpha, Vec3 v, Vec2 u);

}  // namespace myrialux
