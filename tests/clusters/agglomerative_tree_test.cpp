// Agglomerative tree: the same invariants as the divisive one, true greedy clustering when all lights compete, cheaper
// clusters than halving.
#include "myrialux/clusters/agglomerative_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "myrialux/base/parallel.h"
#include "myrialux/clusters/light_metric.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

using test::Room;

const std::vector<LightKind> kAllKinds = {LightKind::oriented, LightKind::glossy, LightKind::point,
                                          LightKind::directional};

LightTree build(const Room& room, RandomKey key = {}, std::uint32_t n_competing = AgglomerativeParams{}.n_competing) {
  return build_agglomerative_tree(room.world(), room.lights, Room::kRadius, {.n_competing = n_competing, .key = key});
}

/// Sum over inner nodes of what joining them costs.
double total_cost(const LightTree& tree, float c2) {
  double sum = 0;
  for (std::uint32_t number = 0; number < tree.size(); ++number) {
    const LightNode node = tree.node(number);
    if (node.is_leaf()) continue;
    const LightGroup whole{.box = node.box,
                           .axis = node.cone_axis,
                           .half_angle = std::acos(std::clamp(node.cone_cos, -1.0f, 1.0f)),
                           .intensity = node.importance / 2,
                           .id = 0,
                           .slot = 0};
    sum += static_cast<double>(join_cost(whole, whole, c2, 0));
  }
  return sum;
}
constexpr float kC2 = 4 * Room::kRadius * Room::kRadius;

TEST(AgglomerativeTree, HoldsEveryLightInOneLeaf) {
  for (const std::size_t n : {0, 1, 2, 3, 5, 64, 1001, 6000}) {
    const Room room({.n_receivers = 1, .n_lights = n, .kinds = kAllKinds, .glossy = true});
    const LightTree tree = build(room);
    std::vector<LightId> sorted = tree.order;
    std::sort(sorted.begin(), sorted.end());
    ASSERT_EQ(sorted.size(), n);
    for (std::size_t j = 0; j < n; ++j) EXPECT_EQ(index(sorted[j]), j);
    EXPECT_EQ(tree.roots.size(), std::min<std::size_t>(n, 4));
    EXPECT_EQ(tree.size(), n == 0 ? 0 : 2 * n - tree.roots.size());
    std::size_t leaves = 0;
    for (std::uint32_t k = 0; k < tree.size(); ++k) {
      const LightNode node = tree.node(k);
      leaves += node.is_leaf();
      EXPECT_EQ(node.is_leaf(), node.count == 1);
      if (node.is_leaf()) continue;
      const LightNode left = tree.node(node.left), right = tree.node(node.right);
      EXPECT_GT(node.left, k);
      EXPECT_EQ(left.count + right.count, node.count);
      EXPECT_EQ(left.first, node.first);
      EXPECT_EQ(right.first, node.first + left.count);
    }
    EXPECT_EQ(leaves, n);
  }
}

TEST(AgglomerativeTree, NodesContainTheirLights) {
  const Room room(
      {.n_receivers = 1, .n_lights = 4000, .kinds = kAllKinds, .glossy = true, .glass = true, .shading_tilt = 0.2f});
  const LightTree tree = build(room);
  const VirtualLights& lights = room.lights;
  for (std::uint32_t number = 0; number < tree.size(); ++number) {
    const LightNode node = tree.node(number);
    double importance = 0;
    bool holds_representative = false;
    for (std::uint32_t l = node.first; l < node.first + node.count; ++l) {
      const std::size_t j = index(tree.order[l]);
      ASSERT_EQ(lights.kind[j], node.kind);
      const bool distant = node.kind == LightKind::directional, glossy = node.kind == LightKind::glossy;
      const Vec3 p = distant ? -lights.n[j] : lights.p[j];
      for (int a = 0; a < 3; ++a) {
        ASSERT_GE(p[a], node.box.lower[a]);
        ASSERT_LE(p[a], node.box.upper[a]);
      }
      if (node.cone_cos > -1) {
        ASSERT_GE(dot(glossy ? lights.ng[j] : lights.n[j], node.cone_axis), node.cone_cos - 3e-7f);
      }
      importance += tree.importance[j];
      holds_representative = holds_representative || tree.order[l] == node.representative;
    }
    EXPECT_TRUE(holds_representative);
    EXPECT_NEAR(node.importance, importance, 1e-5 * importance);
    if (node.is_leaf()) continue;
    const LightNode left = tree.node(node.left), right = tree.node(node.right);
    EXPECT_EQ(node.importance, left.importance + right.importance);
    EXPECT_TRUE(node.representative == left.representative || node.representative == right.representative);
  }
}

