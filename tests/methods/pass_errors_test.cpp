// Estimated variances of a pass against those that brute force has over draws and over light sets.
#include "myrialux/methods/pass_errors.h"

#include <gtest/gtest.h>

#include "myrialux/lights/walks.h"
#include "myrialux/transfer/transfer.h"
#include "support/method_frame.h"
#include "support/statistics.h"

namespace myrialux {
namespace {

using test::MethodFrame;
using test::Sample;

struct Fixture : MethodFrame {
  Fixture(Scene s, std::uint64_t n_lights) : MethodFrame(std::move(s), n_lights, 12) {}
  FrameView view() const { return {world, receivers, lights, radius()}; }
  float radius() const { return 0.5f * scene.bounds().diagonal(); }
  LightTree tree() const { return build_light_tree(world, lights, radius(), params.tree); }
  /// A few receivers all over the picture.
  std::vector<ReceiverId> rows() const {
    std::vector<ReceiverId> some;
    for (std::size_t i = 5; i < receivers.size(); i += 12) some.push_back(static_cast<ReceiverId>(i));
    return some;
  }
};

/// Luminance that reaches the camera from every light, [rows x lights], one ray an entry.
std::vector<std::vector<double>> all_entries(const Fixture& f, const std::vector<ReceiverId>& rows) {
  std::vector<std::vector<double>> x;
  for (const ReceiverId i : rows) {
    std::vector<double>& row = x.emplace_back(f.lights.size());
    const std::size_t r = index(i);
    for (std::size_t j = 0; j < row.size(); ++j) {
      const Rgb light =
          transfer(f.world, f.receivers, i, f.lights, static_cast<LightId>(j), f.params.cut.clamp_distance);
      const Vec3 to = f.lights.p[j] - f.receivers.p[r];
      const Vec3 a = offset_origin(f.receivers.p[r], f.receivers.ng[r], f.receivers.offset[r], to);
      const Vec3 b = offset_origin(f.lights.p[j], f.lights.ng[j], f.lights.offset[j], -to);
      if (!is_black(light) && !f.tracer.occluded(a, b))
        row[j] = static_cast<double>(luminance(f.receivers.beta[r]) * luminance(light));
    }
  }
  return x;
}

double sum(const std::vector<double>& values) {
  double s = 0;
  for (const double v : values) s += v;
  return s;
}

TEST(PassErrors, ClusterVarianceIsThatOfDrawnRepresentatives) {
  const Fixture f(test::cornell_box(), 400);
  const LightTree tree = f.tree();
  const std::vector<ReceiverId> rows = f.rows();
  const auto x = all_entries(f, rows);
  GrowingCut cut(f.world, f.receivers, rows, tree, f.params.cut);
  const PassErrors errors(f.view(), tree, rows, f.params.cut.clamp_distance);
  for (const std::uint32_t size : {2u, 20u, 100u}) {
    cut.grow(size);
    // A node's light j stands for all with probability I_j / I: E[(I / I_j x_j)^2] - (sum x)^2.
    double expected = 0;
    for (const std::uint32_t node : cut.nodes())
      for (const std::vector<double>& row : x) {
        const LightNode n = tree.node(node);
        double squares = 0, all = 0;
        for (std::uint32_t l = n.first; l < n.first + n.count; ++l) {
          const std::size_t j = index(tree.order[l]);
          squares += row[j] * row[j] / static_cast<double>(tree.importance[j]), all += row[j];
        }
        expected += static_cast<double>(n.importance) * squares - all * all;
      }
    for (const std::size_t most : {1000, 7}) {
      Sample estimate;
      for (std::uint64_t k = 0; k < 400; ++k)
        estimate.add(sum(errors.clusters(cut.nodes(), most, Rng({9}, Stage::test, k)).value));
      EXPECT_LT(std::abs(test::z_score(estimate, expected)), 4)
          << size << " clusters, " << most << " pairs: " << estimate.mean << ", should be " << expected;
    }
  }
}

TEST(PassErrors, OfAllLightsClustersAreExact) {
  const Fixture f(test::cornell_box(), 100);
  const LightTree tree = f.tree();
  GrowingCut cut(f.world, f.receivers, f.rows(), tree, f.params.cut);
  cut.grow(1000);
  const RowEstimates none =
      PassErrors(f.view(), tree, f.rows(), 0.1f).clusters(cut.nodes(), 64, Rng({9}, Stage::test, 0));
  EXPECT_EQ(sum(none.value), 0);
  EXPECT_EQ(none.rays, 0u);
}

/// @param direct false: walks are told apart by rising bounces alone, and many leave no light
void expect_light_set_variance_over_seeds(const Scene& scene, bool direct) {
  Fixture f(scene, 300);
  const std::vector<ReceiverId> rows = f.rows();
  constexpr std::uint32_t kSets = 250;
  std::vector<Sample> radiance(rows.size());
  std::vector<std::vector<double>> by_set;
  Sample estimate, estimated_radiance, true_radiance, variance;
  Progress silent;
  for (std::uint32_t k = 0; k < kSets; ++k) {
    const RandomKey key{77, k};
    f.lights = trace_lights(f.world, {.n_lights = 300, .direct = direct, .key = key}, silent).lights;
    f.params.tree.key = key;
    const LightTree tree = f.tree();
    std::vector<double>& set = by_set.emplace_back();
    for (const std::vector<double>& row : all_entries(f, rows)) set.push_back(sum(row));
    for (std::size_t r = 0; r < rows.size(); ++r) radiance[r].add(set[r]);
    GrowingCut cut(f.world, f.receivers, rows, tree, f.params.cut);
    cut.grow(30);
    const LightSetEstimates own = PassErrors(f.view(), tree, rows, f.params.cut.clamp_distance)
                                      .light_set(cut.nodes(), count_walks(f.lights), Rng(key, Stage::test, 0));
    estimate.add(sum(own.variance)), estimated_radiance.add(sum(own.radiance) - sum(set));
  }
  for (const std::vector<double>& set : by_set) {
    double squares = 0;
    for (std::size_t r = 0; r < rows.size(); ++r) squares += std::pow(set[r] - radiance[r].mean, 2);
    variance.add(squares * kSets / (kSets - 1));
  }
  EXPECT_LT(std::abs(test::z_score(estimated_radiance, 0)), 4);
  EXPECT_LT(std::abs(test::z_score(estimate, variance)), 4) << estimate.mean << ", should be " << variance.mean;
  // The comparison means something only where both are known well.
  EXPECT_LT(std::sqrt(estimate.variance_of_mean() + variance.variance_of_mean()), 0.25 * variance.mean);
}

TEST(PassErrors, LightSetVarianceIsThatOverSeeds) { expect_light_set_variance_over_seeds(test::cornell_box(), true); }
TEST(PassErrors, LightSetVarianceIsThatOverSeedsWithoutDirectLight) {
  expect_light_set_variance_over_seeds(test::cornell_box(), false);
}
TEST(PassErrors, LightSetVarianceIsThatOverSeedsOnGloss) {
  expect_light_set_variance_over_seeds(test::glossy_floor_box(0.3f), true);
}

TEST(PassErrors, LightSetVarianceIsThatOverSeedsWhereWalksLeaveManyAlikeLights) {
  expect_light_set_variance_over_seeds(test::furnace_sphere(0.8f), true);
}

}  // namespace
}  // namespace myrialux
