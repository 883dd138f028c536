// Light tree: boxes, cones and sums hold what is below, representatives are inherited and drawn by importance.
#include "myrialux/clusters/light_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "myrialux/base/parallel.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

using test::Room;

const std::vector<LightKind> kAllKinds = {LightKind::oriented, LightKind::glossy, LightKind::point,
                                          LightKind::directional};

LightTree build(const Room& room, RandomKey key = {}) {
  return build_light_tree(room.world(), room.lights, Room::kRadius, {.key = key});
}

TEST(LightTree, HoldsEveryLightInOneLeaf) {
  for (const std::size_t n : {0, 1, 2, 3, 5, 64, 1001}) {
    const Room room({.n_receivers = 1, .n_lights = n, .kinds = kAllKinds, .glossy = true});
    const LightTree tree = build(room);
    std::vector<LightId> sorted = tree.order;
    std::sort(sorted.begin(), sorted.end());
    ASSERT_EQ(sorted.size(), n);
    for (std::size_t j = 0; j < n; ++j) EXPECT_EQ(index(sorted[j]), j);
    EXPECT_EQ(tree.roots.size(), std::min<std::size_t>(n, 4));
    EXPECT_EQ(tree.size(), n == 0 ? 0 : 2 * n - tree.roots.size());
    std::size_t leaves = 0;
    for (std::uint32_t number = 0; number < tree.size(); ++number) {
      const LightNode node = tree.node(number);
      leaves += node.is_leaf();
      EXPECT_EQ(node.is_leaf(), node.count == 1);
      if (!node.is_leaf()) {
        EXPECT_EQ(tree.node(node.left).count + tree.node(node.right).count, node.count);
        EXPECT_LE(tree.node(node.right).count - tree.node(node.left).count, 1u);  // halves
      }
    }
    EXPECT_EQ(leaves, n);
  }
}

TEST(LightTree, NodesContainTheirLights) {
  const Room room(
      {.n_receivers = 1, .n_lights = 4000, .kinds = kAllKinds, .glossy = true, .glass = true, .shading_tilt = 0.2f});
  const LightTree tree = build(room);
  const VirtualLights& lights = room.lights;
  for (std::uint32_t k = 0; k < tree.size(); ++k) {
    const LightNode node = tree.node(k);
    double importance = 0;
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
    }
    EXPECT_NEAR(node.importance, importance, 1e-5 * importance);
    if (!node.is_leaf()) {
      EXPECT_EQ(node.importance, tree.node(node.left).importance + tree.node(node.right).importance);
    }
  }
}

TEST(LightTree, ConesAreNotMuchWiderThanNeeded) {
  // Lights of one flat wall have one normal: the cone is that normal.
  const Room room({.n_receivers = 1, .n_lights = 3000});
  const LightTree tree = build(room);
  std::size_t flat = 0;
  for (std::uint32_t number = 0; number < tree.size(); ++number) {
    const LightNode node = tree.node(number);
    bool same = true;
    for (std::uint32_t l = node.first; l < node.first + node.count; ++l)
      same = same && room.lights.n[index(tree.order[l])] == room.lights.n[index(tree.order[node.first])];
    flat += same && !node.is_leaf();
    if (same) {
      EXPECT_EQ(node.cone_cos, 1);
    }
  }
  EXPECT_GT(flat, 1000u);
}

TEST(LightTree, SplitsAlongTheLongestExtent) {
  Room room({.n_receivers = 1, .n_lights = 1024});
  Rng rng({1}, Stage::test, 3);
  for (std::size_t j = 0; j < room.lights.size(); ++j) {
    // A thin cloud along (1, 1, 0), all normals alike: halves meet at its middle.
    const float along = rng.next();
    room.lights.p[j] = Vec3{along, along, 0} + sample_sphere({rng.next(), rng.next()}) * 0.01f;
    room.lights.n[j] = room.lights.ng[j] = {0, 0, 1};
  }
  const LightTree tree = build(room);
  const LightNode root = tree.node(tree.roots[0]);
  const Box3 a = tree.node(root.left).box, b = tree.node(root.right).box;
  const float gap = std::max(a.lower.x - b.upper.x, b.lower.x - a.upper.x);
  EXPECT_GT(gap, -0.05f);  // they overlap by no more than the cloud is thick
}

