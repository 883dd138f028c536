// Slice methods against brute force on the same receivers and lights: exact where the approximation is off.
#include <gtest/gtest.h>

#include "myrialux/base/parallel.h"
#include "support/method_frame.h"

namespace myrialux {
namespace {

using Fixture = test::MethodFrame;
using test::relative_rmse;

TEST(SliceMethods, OneLightPerClusterEqualsBruteForce) {
  Fixture f(test::cornell_box(), 300, 24);
  f.params.cut.n_clusters = 100000;
  // Sums of 300 terms in another order: each side is off by at most 300 ulps of the sum of magnitudes.
  EXPECT_LT(relative_rmse(f.run("brute-force").radiance, f.run("slice-lightcuts").radiance), 300 * 6e-8);
}

TEST(SliceMethods, OneLightPerClusterEqualsBruteForceOnGlossyFloor) {
  Fixture f(test::glossy_floor_box(0.3f), 300, 24);
  f.params.cut.n_clusters = 100000;
  // The kernels' rational approximations add to the order of summation; their bound is tested in tests/shading.
  EXPECT_LT(relative_rmse(f.run("brute-force").radiance, f.run("slice-lightcuts").radiance), 1e-4);
}

TEST(SliceMethods, CompletionThatSamplesEverythingEqualsFullVisibility) {
  Fixture f(test::cornell_box(), 2000, 40);
  f.params.cut.n_clusters = 200;
  for (RowRates* rates : {&f.params.bamc, &f.params.amc.rows, &f.params.gauss_jordan}) rates->alpha = rates->omega = 1;
  f.params.separation.samples = 1;
  f.params.lbamc.few = 1024;
  const std::vector<Rgb> full = f.run("slice-lightcuts").radiance;
  for (const char* method : {"lbamc", "bamc", "amc", "gauss-jordan", "matrix-separation"})
    EXPECT_EQ(f.run(method).radiance, full) << method;
}

TEST(SliceMethods, CompletionStaysNearFullVisibilityWithFewerRays) {
  Fixture f(test::cornell_box(), 20000, 96);
  f.params.cut.n_clusters = 500;
  RenderStats stats;
  const MethodResult completed = f.run("bamc", stats);
  EXPECT_LT(relative_rmse(f.run("slice-lightcuts").radiance, completed.radiance), 0.02);
  EXPECT_LT(stats.visibility.traced, stats.visibility.entries / 2);
  EXPECT_EQ(stats.rays.shadow, stats.visibility.traced);
}

TEST(SliceMethods, LocalizedCompletionStaysNearFullVisibilityWithFewRays) {
  Fixture f(test::cornell_box(), 20000, 96);
  f.params.cut.n_clusters = 500;
  f.params.visibility_error = 0.02f;
  RenderStats stats;
  const MethodResult completed = f.run("lbamc", stats);
  // Measured: 0.0138. Slices span a ninth of the picture here.
  EXPECT_LT(relative_rmse(f.run("slice-lightcuts").radiance, completed.radiance), 0.021);
  EXPECT_LT(stats.visibility.traced, stats.visibility.entries / 3);
  EXPECT_EQ(stats.visibility.meter.redone_slices, 0u);
  EXPECT_EQ(stats.rays.shadow,
            stats.visibility.traced + stats.visibility.meter.rays + stats.visibility.meter.more_rays);
  EXPECT_GT(stats.visibility.checked, 0u) << "a pilot is traced whole";
}

TEST(SliceMethods, OtherCompletionsStayInsideTheirRecordedErrors) {
  Fixture f(test::cornell_box(), 20000, 64);
  f.params.cut.n_clusters = 250;
  const std::vector<Rgb> full = f.run("slice-lightcuts").radiance;
  struct Recorded {
    const char* method;
    double error, traced;  ///< relative RMSE, share of active entries: half above what was measured
  };
  for (const Recorded& r :
       {Recorded{"amc", 0.013, 0.84}, {"gauss-jordan", 0.011, 0.86}, {"matrix-separation", 0.112, 0.16}}) {
    RenderStats stats;
    EXPECT_LT(relative_rmse(full, f.run(r.method, stats).radiance), r.error) << r.method;
    EXPECT_LT(static_cast<double>(stats.visibility.traced), r.traced * static_cast<double>(stats.visibility.entries))
        << r.method << " "
        << static_cast<double>(stats.visibility.traced) / static_cast<double>(stats.visibility.entries);
    EXPECT_EQ(stats.rays.shadow, stats.visibility.traced) << r.method;
  }
}

TEST(SliceMethods, SeparationValidatesFewerColumnsAsItsEnergyThresholdGrows) {
  Fixture f(test::cornell_box(), 5000, 48);
  f.params.cut.n_clusters = 200;
  std::uint64_t last = ~std::uint64_t{0};
  for (const float energy : {0.0f, 0.3f, 1e9f}) {
    f.params.separation.energy = energy;
    RenderStats stats;
    f.run("matrix-separation", stats);
    EXPECT_LT(stats.visibility.traced, last) << energy;
    last = stats.visibility.traced;
  }
}

TEST(SliceMethods, GuardedCompletionErrsLessAndCountsItsWrongBits) {
  // 37 slices; few samples, so that many bits are guessed wrongly.
  Fixture f(test::cornell_box(), 20000, 192);
  f.params.cut.n_clusters = 300;
  f.params.bamc.alpha = f.params.bamc.beta = f.params.bamc.omega = 0.004f;
  const std::vector<Rgb> full = f.run("slice-lightcuts").radiance;
  RenderStats published, guarded;
  f.params.bamc_guard = 0;
  const double published_error = relative_rmse(full, f.run("bamc", published).radiance);
  f.params.bamc_guard = 0.005f;
  const double guarded_error = relative_rmse(full, f.run("bamc", guarded).radiance);
  EXPECT_LT(guarded_error, 0.5 * published_error);
  EXPECT_LT(guarded.visibility.traced, guarded.visibility.entries / 2);

  EXPECT_EQ(published.visibility.checked, 0u);
  EXPECT_GT(guarded.visibility.checked, 0u);
  EXPECT_LT(guarded.visibility.checked, guarded.visibility.entries / 20);
  EXPECT_GT(guarded.visibility.false_visible + guarded.visibility.false_occluded, 0u);
  EXPECT_LT(guarded.visibility.false_visible + guarded.visibility.false_occluded, guarded.visibility.checked / 20);
}

TEST(SliceMethods, PublishedFormTracesZeroTransferToo) {
  Fixture f(test::cornell_box(), 2000, 40);
  f.params.cut.n_clusters = 200;
  RenderStats culled, published;
  f.run("bamc", culled);
  f.params.bamc_cull = false;
  f.run("bamc", published);
  EXPECT_LT(culled.visibility.entries, published.visibility.entries);
}

TEST(SliceMethods, ErrorFallsAsClustersGrow) {
  const Fixture base(test::cornell_box(), 5000, 32);
  const std::vector<Rgb> truth = base.run("brute-force").radiance;
  double last = 1e9;
  for (const std::uint32_t n : {30u, 120u, 500u, 2000u}) {
    Fixture f(test::cornell_box(), 5000, 32);
    f.params.cut.n_clusters = n;
    const double error = relative_rmse(truth, f.run("slice-lightcuts").radiance);
    EXPECT_LT(error, last) << n << " clusters";
    last = error;
  }
  // One slice spans the whole box here. Measured: 0.319, 0.186, 0.083, 0.056; recorded bound half above the last.
  EXPECT_LT(last, 0.084);
}

TEST(SliceMethods, SameBitsForAnyNumberOfThreads) {
  Fixture f(test::glossy_floor_box(0.3f), 3000, 48);
  f.params.cut.n_clusters = 250;
  for (const char* method :
       {"lbamc", "bamc", "amc", "gauss-jordan", "matrix-separation", "slice-lightcuts", "brute-force"}) {
    std::vector<Rgb> first;
    for (const int n_threads : {1, 2, 7}) {
      const ThreadScope threads(n_threads);
      const std::vector<Rgb> radiance = f.run(method).radiance;
      if (first.empty()) first = radiance;
      EXPECT_EQ(radiance, first) << method << " with " << n_threads << " threads";
    }
  }
}

TEST(SliceMethods, NoLightsGiveBlack) {
  Fixture f(test::cornell_box(), 100, 8);
  f.lights = VirtualLights{};
  for (const char* method :
       {"lbamc", "bamc", "amc", "gauss-jordan", "matrix-separation", "slice-lightcuts", "brute-force"})
    for (const Rgb& c : f.run(method).radiance) EXPECT_TRUE(is_black(c)) << method;
}

TEST(Methods, UnknownNameListsTheKnown) {
  try {
    find_method("bmac");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::usage);
    std::string expected = "unknown method 'bmac'; known: ";
    for (const MethodInfo& m : all_methods()) expected += (&m == &all_methods().front() ? "" : ", ") + m.name;
    EXPECT_EQ(e.what(), expected);
  }
}

}  // namespace
}  // namespace myrialux
