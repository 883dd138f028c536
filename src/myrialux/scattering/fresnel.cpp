// Fresnel reflectances of dielectrics and metals, and their cosine-weighted means. Sources: [born99, 1.5 and 13.4] for
// the equations, [egan73] (from inside) and [deon11] (from outside) for the fits of the mean.
#include "myrialux/scattering/fresnel.h"

#include "myrialux/base/assert.h"

namespace myrialux {
namespace {

float fresnel_conductor_channel(float cos_i, float eta, float k);

float square(float x) { return x * x; }

}  // namespace

DielectricFresnel fresnel_dielectric(float cos_i, float eta) {
  MYRIALUX_ASSERT(eta > 0);
  const float eta_it = cos_i >= 0 ? eta : 1 / eta;
  const float cos_i_abs = std::fabs(cos_i);
  const float cos_t_squared = 1 - (1 - cos_i * cos_i) / (eta_it * eta_it);
  const float cos_t_abs = std::sqrt(std::max(0.0f, cos_t_squared));
  const float cos_t = cos_i >= 0 ? -cos_t_abs : cos_t_abs;
  if (eta == 1) return {0, -cos_i, 1};
  if (cos_i_abs == 0) return {1, cos_t, eta_it};
  const float a_s = (cos_i_abs - eta_it * cos_t_abs) / (cos_i_abs + eta_it * cos_t_abs);
  const float a_p = (cos_t_abs - eta_it * cos_i_abs) / (cos_t_abs + eta_it * cos_i_abs);
  return {0.5f * (square(a_s) + square(a_p)), cos_t, eta_it};
}

Rgb fresnel_conductor(float cos_i, Rgb eta, Rgb k) {
  return {fresnel_conductor_channel(cos_i, eta.r, k.r), fresnel_conductor_channel(cos_i, eta.g, k.g),
          fresnel_conductor_channel(cos_i, eta.b, k.b)};
}

float fresnel_diffuse_reflectance(float eta) {
  if (eta < 1) return -1.4399f * eta * eta + 0.7099f * eta + 0.6681f + 0.0636f / eta;
  const float x = 1 / eta;
  return 0.919317f + x * (-3.4793f + x * (6.75335f + x * (-7.80989f + x * (4.98554f + x * -1.36881f))));
}

namespace {

/// Exact equations for a medium of index eta + i k. With eta = 0, k = 1 everything is reflected.
float fresnel_conductor_channel(float cos_i, float eta, float k) {
  const float cos2 = cos_i * cos_i, sin2 = 1 - cos2;
  const float difference = eta * eta - k * k - sin2;
  const float a2_plus_b2 = std::sqrt(square(difference) + 4 * square(k * eta));
  const float a = std::sqrt(std::max(0.0f, 0.5f * (a2_plus_b2 + difference)));
  const float s_sum = a2_plus_b2 + cos2, s_cross = 2 * a * cos_i;
  const float r_s = (s_sum - s_cross) / (s_sum + s_cross);
  const float p_sum = a2_plus_b2 * cos2 + sin2 * sin2, p_cross = s_cross * sin2;
  const float r_p = r_s * (p_sum - p_cross) / (p_sum + p_cross);
  return 0.5f * (r_s + r_p);
}

}  // namespace
}  // namespace myrialux