/// The definition: join the cheapest pair of all, until one is left.
double greedy_cost(const Room& room, const LightTree& tree) {
  std::vector<LightGroup> groups;
  for (std::size_t j = 0; j < room.lights.size(); ++j) {
    LightGroup g;
    g.box.add(room.lights.p[j]);
    g.axis = room.lights.n[j];
    g.intensity = tree.importance[j];
    groups.push_back(g);
  }
  double sum = 0;
  while (groups.size() > 1) {
    float least = std::numeric_limits<float>::infinity();
    std::size_t best_i = 0, best_j = 1;
    for (std::size_t i = 0; i < groups.size(); ++i)
      for (std::size_t j = i + 1; j < groups.size(); ++j)
        if (const float cost = join_cost(groups[i], groups[j], kC2, 1e-12f * kC2); cost < least)
          least = cost, best_i = i, best_j = j;
    sum += static_cast<double>(least);
    groups[best_i] = join(groups[best_i], groups[best_j]);
    groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(best_j));
  }
  return sum;
}

TEST(AgglomerativeTree, JoinsTheCheapestPairWhenAllCompete) {
  const Room room({.n_receivers = 1, .n_lights = 400, .shading_tilt = 0.2f});
  const LightTree tree = build(room, {}, 400);
  const double greedy = greedy_cost(room, tree);
  EXPECT_NEAR(total_cost(tree, kC2), greedy, 0.005 * greedy);  // cones of nodes are rounded outwards
}

TEST(AgglomerativeTree, CostsLittleMoreThanGreedyAndMuchLessThanHalving) {
  const Room room({.n_receivers = 1, .n_lights = 3000, .shading_tilt = 0.2f});
  const double greedy = total_cost(build(room, {}, 3000), kC2), fast = total_cost(build(room), kC2);
  const double halving = total_cost(build_light_tree(room.world(), room.lights, Room::kRadius, {}), kC2);
  std::printf("cost over greedy: %.3f, halving %.3f\n", fast / greedy, halving / greedy);
  EXPECT_LT(fast, 1.1 * greedy);
  EXPECT_GT(halving, 1.3 * greedy);
}

TEST(AgglomerativeTree, CostNeverFallsAsGroupsGrow) {
  Rng rng({4}, Stage::test, 0);
  const auto random_group = [&] {
    LightGroup g;
    for (int k = 0; k < 2; ++k) g.box.add(Vec3{rng.next(), rng.next(), rng.next()});
    const float x = rng.next();
    g.axis = sample_sphere({x, rng.next()});
    g.half_angle = rng.next() * rng.next() * kPi;
    g.intensity = rng.next();
    return g;
  };
  for (int k = 0; k < 100000; ++k) {
    const LightGroup a = random_group(), b = random_group(), c = random_group();
    const float least = std::min(join_cost(a, c, 3, 0), join_cost(b, c, 3, 0));
    EXPECT_GE(join_cost(join(a, b), c, 3, 0), least * 0.999f);
  }
}

