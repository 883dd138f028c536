// The number of clusters that is chosen: by scene and lights, the same for any number of threads, and used.
#include "myrialux/methods/auto_clusters.h"

#include <gtest/gtest.h>

#include "myrialux/base/parallel.h"
#include "support/method_frame.h"

namespace myrialux {
namespace {

using test::MethodFrame;

ClusterChoice choose(const MethodFrame& f) {
  const float radius = 0.5f * f.scene.bounds().diagonal();
  const Slices slices = make_slices(f.receivers, radius, f.params.slices);
  const LightTree tree = build_light_tree(f.world, f.lights, radius, f.params.tree);
  return choose_clusters({f.world, f.receivers, f.lights, radius}, f.params, slices, tree);
}

TEST(AutoClusters, SameChoiceForAnyNumberOfThreads) {
  const MethodFrame f(test::glossy_floor_box(0.3f), 3000, 80);
  std::vector<double> first;
  for (const int n_threads : {1, 2, 7}) {
    const ThreadScope threads(n_threads);
    const ClusterChoice c = choose(f);
    const std::vector<double> numbers = {static_cast<double>(c.n_clusters), c.light_set_error, c.cluster_error,
                                         static_cast<double>(c.rays)};
    if (first.empty()) first = numbers;
    EXPECT_EQ(numbers, first) << n_threads << " threads";
  }
}

TEST(AutoClusters, FewLightsAskForFewerThanMany) {
  // Few lights err much by themselves, so that it does not pay to take them all one by one.
  const ClusterChoice few = choose(MethodFrame(test::cornell_box(), 1000, 64)),
                      many = choose(MethodFrame(test::cornell_box(), 100000, 64));
  EXPECT_GT(few.light_set_error, many.light_set_error);
  EXPECT_LT(few.n_clusters, many.n_clusters);
  EXPECT_GE(few.n_clusters, kLeastAutoClusters);
  EXPECT_LE(many.n_clusters, kMostAutoClusters);
}

/// The empty box, or the same with slats below the lamp: then walls and floor are lit in stripes, and a cluster of
/// lights is seen in part nearly everywhere.
Scene box_with_slats(int n_slats) {
  test::SceneBuilder b = test::cornell_builder({.objects = false});
  const MaterialId grey = b.diffuse(gray(0.5f));
  for (int k = 0; k < n_slats; ++k) {
    const float x = -0.95f + 1.9f * static_cast<float>(k) / static_cast<float>(n_slats);
    b.box({x, 0.3f, -1}, {x + 0.95f / static_cast<float>(n_slats), 0.35f, 1}, grey);
  }
  return std::move(b.scene);
}

TEST(AutoClusters, AnOpenRoomWithFewLightsAsksForFewerThanHardVisibility) {
  const ClusterChoice open = choose(MethodFrame(box_with_slats(0), 3000, 64)),
                      hard = choose(MethodFrame(box_with_slats(8), 30000, 64));
  EXPECT_LT(open.n_clusters, hard.n_clusters);
}

TEST(AutoClusters, MoreWorkBesideClustersAllowsMoreOfThem) {
  EXPECT_LT(pass_work(2000, 0) / pass_work(1000, 0), 2);
  EXPECT_LT(pass_work(2000, 10) / pass_work(1000, 10), pass_work(2000, 0) / pass_work(1000, 0));
}

TEST(AutoClusters, OfABlackFrameAreTheDefault) {
  MethodFrame f(test::cornell_box(), 100, 8);
  f.lights = VirtualLights{};
  const ClusterChoice c = choose(f);
  EXPECT_EQ(c.n_clusters, MethodInfo{}.n_clusters);
  EXPECT_EQ(c.rays, 0u);
}

TEST(AutoClusters, ArePictureAndCountsOfThatNumberGiven) {
  MethodFrame f(test::cornell_box(), 3000, 48);
  for (const char* method : {"lbamc", "slice-lightcuts"}) {
    RenderStats stats, given;
    f.params.auto_clusters = true;
    const std::vector<Rgb> chosen = f.run(method, stats).radiance;
    f.params.auto_clusters = false;
    f.params.cut.n_clusters = static_cast<std::uint32_t>(stats.clusters_auto.chosen);
    EXPECT_EQ(chosen, f.run(method, given).radiance) << method;
    EXPECT_EQ(stats.clusters_mean, given.clusters_mean);
    EXPECT_GT(stats.rays.shadow, given.rays.shadow) << "the choice has its own";
    EXPECT_EQ(given.clusters_auto.chosen, 0u);
  }
}

}  // namespace
}  // namespace myrialux
