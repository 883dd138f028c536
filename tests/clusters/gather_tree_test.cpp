// Gather trees and bounds of pairs of clusters: never exceeded, by sums nor by representatives, and not absurdly loose.
#include "myrialux/clusters/gather_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "myrialux/clusters/bounds.h"
#include "myrialux/clusters/cut.h"
#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

using test::Room;
using test::RoomOptions;

constexpr float kClamp = 0.1f, kLeastSquared = kClamp * kClamp;

std::vector<ReceiverId> all_rows(const Receivers& receivers) {
  std::vector<ReceiverId> rows(receivers.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<ReceiverId>(i);
  return rows;
}

GatherTree tree_of(const Room& room, std::span<const ReceiverId> rows, std::uint64_t seed = 5) {
  GatherTree tree;
  Rng rng({seed}, Stage::test, 1);
  build_gather_tree(room.world(), room.receivers, rows, 0.05f * Room::kRadius, rng, tree);
  return tree;
}

Vec3 vec(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

TEST(GatherTree, NodesHoldTheirReceiversPositionsNormalsAndMirrorDirections) {
  const Room room({.n_receivers = 201, .n_lights = 1, .glossy = true, .shading_tilt = 0.2f});
  const GatherTree tree = tree_of(room, all_rows(room.receivers));
  ASSERT_EQ(tree.nodes.size(), 401u);
  for (const GatherNode& node : tree.nodes) {
    float strength = 0;
    bool has_representative = false;
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
      const ReceiverId row = tree.order[k];
      const std::size_t i = index(row);
      strength += max_component(room.receivers.beta[i]);
      has_representative |= row == node.representative;
      const Vec3 p = room.receivers.p[i], n = room.receivers.n[i], wo = room.receivers.wo[i];
      for (int a = 0; a < 3; ++a) EXPECT_TRUE(p[a] >= node.bounds.lower[a] && p[a] <= node.bounds.upper[a]);
      EXPECT_GE(dot(n, vec(node.bounds.normal.axis)), node.bounds.normal_cos - 1e-5f);
      const bool glossy = room.receivers.bsdf[i].material != static_cast<MaterialId>(0) &&
                          room.receivers.bsdf[i].material != static_cast<MaterialId>(5);
      if (glossy) {
        EXPECT_GE(dot(n * (2 * dot(n, wo)) - wo, vec(node.bounds.mirror.axis)), node.bounds.mirror_cos - 1e-5f);
      }
    }
    EXPECT_FLOAT_EQ(node.strength, strength);
    EXPECT_TRUE(has_representative);
    if (node.is_leaf()) continue;
    const ReceiverId a = tree.nodes[node.left].representative, b = tree.nodes[node.left + 1].representative;
    EXPECT_TRUE((node.representative == a) != (node.representative == b));
  }
  std::vector<ReceiverId> sorted = tree.order;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, all_rows(room.receivers));
}

TEST(GatherTree, LeavesOutReceiversWithoutWeight) {
  Room room({.n_receivers = 5, .n_lights = 1});
  room.receivers.beta[1] = room.receivers.beta[4] = {};
  EXPECT_EQ(tree_of(room, all_rows(room.receivers)).order.size(), 3u);
  for (Rgb& beta : room.receivers.beta) beta = {};
  EXPECT_TRUE(tree_of(room, all_rows(room.receivers)).nodes.empty());
}

TEST(GatherTree, RepresentativesAreDrawnInProportionToStrength) {
  Room room({.n_receivers = 3, .n_lights = 1});
  room.receivers.beta = {{0.1f, 0.2f, 0.5f}, {1, 0, 0}, gray(2.5f)};  // strengths 0.5, 1, 2.5
  constexpr int kDraws = 20000;
  std::array<int, 3> drawn{};
  for (std::uint64_t seed = 0; seed < kDraws; ++seed)
    ++drawn[index(tree_of(room, all_rows(room.receivers), seed).nodes[0].representative)];
  const double expected[3] = {0.125, 0.25, 0.625};
  for (int k = 0; k < 3; ++k)  // four standard deviations
    EXPECT_NEAR(double(drawn[k]) / kDraws, expected[k], 4 * std::sqrt(expected[k] * (1 - expected[k]) / kDraws));
}

