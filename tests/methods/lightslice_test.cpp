// LightSlice against brute force on the same receivers and lights: exact at its limit, unbiased, better with more
// clusters.
#include <gtest/gtest.h>

#include <cmath>

#include "myrialux/base/parallel.h"
#include "myrialux/scene/load.h"
#include "support/method_frame.h"
#include "support/scenes.h"
#include "support/statistics.h"

namespace myrialux {
namespace {

using test::MethodFrame;
using test::relative_rmse;

TEST(LightSlice, OneLightPerClusterEqualsBruteForce) {
  MethodFrame f(test::cornell_box(), 300, 24);
  f.params.cut.n_clusters = 100000;
  // Sums of 300 terms in another order: each side is off by at most 300 ulps of the sum of magnitudes.
  EXPECT_LT(relative_rmse(f.run("brute-force").radiance, f.run("lightslice").radiance), 300 * 6e-8);
}

TEST(LightSlice, OneLightPerClusterEqualsBruteForceOnGlossyFloor) {
  MethodFrame f(test::glossy_floor_box(0.3f), 300, 24);
  f.params.cut.n_clusters = 100000;
  // The kernels' rational approximations add to the order of summation; their bound is tested in tests/shading.
  EXPECT_LT(relative_rmse(f.run("brute-force").radiance, f.run("lightslice").radiance), 1e-4);
}

/// Mean over passes of the frame's light, relative to every light's.
test::Sample mean_over_passes(MethodFrame& f, std::uint32_t n_passes) {
  const auto sum = [](const std::vector<Rgb>& radiance) {
    double s = 0;
    for (const Rgb& c : radiance) s += static_cast<double>(luminance(c));
    return s;
  };
  const double truth = sum(f.run("brute-force").radiance);
  test::Sample mean;
  for (std::uint32_t pass = 0; pass < n_passes; ++pass) {
    f.params.key = f.params.tree.key = {3, pass};
    mean.add(sum(f.run("lightslice").radiance) / truth);
  }
  return mean;
}

TEST(LightSlice, WithAShareDrawnByPowerIsUnbiasedOverPasses) {
  MethodFrame f(test::cornell_box(), 200, 24);
  f.params.cut.n_clusters = 20;
  f.params.lightslice.power_share = 0.1f;
  for (const float local : {0.0f, 0.9f}) {
    f.params.lightslice.local_share = local;
    const test::Sample mean = mean_over_passes(f, 300);
    EXPECT_LT(std::abs(test::z_score(mean, 1)), 4) << "local share " << local << ": mean " << mean.mean;
  }
}

TEST(LightSlice, AsPublishedLosesOnlyLightThatNoRowSees) {
  MethodFrame f(test::cornell_box(), 200, 24);
  f.params.cut.n_clusters = 20;
  f.params.lightslice.power_share = 0;
  f.params.lightslice.local_share = 0;
  const test::Sample mean = mean_over_passes(f, 300);
  // Nine rows see nearly all lights here. Measured: 0.998.
  EXPECT_LT(mean.mean, 1 + 4 * std::sqrt(mean.variance_of_mean()));
  EXPECT_GT(mean.mean, 0.98);
}

TEST(LightSlice, ErrorFallsAsClustersGrow) {
  MethodFrame f(test::cornell_box(), 5000, 32);
  const std::vector<Rgb> truth = f.run("brute-force").radiance;
  double last = 1e9;
  for (const std::uint32_t n : {30u, 120u, 500u, 2000u}) {
    f.params.cut.n_clusters = n;
    const double error = relative_rmse(truth, f.run("lightslice").radiance);
    RecordProperty("clusters_" + std::to_string(n), std::to_string(error));
    EXPECT_LT(error, last) << n << " clusters";
    last = error;
  }
  EXPECT_LT(last, 0.084);
}

TEST(LightSlice, ErrorFallsAsClustersGrowInARoomSlow) {
  MYRIALUX_REQUIRE_SCENES();
  MethodFrame f(load_scene(test::scenes_folder() + "/living-room/scene.xml"), 5000, 64);
  f.params.cut.clamp_distance = 0.3f;  // metres; closer lights make spikes that no cluster keeps
  const std::vector<Rgb> truth = f.run("brute-force").radiance;
  double last = 1e9;
  for (const std::uint32_t n : {60u, 250u, 1000u, 4000u}) {
    f.params.cut.n_clusters = n;
    const double error = relative_rmse(truth, f.run("lightslice").radiance);
    RecordProperty("clusters_" + std::to_string(n), std::to_string(error));
    EXPECT_LT(error, last) << n << " clusters";
    last = error;
  }
  // Measured: 0.956, 0.685, 0.540, 0.406; what is left is light that none of the 64 rows sees.
  EXPECT_LT(last, 0.61);
  f.params.lightslice.power_share = 0.1f;
  const double unbiased = relative_rmse(truth, f.run("lightslice").radiance);
  RecordProperty("with_power", std::to_string(unbiased));
  EXPECT_LT(unbiased, 0.1);
}

TEST(LightSlice, SameBitsForAnyNumberOfThreads) {
  const MethodFrame f(test::glossy_floor_box(0.3f), 3000, 48);
  std::vector<Rgb> first;
  for (const int n_threads : {1, 2, 7}) {
    const ThreadScope threads(n_threads);
    const std::vector<Rgb> radiance = f.run("lightslice").radiance;
    if (first.empty()) first = radiance;
    EXPECT_EQ(radiance, first) << n_threads << " threads";
  }
}

TEST(LightSlice, RowsOfTheReducedMatrixCountAsTracedEntries) {
  MethodFrame f(test::cornell_box(), 2000, 40);
  f.params.cut.n_clusters = 50;
  RenderStats stats;
  f.run("lightslice", stats);
  EXPECT_EQ(stats.rays.shadow, stats.visibility.traced);
  EXPECT_EQ(stats.visibility.entries, stats.visibility.traced);
  EXPECT_EQ(stats.slices, 25u);
  // More than the slices' own entries: 25 rows x 2000 lights besides 1600 rows x 50 columns.
  EXPECT_GT(stats.visibility.traced, 1600u * 50u / 4);
  EXPECT_GE(stats.memory.slices_peak, 25u * 2000u * 2u);
}

TEST(LightSlice, NoLightsGiveBlack) {
  MethodFrame f(test::cornell_box(), 100, 8);
  f.lights = VirtualLights{};
  for (const Rgb& c : f.run("lightslice").radiance) EXPECT_TRUE(is_black(c));
}

TEST(LightSlice, LightsThatNobodySeesDoNoHarm) {
  // All lights far behind the walls.
  MethodFrame f(test::cornell_box(), 200, 16);
  for (Vec3& p : f.lights.p) p = p + Vec3{0, -1000, 0};
  f.params.cut.n_clusters = 10;
  for (const float power : {0.0f, 0.2f}) {
    f.params.lightslice.power_share = power;
    for (const Rgb& c : f.run("lightslice").radiance) EXPECT_TRUE(is_black(c));
  }
}

}  // namespace
}  // namespace myrialux
