// Lightcuts against brute force on the same receivers and lights: exact at the limit, better as its threshold falls.
#include <gtest/gtest.h>

#include "myrialux/base/parallel.h"
#include "myrialux/scene/load.h"
#include "support/method_frame.h"
#include "support/scenes.h"

namespace myrialux {
namespace {

using test::MethodFrame;
using test::relative_rmse;

constexpr TreeKind kTrees[] = {TreeKind::agglomerative, TreeKind::divisive};

TEST(Lightcuts, DownToTheLeavesEqualsBruteForce) {
  MethodFrame f(test::cornell_box(), 300, 24);
  f.params.lightcuts.error = 0;
  f.params.cut.n_clusters = 100000;
  const std::vector<Rgb> truth = f.run("brute-force").radiance;
  for (const TreeKind tree : kTrees)
    for (const bool together : {true, false}) {
      f.params.lightcuts.tree = tree, f.params.lightcuts.together = together;
      // Sums of 300 terms in another order, weights that are quotients of sums: some ulps a term.
      EXPECT_LT(relative_rmse(truth, f.run("lightcuts").radiance), 1e-5);
    }
}

TEST(Lightcuts, DownToTheLeavesEqualsBruteForceOnGlossyFloor) {
  MethodFrame f(test::glossy_floor_box(0.3f), 300, 24);
  f.params.lightcuts.error = 0;
  f.params.cut.n_clusters = 100000;
  // The kernels' rational approximations add to rounding; their bound is tested in tests/shading.
  EXPECT_LT(relative_rmse(f.run("brute-force").radiance, f.run("lightcuts").radiance), 1e-4);
}

TEST(Lightcuts, CutsKeepTheirSizeAndCountTheirRays) {
  MethodFrame f(test::cornell_box(), 3000, 32);
  f.params.cut.n_clusters = 50;
  RenderStats stats;
  const MethodResult result = f.run("lightcuts", stats);
  for (const float size : result.cut_size) EXPECT_LE(size, 50);
  EXPECT_GT(stats.clusters_mean, 10);
  EXPECT_LE(stats.clusters_mean, 50);
  EXPECT_EQ(stats.rays.shadow, stats.visibility.traced);
  // A cut of s nodes joins its receiver with s lights at most.
  EXPECT_LE(static_cast<double>(stats.rays.shadow),
            stats.clusters_mean * static_cast<double>(f.receivers.size()) * 1.0001);
  EXPECT_GT(stats.rays.shadow, 0u);
}

/// Errors and mean cut sizes of four passes at falling thresholds, cuts of any size.
void expect_error_falls(MethodFrame& f, double last_error_bound) {
  const std::vector<Rgb> truth = f.run("brute-force").radiance;
  f.params.cut.n_clusters = 100000;
  for (const TreeKind tree : kTrees) {
    f.params.lightcuts.tree = tree;
    double last = 1e9;
    for (const float threshold : {0.32f, 0.08f, 0.02f, 0.005f}) {
      f.params.lightcuts.error = threshold;
      double squares = 0, size = 0;
      for (std::uint32_t pass = 0; pass < 2; ++pass) {
        f.params.tree.key.pass = pass;
        RenderStats stats;
        const double error = relative_rmse(truth, f.run("lightcuts", stats).radiance);
        squares += error * error / 2, size += stats.clusters_mean / 2;
      }
      const double error = std::sqrt(squares);
      std::printf("%s, threshold %g: %.0f nodes, error %.4f\n",
                  tree == TreeKind::divisive ? "divisive" : "agglomerative", static_cast<double>(threshold), size,
                  error);
      EXPECT_LT(error, 0.8 * last) << threshold;
      last = error;
    }
    EXPECT_LT(last, last_error_bound);
  }
}

TEST(Lightcuts, ErrorFallsWithTheThreshold) {
  MethodFrame f(test::cornell_box(), 5000, 32);
  expect_error_falls(f, 0.01);
}

TEST(Lightcuts, ErrorFallsWithTheThresholdInASharedRoom_Slow) {
  MYRIALUX_REQUIRE_SCENES();
  MethodFrame f(load_scene(test::scenes_folder() + "/veach-ajar/scene.xml"), 10000, 32);
  expect_error_falls(f, 0.02);
}

TEST(Lightcuts, SameBitsForAnyNumberOfThreads) {
  MethodFrame f(test::glossy_floor_box(0.3f), 3000, 32);
  for (const TreeKind tree : kTrees)
    for (const bool together : {true, false}) {
      f.params.lightcuts.tree = tree, f.params.lightcuts.together = together;
      std::vector<Rgb> first;
      for (const int n_threads : {1, 2, 7}) {
        const ThreadScope threads(n_threads);
        const std::vector<Rgb> radiance = f.run("lightcuts").radiance;
        if (first.empty()) first = radiance;
        EXPECT_EQ(radiance, first) << n_threads << " threads";
      }
    }
}

TEST(Lightcuts, NoLightsGiveBlack) {
  MethodFrame f(test::cornell_box(), 100, 8);
  f.lights = VirtualLights{};
  for (const Rgb& c : f.run("lightcuts").radiance) EXPECT_TRUE(is_black(c));
}

}  // namespace
}  // namespace myrialux
