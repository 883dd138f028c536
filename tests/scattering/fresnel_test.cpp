// Fresnel terms against closed forms, Snell's law and numerical integrals.
#include "myrialux/scattering/fresnel.h"

#include <gtest/gtest.h>

namespace myrialux {
namespace {

TEST(Fresnel, NormalIncidenceIsTheTextbookRatio) {
  for (const float eta : {1.1f, 1.33f, 1.5046f, 2.4f, 0.6f})
    EXPECT_NEAR(fresnel_dielectric(1, eta).reflectance, std::pow((eta - 1) / (eta + 1), 2.0f), 1e-6f);
  EXPECT_NEAR(fresnel_conductor(1, gray(0.2f), gray(3.9f)).r, (0.8 * 0.8 + 3.9 * 3.9) / (1.2 * 1.2 + 3.9 * 3.9), 1e-6);
}

TEST(Fresnel, RefractionObeysSnellAndIsReversible) {
  for (const float eta : {1.2f, 1.5f, 2.0f})
    for (int step = -20; step <= 20; ++step) {
      if (step == 0) continue;
      const float cos_i = static_cast<float>(step) / 20;
      const DielectricFresnel f = fresnel_dielectric(cos_i, eta);
      if (f.reflectance >= 1) continue;
      EXPECT_LT(f.cos_transmitted * cos_i, 0);
      const float sin_i = std::sqrt(1 - cos_i * cos_i), sin_t = std::sqrt(1 - f.cos_transmitted * f.cos_transmitted);
      EXPECT_NEAR(sin_i, f.eta_it * sin_t, 2e-3f);  // sines near 0 lose digits
      EXPECT_NEAR(fresnel_dielectric(f.cos_transmitted, eta).reflectance, f.reflectance, 1e-5f);
    }
}

TEST(Fresnel, TotalReflectionStartsAtTheCriticalAngle) {
  const float eta = 1.5f, critical = std::sqrt(1 - 1 / (eta * eta));
  EXPECT_EQ(fresnel_dielectric(-(critical - 1e-3f), eta).reflectance, 1);
  EXPECT_EQ(fresnel_dielectric(-(critical - 1e-3f), eta).cos_transmitted, 0);
  EXPECT_LT(fresnel_dielectric(-(critical + 1e-3f), eta).reflectance, 1);
}

TEST(Fresnel, EqualIndicesPassEverything) {
  for (const float c : {1.0f, 0.3f, 0.0f, -0.7f}) {
    EXPECT_EQ(fresnel_dielectric(c, 1).reflectance, 0);
    EXPECT_EQ(fresnel_dielectric(c, 1).cos_transmitted, -c);
  }
}

TEST(Fresnel, GrazingLightIsReflected) {
  EXPECT_EQ(fresnel_dielectric(0, 1.5f).reflectance, 1);
  EXPECT_NEAR(fresnel_conductor(0, gray(1.1f), gray(2.1f)).r, 1, 1e-6f);
}

TEST(Fresnel, ConductorWithoutAbsorptionIsADielectric) {
  for (const float c : {0.05f, 0.2f, 0.5f, 0.8f, 1.0f})
    EXPECT_NEAR(fresnel_conductor(c, gray(1.5f), gray(0)).g, fresnel_dielectric(c, 1.5f).reflectance, 2e-6f);
}

TEST(Fresnel, PerfectMetalReflectsEverything) {
  for (const float c : {0.0f, 0.1f, 0.4f, 0.7f, 1.0f})
    EXPECT_NEAR(fresnel_conductor(c, gray(0), gray(1)).r, 1, 1e-6f) << c;
}

/// 2 int_0^1 F(mu) mu dmu
double mean_reflectance(double eta) {
  constexpr int kSteps = 200000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double mu = (i + 0.5) / kSteps;
    sum += 2 * mu * fresnel_dielectric(static_cast<float>(mu), static_cast<float>(eta)).reflectance / kSteps;
  }
  return sum;
}

TEST(Fresnel, MeanReflectanceFitsItsIntegral) {
  // Error bounds of the fits: [deon11] below 1e-3 outside; [egan73] below 0.005 inside for glass-like indices
  for (const double eta : {1.2, 1.33, 1.5046, 1.8, 2.2}) {
    EXPECT_NEAR(fresnel_diffuse_reflectance(static_cast<float>(eta)), mean_reflectance(eta), 1.5e-3) << eta;
    EXPECT_NEAR(fresnel_diffuse_reflectance(static_cast<float>(1 / eta)), mean_reflectance(1 / eta), 5e-3) << eta;
  }
}

TEST(Fresnel, MeanReflectancesFromBothSidesAgree) {
  for (const double eta : {1.33, 1.5046, 1.8})  // 1 - inside = (1 - outside) / eta^2, by reversibility
    EXPECT_NEAR(1 - mean_reflectance(1 / eta), (1 - mean_reflectance(eta)) / (eta * eta), 1e-4);
}

}  // namespace
}  // namespace myrialux