TEST(PairBound, OfOneReceiverIsItsClusterBoundOrLess) {
  const Room room({.n_receivers = 64,
                   .n_lights = 500,
                   .kinds = {LightKind::oriented, LightKind::glossy, LightKind::point, LightKind::directional},
                   .glossy = true,
                   .glass = true,
                   .shading_tilt = 0.1f});
  const World world = room.world();
  const LightTree lights = build_light_tree(world, room.lights, Room::kRadius, {});
  const GatherTree tree = tree_of(room, all_rows(room.receivers));
  for (const GatherNode& node : tree.nodes)
    for (std::uint32_t n = 0; node.is_leaf() && n < lights.size(); ++n) {
      const float expected = cluster_bound(world, room.receivers, node.representative, lights, n, kClamp);
      const float bound = bound_pair(node.bounds, make_cut_cluster(lights, n), kLeastSquared);
      EXPECT_LE(bound, expected * (1 + 1e-5f));    // a sum in another order
      const LightKind kind = lights.node(n).kind;  // others: both cosines together may be smaller
      if (kind == LightKind::point || kind == LightKind::directional) {
        EXPECT_GE(bound, expected * (1 - 1e-5f));
      }
    }
}

TEST(PairBound, OfOnePlaneIsZeroThoughBoxesOverlap) {
  Room room({.n_receivers = 40, .n_lights = 40});
  for (std::size_t k = 0; k < 40; ++k) {
    room.receivers.p[k].y = room.lights.p[k].y = -1;
    room.receivers.n[k] = room.receivers.ng[k] = room.lights.n[k] = room.lights.ng[k] = {0, 1, 0};
    room.receivers.wo[k] = normalize(Vec3{0.3f, 1, 0.2f});
  }
  const LightTree lights = build_light_tree(room.world(), room.lights, Room::kRadius, {});
  const GatherTree tree = tree_of(room, all_rows(room.receivers));
  EXPECT_EQ(bound_pair(tree.nodes[0].bounds, make_cut_cluster(lights, lights.roots[0]), kLeastSquared), 0);
}

struct PairCase {
  const char* name;
  RoomOptions options;
  double median, quantile_95;  ///< recorded, with margin: bound / sum of the pair, weighed by that sum
};
std::ostream& operator<<(std::ostream& out, const PairCase& c) { return out << c.name; }

