// Tables of rough coats: limits, order of calls, threads.
#include "myrialux/scattering/rough_transmittance.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "myrialux/scattering/fresnel.h"

namespace myrialux {
namespace {

float transmittance(const RoughTransmittance& t, float cos_theta) {
  return external_transmittance(t.row, t.mix, cos_theta);
}

TEST(RoughTransmittance, SmoothLimitIsFresnel) {
  const float eta = 1.5f;
  for (const Microfacets kind : {Microfacets::beckmann, Microfacets::ggx}) {
    const RoughTransmittance t = rough_transmittance(kind, 1e-4f, eta);
    for (int k = 8; k < 64; k += 5) {  // at nodes of the table
      const float cos_theta = static_cast<float>(k) / 63;
      EXPECT_NEAR(transmittance(t, cos_theta), 1 - fresnel_dielectric(cos_theta, eta).reflectance, 1e-3f) << k;
    }
    EXPECT_NEAR(t.internal_reflectance, fresnel_diffuse_reflectance(1 / eta), 0.01f);
  }
}

TEST(RoughTransmittance, IsAShareForAllArguments) {
  for (const float alpha : {0.0f, 0.013f, 0.3f, 1.97f, 40.0f})
    for (const float cos_theta : {0.0f, 1e-8f, 0.31f, 0x1.fffffep-1f, 1.0f}) {
      const RoughTransmittance t = rough_transmittance(Microfacets::ggx, alpha, 1.5f);
      EXPECT_GE(transmittance(t, cos_theta), 0);
      EXPECT_LE(transmittance(t, cos_theta), 1);
      EXPECT_GT(t.internal_reflectance, 0);
      EXPECT_LT(t.internal_reflectance, 1);
    }
}

TEST(RoughTransmittance, IsContinuousInAlpha) {
  for (int k = 1; k < 40; ++k) {
    const float node = static_cast<float>(k * k) / 4096;
    if (k % 8 != 0) continue;
    const RoughTransmittance below = rough_transmittance(Microfacets::ggx, node * 0.99999f, 1.5f);
    const RoughTransmittance above = rough_transmittance(Microfacets::ggx, node * 1.00001f, 1.5f);
    for (const float cos_theta : {0.1f, 0.6f}) {
      EXPECT_NEAR(transmittance(below, cos_theta), transmittance(above, cos_theta), 1e-4f);
    }
    EXPECT_NEAR(below.internal_reflectance, above.internal_reflectance, 1e-4f);
  }
}

TEST(RoughTransmittance, ThreadsGetOneTableWithTheSameNumbers) {
  std::vector<RoughTransmittance> found(8);
  std::vector<std::thread> threads;  // plain threads: they must really start at once
  for (RoughTransmittance& t : found)
    threads.emplace_back([&t] { t = rough_transmittance(Microfacets::ggx, 0.42f, 1.37f); });
  for (std::thread& thread : threads) thread.join();
  for (const RoughTransmittance& t : found) {
    EXPECT_EQ(t.row, found[0].row);
    EXPECT_EQ(t.mix, found[0].mix);
    EXPECT_EQ(t.internal_reflectance, found[0].internal_reflectance);
  }
}

}  // namespace
}  // namespace myrialux
