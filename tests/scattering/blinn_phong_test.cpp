// Blinn-Phong by its numbers: normalisation, exponents, colours that add up to more than 1.
#include "myrialux/scattering/blinn_phong.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bsdf_cases.h"

namespace myrialux::testing {
namespace {

/// Share of the light along wo that a white lobe scatters: midpoint rule over the hemisphere of wi, in theta and phi.
double scattered_share(const Bsdf& bsdf, Vec3 wo) {
  constexpr int kSteps = 500;  // the narrowest lobe is 20 steps wide
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const auto middle = [](int cell) { return (static_cast<float>(cell) + 0.5f) / kSteps; };
      const Vec3 wi = direction(90 * middle(i), 180 * middle(j));  // the other half is its mirror image
      sum += static_cast<double>(evaluate(bsdf, wi, wo, Lobes::all).g * std::sqrt(1 - wi.z * wi.z));
    }
  return sum * static_cast<double>(kPi * kPi) / (kSteps * kSteps);
}

Bsdf white_lobe(float exponent) {
  BsdfCase c = blinn_phong(exponent);
  c.params.reflectance = {};
  c.params.specular = gray(1);
  return c.bsdf();
}

TEST(BlinnPhong, ReflectsAllOfKsAlongTheNormalAndLessElsewhere) {
  for (const float exponent : {0.01f, 0.5f, 1.0f, 2.0f, 5.0f, 10.0f, 30.0f, 100.0f, 300.0f, 1000.0f}) {
    const Bsdf bsdf = white_lobe(exponent);
    double before = scattered_share(bsdf, {0, 0, 1});
    EXPECT_NEAR(before, 1, 1e-3) << exponent;
    for (const float angle : {10.0f, 25.0f, 40.0f, 55.0f, 70.0f, 80.0f, 89.0f}) {
      const double share = scattered_share(bsdf, direction(angle, 0));
      EXPECT_LT(share, before + 1e-4) << exponent << " at " << angle;
      before = share;
    }
  }
}

TEST(BlinnPhong, FallsAsThePowerOfTheHalfVectorsCosine) {
  for (const float exponent : {1.0f, 20.0f, 150.0f, 1000.0f, 1e5f}) {
    const Bsdf bsdf = white_lobe(exponent);
    EXPECT_NEAR(bsdf.exponent / exponent, 1, 1e-5f);
    const Vec3 wo = direction(30, 0);
    const double peak = static_cast<double>(evaluate(bsdf, direction(30, 180), wo, Lobes::all).r / wo.z);
    const double n = static_cast<double>(exponent);
    EXPECT_NEAR(peak, (n + 2) * (n + 4) / (8 * 3.14159265358979 * (n + std::pow(2, -n / 2))), 1e-5 * peak);
    for (const float degrees : {1.0f, 5.0f}) {  // in the plane of incidence the half vector turns half as far
      const Vec3 wi = direction(30 + 2 * degrees, 180);
      const double fall = static_cast<double>(evaluate(bsdf, wi, wo, Lobes::all).r / wi.z) / peak;
      // Angles are known to 6e-8, which n tan multiplies.
      EXPECT_NEAR(fall, std::pow(std::cos(static_cast<double>(degrees) * 3.14159265358979 / 180), n),
                  1e-5 + 4e-7 * n * fall);
    }
  }
}

TEST(BlinnPhong, RoughnessAndExponentAreOneAnothersInverse) {
  for (const float exponent : {0.0f, 1.0f, 98.0f, 1000.0f})
    EXPECT_NEAR(blinn_phong_exponent(blinn_phong_alpha(exponent)), exponent, 1e-5f * exponent + 1e-6f);
  EXPECT_EQ(blinn_phong_exponent(1.5f), 0);
}

TEST(BlinnPhong, ColoursThatAddUpToMoreThanOneAreScaledTogether) {
  BsdfCase c = blinn_phong(50);
  c.params.reflectance = {1, 0.5f, 0.2f};
  c.params.specular = {0.25f, 0.75f, 0.1f};
  const Bsdf bsdf = c.bsdf();
  EXPECT_FLOAT_EQ(bsdf.reflectance.r, 0.8f);
  EXPECT_FLOAT_EQ(bsdf.reflectance.b, 0.16f);
  EXPECT_FLOAT_EQ(bsdf.specular.g, 0.6f);
  c.params.reflectance = {0.3f, 0.25f, 0.2f};
  EXPECT_EQ(c.bsdf().reflectance, c.params.reflectance);
  EXPECT_EQ(c.bsdf().specular, c.params.specular);
}

TEST(BlinnPhong, LargeExponentsAreSharp) {
  for (const float exponent : {150.0f, 197.0f, 199.0f, 1000.0f})  // alpha = 0.1 at 198
    EXPECT_EQ(has_lobes(blinn_phong(exponent).bsdf(), Lobes::sharp), exponent > 198);
  const BsdfCase c = blinn_phong(1000);
  const Vec3 wo = direction(20, 0), mirror = direction(20, 180);
  const Bsdf bsdf = c.bsdf();
  EXPECT_EQ(evaluate(bsdf, mirror, wo, Lobes::wide), bsdf.reflectance * (kInvPi * mirror.z));
  EXPECT_NEAR(evaluate(bsdf, mirror, wo, Lobes::sharp).g, bsdf.specular.g * 1006 / (8 * kPi) * mirror.z, 1e-2f);
}

}  // namespace
}  // namespace myrialux::testing