TEST(LightTree, RepresentativeIsBelowItsNodeAndSharedWithOneChild) {
  const Room room({.n_receivers = 1, .n_lights = 2000, .kinds = kAllKinds, .glossy = true});
  const LightTree tree = build(room, {.seed = 4, .pass = 2});
  for (std::uint32_t number = 0; number < tree.size(); ++number) {
    const LightNode node = tree.node(number);
    const auto begin = tree.order.begin() + node.first;
    EXPECT_NE(std::find(begin, begin + node.count, node.representative), begin + node.count);
    if (!node.is_leaf()) {
      EXPECT_TRUE(node.representative == tree.node(node.left).representative ||
                  node.representative == tree.node(node.right).representative);
    }
  }
}

TEST(LightTree, RepresentativesAreDrawnInProportionToImportance) {
  // Chi-square of the root's representative over passes; 20 lights of different strength.
  const Room room({.n_receivers = 1, .n_lights = 20});
  constexpr int kPasses = 20000;
  std::vector<double> count(20);
  LightTree tree;
  for (int pass = 0; pass < kPasses; ++pass) {
    tree = build(room, {.seed = 11, .pass = static_cast<std::uint32_t>(pass)});
    ++count[index(tree.node(tree.roots[0]).representative)];
  }
  const double total = std::accumulate(tree.importance.begin(), tree.importance.end(), 0.0);
  double chi2 = 0, rare_expected = 0, rare_count = 0;
  int cells = 0;
  const auto add_cell = [&](double expected, double observed) {
    chi2 += (observed - expected) * (observed - expected) / expected, ++cells;
  };
  for (std::size_t j = 0; j < count.size(); ++j) {
    const double expected = kPasses * tree.importance[j] / total;
    if (expected < 10) {
      rare_expected += expected, rare_count += count[j];
    } else {
      add_cell(expected, count[j]);
    }
  }
  if (rare_expected > 5) add_cell(rare_expected, rare_count);
  // Wilson-Hilferty: the cube root of chi2 / dof is nearly normal. 4.5 sigma: 3e-6.
  const double dof = cells - 1, spread = 2 / (9 * dof);
  EXPECT_LT((std::cbrt(chi2 / dof) - (1 - spread)) / std::sqrt(spread), 4.5) << chi2 << " on " << dof;
  EXPECT_GT(cells, 8);
}

TEST(LightTree, IsTheSameForAnyNumberOfThreads) {
  const Room room({.n_receivers = 1, .n_lights = 40000, .kinds = kAllKinds, .glossy = true});
  LightTree first;
  for (const int threads : {1, 2, 7}) {
    const ThreadScope scope(threads);
    const LightTree tree = build(room, {.seed = 9});
    if (first.order.empty()) first = tree;
    ASSERT_EQ(tree.order, first.order) << threads;
    for (std::uint32_t k = 0; k < tree.size(); ++k) {
      ASSERT_EQ(tree.node(k).importance, first.node(k).importance);
      ASSERT_EQ(tree.node(k).representative, first.node(k).representative);
      ASSERT_EQ(tree.node(k).cone_axis, first.node(k).cone_axis);
      ASSERT_EQ(tree.node(k).box.upper, first.node(k).box.upper);
    }
  }
}

TEST(LightTree, LeavesOutLightsOfNoImportance) {
  Room room({.n_receivers = 1, .n_lights = 100});
  for (std::size_t j = 0; j < 100; j += 3) room.lights.light[j] = {};
  const LightTree tree = build(room);
  EXPECT_EQ(tree.n_lights(), 66u);
  for (const LightId j : tree.order) EXPECT_NE(index(j) % 3, 0u);
}

TEST(LightTree, OfCoincidingLightsIsStillATree) {
  Room room({.n_receivers = 1, .n_lights = 1000});
  std::fill(room.lights.p.begin(), room.lights.p.end(), Vec3{1, 2, 3});
  std::fill(room.lights.n.begin(), room.lights.n.end(), Vec3{0, 0, 1});
  const LightTree tree = build(room);
  EXPECT_EQ(tree.size(), 1999u);
  EXPECT_EQ(tree.node(0).cone_cos, 1);
}

}  // namespace
}  // namespace myrialux
