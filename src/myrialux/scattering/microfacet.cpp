// Sampling of visible microfacet normals. GGX: projected half discs [heitz18]; Beckmann: numerical inversion of the
// distribution of slopes along the plane of incidence [jakob14]. Both work on a surface stretched to alpha = 1.
#include "myrialux/scattering/microfacet.h"

#include "myrialux/base/assert.h"

namespace myrialux {
namespace {

Vec3 sample_visible_ggx(Vec3 v, Vec2 u);
Vec3 sample_visible_beckmann(Vec3 v, Vec2 u);
float visible_beckmann_slope(float cot, float u);
float erf_inverse(float x);

constexpr float kInvSqrtPi = 0.56418958354775628695f;

}  // namespace

float smith_g1_exact(Microfacets kind, float alpha, Vec3 v, Vec3 m) {
  if (kind == Microfacets::ggx) return smith_g1(kind, alpha, v, m);
  if (dot(v, m) * v.z <= 0) return 0;
  const float sin_theta = std::sqrt(v.x * v.x + v.y * v.y);
  const float a = std::fabs(v.z) / (alpha * sin_theta);
  if (!(a < 4)) return 1;  // also for sin_theta = 0; erfc(4) is below the rounding of floats
  return 2 / (1 + std::erf(a) + std::exp(-a * a) * kInvSqrtPi / a);
}

Vec3 sample_visible_normal(Microfacets kind, float alpha, Vec3 v, Vec2 u) {
  MYRIALUX_ASSERT(v.z > 0 && alpha > 0);
  const Vec3 stretched = normalize({alpha * v.x, alpha * v.y, v.z});
  const Vec3 m = kind == Microfacets::ggx ? sample_visible_ggx(stretched, u) : sample_visible_beckmann(stretched, u);
  return normalize({alpha * m.x, alpha * m.y, std::max(1e-6f, m.z)});
}

namespace {

/// Normal of the hemisphere of normals with width 1 that v sees; unit length.
Vec3 sample_visible_ggx(Vec3 v, Vec2 u) {
  const float sin2 = v.x * v.x + v.y * v.y;
  const Vec3 t1 = sin2 > 0 ? Vec3{-v.y, v.x, 0} / std::sqrt(sin2) : Vec3{1, 0, 0};
  const Vec3 t2 = cross(v, t1);
  const float r = std::sqrt(u.x), phi = 2 * kPi * u.y, s = 0.5f * (1 + v.z);
  const float p1 = r * std::cos(phi);
  const float p2 = (1 - s) * std::sqrt(std::max(0.0f, 1 - p1 * p1)) + s * r * std::sin(phi);
  return p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0f, 1 - p1 * p1 - p2 * p2)) * v;
}

/// Normal (not unit) from slopes: one along the plane of incidence by inversion, the other is Gaussian.
Vec3 sample_visible_beckmann(Vec3 v, Vec2 u) {
  const float sin_theta = std::sqrt(v.x * v.x + v.y * v.y);
  const float cos_phi = sin_theta > 0 ? v.x / sin_theta : 1, sin_phi = sin_theta > 0 ? v.y / sin_theta : 0;
  const float u_x = std::clamp(u.x, 1e-6f, 1 - 1e-6f), u_y = std::clamp(u.y, 1e-6f, 1 - 1e-6f);
  const float along = sin_theta < 1e-4f ? erf_inverse(2 * u_x - 1) : visible_beckmann_slope(v.z / sin_theta, u_x);
  const float across = erf_inverse(2 * u_y - 1);
  return {-(along * cos_phi - across * sin_phi), -(along * sin_phi + across * cos_phi), 1};
}

/// Slope s with CDF(s) = u, where with b = erf(s):
///   CDF = (1 + b + exp(-s^2) / (sqrt(pi) cot)) / (1 + erf(cot) + exp(-cot^2) / (sqrt(pi) cot)),  s <= cot.
/// Newton's method on b between brackets, from the fit of [jakob14]. @param cot of the angle of incidence
float visible_beckmann_slope(float cot, float u) {
  const float tan = 1 / cot, c = std::erf(cot);
  const float scale = 1 / (1 + c + kInvSqrtPi * tan * std::exp(-cot * cot));
  const float theta = std::atan(tan);
  const float fit = 1 + theta * (-0.876f + theta * (0.4265f - 0.0594f * theta));
  float lower = -1, upper = c, b = c - (1 + c) * std::pow(1 - u, fit);
  for (int iteration = 0; iteration < 12; ++iteration) {
    if (!(b > lower && b < upper)) b = 0.5f * (lower + upper);
    const float s = erf_inverse(b);
    const float excess = scale * (1 + b + kInvSqrtPi * tan * std::exp(-s * s)) - u;
    if (std::fabs(excess) < 1e-6f) break;
    (excess > 0 ? upper : lower) = b;
    b -= excess / (scale * (1 - s * tan));
  }
  return erf_inverse(std::clamp(b, -1 + 1e-7f, 1 - 1e-7f));
}

/// Inverse error function for |x| < 1, relative error below 4e-7. Source: [giles12]
float erf_inverse(float x) {
  float w = -std::log((1 - x) * (1 + x));
  float p;
  if (w < 5) {
    w -= 2.5f;
    p = 2.81022636e-08f;
    for (const float c : {3.43273939e-07f, -3.5233877e-06f, -4.39150654e-06f, 0.00021858087f, -0.00125372503f,
                          -0.00417768164f, 0.246640727f, 1.50140941f})
      p = c + p * w;
  } else {
    w = std::sqrt(w) - 3;
    p = -0.000200214257f;
    for (const float c : {0.000100950558f, 0.00134934322f, -0.00367342844f, 0.00573950773f, -0.0076224613f,
                          0.00943887047f, 1.00167406f, 2.83297682f})
      p = c + p * w;
  }
  return p * x;
}

}  // namespace
}  // namespace myrialux