class PairBounds : public ::testing::TestWithParam<PairCase> {
 protected:
  /// Random nodes of two trees, at most 256 entries a pair.
  void check(int n_pairs) {
    const PairCase& c = GetParam();
    Room room(c.options);
    Rng rng({29}, Stage::test, 2);
    for (Rgb& beta : room.receivers.beta)
      if (rng.below(2)) beta = {rng.next(), rng.next(), rng.next()};
    const World world = room.world();
    const LightTree lights = build_light_tree(world, room.lights, Room::kRadius, {});
    const GatherTree tree = tree_of(room, all_rows(room.receivers));
    struct Tightness {
      double ratio, light;
    };
    std::vector<Tightness> tightness;
    double total = 0;
    int exceeded = 0, exceeded_by_representative = 0;
    for (int k = 0; k < n_pairs;) {
      const GatherNode& g = tree.nodes[rng.below(static_cast<std::uint32_t>(tree.nodes.size()))];
      const std::uint32_t n = rng.below(lights.size());
      const LightNode node = lights.node(n);
      if (g.count * node.count > 256) continue;
      ++k;
      double sum = 0, most = 0;
      for (std::uint32_t r = g.first; r < g.first + g.count; ++r)
        for (std::uint32_t l = node.first; l < node.first + node.count; ++l) {
          const ReceiverId i = tree.order[r];
          const LightId j = lights.order[l];
          const Rgb beta = room.receivers.beta[index(i)];
          const double light = luminance(beta * transfer(world, room.receivers, i, room.lights, j, kClamp));
          sum += light;
          most = std::max(most,
                          light * (g.strength / max_component(beta)) * (node.importance / lights.importance[index(j)]));
        }
      const double bound = g.strength * bound_pair(g.bounds, make_cut_cluster(lights, n), kLeastSquared);
      // Rounding: 2e-5 of the value; cosines near 0 are off by 1e-6 in bound or transfer.
      const double slack =
          1e-6 * g.strength * node.importance * (node.kind == LightKind::directional ? 1 : 1 / kLeastSquared);
      exceeded += sum > bound * (1 + 2e-5) + slack;
      if (node.kind != LightKind::glossy) exceeded_by_representative += most > bound * (1 + 2e-5) + slack;
      if (sum > 0 && g.count * node.count > 1) tightness.push_back({bound / sum, sum}), total += sum;
    }
    EXPECT_EQ(exceeded, 0);
    EXPECT_EQ(exceeded_by_representative, 0);
    std::sort(tightness.begin(), tightness.end(),
              [](const Tightness& a, const Tightness& b) { return a.ratio < b.ratio; });
    const auto quantile = [&](double share) {
      double sum = 0;
      for (const Tightness& t : tightness)
        if ((sum += t.light) >= share * total) return t.ratio;
      return tightness.back().ratio;
    };
    ASSERT_GT(tightness.size(), 100u);
    const double median = quantile(0.5), quantile_95 = quantile(0.95);
    std::printf("bound / light, %s: median %.3g, 95 %% %.3g\n", c.name, median, quantile_95);
    EXPECT_LT(median, c.median);
    EXPECT_LT(quantile_95, c.quantile_95);
  }
};

TEST_P(PairBounds, AreNotExceededByAFewPairs) { check(20000); }
TEST_P(PairBounds, AreNotExceededByAMillionPairsSlow) { check(125000); }

INSTANTIATE_TEST_SUITE_P(
    Rooms, PairBounds,
    ::testing::Values(
        PairCase{"diffuse", {.n_receivers = 1000, .n_lights = 5000}, 13, 1500},
        PairCase{"tilted", {.n_receivers = 1000, .n_lights = 5000, .shading_tilt = 0.3f}, 18, 1300},
        PairCase{"points", {.n_receivers = 1000, .n_lights = 5000, .kinds = {LightKind::point}}, 14, 400},
        PairCase{"directional",
                 {.n_receivers = 1000, .n_lights = 5000, .kinds = {LightKind::directional}, .glossy = true},
                 14,
                 1000},
        PairCase{"glossy_receivers",
                 {.n_receivers = 1000, .n_lights = 5000, .glossy = true, .shading_tilt = 0.1f},
                 280,
                 160000},
        PairCase{"glossy_lights",
                 {.n_receivers = 1000, .n_lights = 5000, .kinds = {LightKind::glossy}, .shading_tilt = 0.1f},
                 150,
                 45000},
        PairCase{"all_glossy",
                 {.n_receivers = 1000, .n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true},
                 500,
                 2e6},
        PairCase{"glass",
                 {.n_receivers = 1000, .n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true, .glass = true},
                 6000,
                 4e7},
        PairCase{"blinn_phong_receivers",
                 {.n_receivers = 1000, .n_lights = 5000, .glossy = true, .blinn_phong = 1, .shading_tilt = 0.1f},
                 100,
                 20000},
        PairCase{
            "all_blinn_phong",
            {.n_receivers = 1000, .n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true, .blinn_phong = 1},
            450,
            4e5},
        PairCase{
            "mixed_gloss",
            {.n_receivers = 1000, .n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true, .blinn_phong = 0.4f},
            400,
            2e5}),
    [](const auto& c) { return std::string(c.param.name); });

}  // namespace
}  // namespace myrialux