TEST(AgglomerativeTree, IsTheSameForAnyNumberOfThreads) {
  const Room room({.n_receivers = 1, .n_lights = 60000, .kinds = kAllKinds, .glossy = true});
  LightTree first;
  for (const int threads : {1, 2, 7}) {
    const ThreadScope scope(threads);
    const LightTree tree = build(room, {.seed = 9});
    if (first.order.empty()) first = tree;
    ASSERT_EQ(tree.order, first.order) << threads;
    for (std::uint32_t k = 0; k < tree.size(); ++k) {
      ASSERT_EQ(tree.node(k).left, first.node(k).left);
      ASSERT_EQ(tree.node(k).importance, first.node(k).importance);
      ASSERT_EQ(tree.node(k).representative, first.node(k).representative);
      ASSERT_EQ(tree.node(k).cone_axis, first.node(k).cone_axis);
      ASSERT_EQ(tree.node(k).box.upper, first.node(k).box.upper);
    }
  }
}

TEST(AgglomerativeTree, DrawsRepresentativesByImportance) {
  // Over passes the root's representative has the lights' importance as its distribution: chi-square.
  const Room room({.n_receivers = 1, .n_lights = 12});
  std::vector<double> seen(12);
  constexpr int kPasses = 6000;
  LightTree tree;
  for (std::uint32_t pass = 0; pass < kPasses; ++pass) {
    tree = build(room, {.seed = 5, .pass = pass});
    seen[index(tree.node(0).representative)] += 1;
  }
  const double total = std::accumulate(tree.importance.begin(), tree.importance.end(), 0.0);
  double chi2 = 0;
  int dof = -1;
  double rare_expected = 0, rare_seen = 0;
  for (std::size_t j = 0; j < 12; ++j) {
    const double expected = kPasses * tree.importance[j] / total;
    if (expected < 5) {
      rare_expected += expected, rare_seen += seen[j];
      continue;
    }
    chi2 += (seen[j] - expected) * (seen[j] - expected) / expected, ++dof;
  }
  if (rare_expected >= 5) chi2 += (rare_seen - rare_expected) * (rare_seen - rare_expected) / rare_expected, ++dof;
  const double spread = 2.0 / (9 * dof);
  EXPECT_LT((std::cbrt(chi2 / dof) - (1 - spread)) / std::sqrt(spread), 4.5) << chi2 << " on " << dof;
}

TEST(AgglomerativeTree, LeavesOutLightsOfNoImportance) {
  Room room({.n_receivers = 1, .n_lights = 100});
  for (std::size_t j = 0; j < 100; j += 3) room.lights.light[j] = {};
  const LightTree tree = build(room);
  EXPECT_EQ(tree.n_lights(), 66u);
  for (const LightId j : tree.order) EXPECT_NE(index(j) % 3, 0u);
}

std::uint32_t depth(const LightTree& tree, std::uint32_t root) {
  std::vector<std::uint32_t> depths(tree.size());
  std::uint32_t deepest = 0;
  for (std::size_t k = root; k < tree.size(); ++k) {
    deepest = std::max(deepest, depths[k]);
    const LightNode node = tree.node(static_cast<std::uint32_t>(k));
    if (!node.is_leaf()) depths[node.left] = depths[node.right] = depths[k] + 1;
  }
  return deepest;
}

TEST(AgglomerativeTree, OfCoincidingLightsIsStillAShallowTree) {
  Room room({.n_receivers = 1, .n_lights = 20000});
  std::fill(room.lights.p.begin(), room.lights.p.end(), Vec3{1, 2, 3});
  std::fill(room.lights.n.begin(), room.lights.n.end(), Vec3{0, 0, 1});
  std::fill(room.lights.ng.begin(), room.lights.ng.end(), Vec3{0, 0, 1});
  for (const bool equal : {false, true}) {
    if (equal) std::fill(room.lights.light.begin(), room.lights.light.end(), gray(1));
    const LightTree tree = build(room);
    EXPECT_EQ(tree.size(), 39999u);
    EXPECT_EQ(tree.node(0).cone_cos, 1);
    EXPECT_LT(depth(tree, 0), 60u) << equal;
  }
}

}  // namespace
}  // namespace myrialux
