// The point tree: what its nodes promise of their receivers, and bounds of pairs of clusters never exceeded.
#include "myrialux/clusters/point_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <set>
#include <string>
#include <utility>

#include "myrialux/base/parallel.h"
#include "myrialux/clusters/bounds.h"
#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

using test::Room;
using test::RoomOptions;

constexpr float kClamp = 0.1f;

RoomOptions everything(std::size_t n_receivers) {
  return {.n_receivers = n_receivers,
          .n_lights = 2000,
          .kinds = {LightKind::oriented, LightKind::glossy, LightKind::point, LightKind::directional},
          .glossy = true,
          .glass = true,
          .blinn_phong = 0.2f,
          .shading_tilt = 0.2f};
}

/// 3 bits of sign: the octant of a normal.
int octant_of(Vec3 n) { return (n.x < 0 ? 4 : 0) | (n.y < 0 ? 2 : 0) | (n.z < 0 ? 1 : 0); }

TEST(PointTree, HoldsEveryReceiverOnceInConsecutivePlaces) {
  for (const std::size_t n : {1, 2, 7, 63, 64, 65, 9000}) {
    const Room room(everything(n));
    const PointTree tree = build_point_tree(room.world(), room.receivers, {});
    std::vector<ReceiverId> order = tree.order;
    std::sort(order.begin(), order.end());
    ASSERT_EQ(order.size(), n);
    for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(index(order[i]), i);

    std::size_t n_leaves = 0;
    ASSERT_EQ(tree.nodes[0].first, 0u);
    ASSERT_EQ(tree.nodes[0].count, n);
    for (std::uint32_t k = 0; k < tree.nodes.size(); ++k) {
      const PointNode& node = tree.nodes[k];
      const auto rows = tree.rows(node);
      EXPECT_NE(std::find(rows.begin(), rows.end(), node.representative), rows.end());
      n_leaves += node.is_leaf();
      if (node.is_leaf()) {
        ASSERT_EQ(node.count, 1u);
        continue;
      }
      ASSERT_GT(node.children, k);
      ASSERT_GE(node.n_children, 2u);
      ASSERT_LE(node.n_children, 8u);
      std::uint32_t place = node.first;
      for (std::uint32_t c = 0; c < node.n_children; ++c) {
        const PointNode& child = tree.nodes[node.children + c];
        ASSERT_EQ(child.first, place);
        place += child.count;
      }
      ASSERT_EQ(place, node.first + node.count);
    }
    EXPECT_EQ(n_leaves, n);
  }
}

TEST(PointTree, BoxesAndConesHoldWhatIsBelow) {
  const Room room(everything(9000));
  const PointTree tree = build_point_tree(room.world(), room.receivers, {});
  const Receivers& r = room.receivers;
  for (const PointNode& node : tree.nodes)
    for (const ReceiverId row : tree.rows(node)) {
      const std::size_t i = index(row);
      for (int a = 0; a < 3; ++a) {
        ASSERT_LE(node.box.lower[a], r.p[i][a]);
        ASSERT_GE(node.box.upper[a], r.p[i][a]);
      }
      // Rounding of a cosine.
      ASSERT_GE(dot(node.normals.axis, r.n[i]), node.normals.cos_angle - 1e-6f);
      const Bsdf bsdf = make_bsdf(room.world().scene.materials[index(r.bsdf[i].material)], r.bsdf[i], 0.1f);
      if (node.gloss > 0 && bsdf.kind != BsdfKind::diffuse && bsdf.kind != BsdfKind::plastic &&
          bsdf.kind != BsdfKind::rough_dielectric) {
        const Vec3 mirror = r.n[i] * (2 * dot(r.n[i], r.wo[i])) - r.wo[i];
        ASSERT_GE(dot(node.mirrors.axis, normalize(mirror)), node.mirrors.cos_angle - 1e-6f);
      }
    }
}

TEST(PointTree, FirstLevelsDivideNormals) {
  const Room room({.n_receivers = 5000});
  const PointTree tree = build_point_tree(room.world(), room.receivers, {.normal_levels = 1, .key = {}});
  ASSERT_EQ(tree.nodes[0].n_children, 8u);
  for (std::uint32_t c = 0; c < 8; ++c) {
    const PointNode& child = tree.nodes[tree.nodes[0].children + c];
    std::set<int> octants;
    for (const ReceiverId i : tree.rows(child)) octants.insert(octant_of(room.receivers.n[index(i)]));
    EXPECT_EQ(octants.size(), 1u);
  }
  // Three levels: normals in one of 8 x 8 x 8 cells lie in consecutive places.
  const PointTree three = build_point_tree(room.world(), room.receivers, {});
  std::set<std::array<int, 3>> seen;
  std::array<int, 3> last{-1, -1, -1};
  for (const ReceiverId i : three.order) {
    std::array<int, 3> cell{};
    for (int a = 0; a < 3; ++a)
      cell[a] = std::min(7, static_cast<int>((room.receivers.n[index(i)][a] * 0.5f + 0.5f) * 8));
    EXPECT_TRUE(cell == last || seen.insert(cell).second);
    last = cell;
  }
}

TEST(PointTree, CoincidentReceiversStillEndInLeavesOfTheirOwn) {
  Room room({.n_receivers = 300});
  for (std::size_t i = 0; i < 300; ++i) room.receivers.p[i] = {0.25f, 0.5f, 0.75f}, room.receivers.n[i] = {0, 0, 1};
  const PointTree tree = build_point_tree(room.world(), room.receivers, {});
  std::size_t n_leaves = 0;
  for (const PointNode& node : tree.nodes) n_leaves += node.is_leaf();
  EXPECT_EQ(n_leaves, 300u);
}

TEST(PointTree, IsTheSameForAnyNumberOfThreads) {
  const Room room(everything(20000));
  PointTree first;
  for (const int n_threads : {1, 2, 7}) {
    const ThreadScope threads(n_threads);
    const PointTree tree = build_point_tree(room.world(), room.receivers, {});
    if (first.nodes.empty()) first = tree;
    EXPECT_EQ(tree.order, first.order);
    ASSERT_EQ(tree.nodes.size(), first.nodes.size());
    for (std::size_t k = 0; k < tree.nodes.size(); ++k) {
      EXPECT_EQ(tree.nodes[k].representative, first.nodes[k].representative);
      EXPECT_EQ(tree.nodes[k].children, first.nodes[k].children);
      EXPECT_EQ(std::memcmp(&tree.nodes[k].box, &first.nodes[k].box, sizeof(Box3)), 0);
      EXPECT_EQ(std::memcmp(&tree.nodes[k].normals, &first.nodes[k].normals, sizeof(Cone)), 0);
    }
  }
}

struct PairCase {
  const char* name;
  RoomOptions options;
};

/// @param all pairs (value, weight), sorted
double quantile(const std::vector<std::pair<double, double>>& all, double share) {
  double total = 0, sum = 0;
  for (const auto& [value, weight] : all) total += weight;
  for (const auto& [value, weight] : all)
    if ((sum += weight) >= share * total) return value;
  return all.back().first;
}

/// Random pairs of clusters: the light that a random receiver gets from the whole light cluster, and from any one light
/// that stands for it, never exceeds the pair's bound. Tightness is told: bound over light, pairs weighted by light,
/// since those that send next to nothing may be bounded ever so badly.
void check_pairs(const PairCase& c, int n_pairs) {
  const Room room(c.options);
  const World world = room.world();
  const LightTree lights = build_light_tree(world, room.lights, Room::kRadius, {});
  const PointTree points = build_point_tree(world, room.receivers, {});
  Rng rng({29}, Stage::test, 0);
  int exceeded = 0, exceeded_by_one = 0;
  std::vector<std::pair<double, double>> ratios;  // bound over light, light
  for (int pair = 0; pair < n_pairs; ++pair) {
    const PointNode& point = points.nodes[rng.below(static_cast<std::uint32_t>(points.nodes.size()))];
    const std::uint32_t n = rng.below(lights.size());
    const LightNode node = lights.node(n);
    const ReceiverId i = points.order[point.first + rng.below(point.count)];
    const double bound = bound_pair(make_pair_receivers(point), make_cut_cluster(lights, n), kClamp * kClamp);
    // Rounding, as for bounds at single receivers: 2e-5 of the value; cosines near 0 are off by 1e-6.
    const double near = std::max<double>(distance_squared(node.box, room.receivers.p[index(i)]), kClamp * kClamp);
    const double slack = node.kind == LightKind::directional ? 1e-6 : 1e-6 * node.importance / near;
    const auto light_of = [&](LightId j) {
      return luminance(transfer(world, room.receivers, i, room.lights, j, kClamp));
    };
    if (node.kind != LightKind::glossy) {
      const LightId one = lights.order[node.first + rng.below(node.count)];
      exceeded_by_one += light_of(one) * node.importance / lights.importance[index(one)] > bound * (1 + 2e-5) + slack;
    }
    if (node.count > 32) continue;
    double sum = 0;
    for (std::uint32_t l = node.first; l < node.first + node.count; ++l) sum += light_of(lights.order[l]);
    exceeded += sum > bound * (1 + 2e-5) + slack;
    if (sum > 0 && node.count > 1 && !point.is_leaf()) ratios.emplace_back(bound / sum, sum);
  }
  EXPECT_EQ(exceeded, 0) << c.name;
  EXPECT_EQ(exceeded_by_one, 0) << c.name;
  std::sort(ratios.begin(), ratios.end());
  ASSERT_GT(ratios.size(), 50u);
  std::printf("bound / light of pairs, %s: median %.3g, 95 %% %.3g\n", c.name, quantile(ratios, 0.5),
              quantile(ratios, 0.95));
}

void check_all_rooms(int n_pairs) {
  const std::size_t n = 2000;
  for (const PairCase& c : {
           PairCase{"diffuse", {.n_receivers = n, .n_lights = 5000}},
           PairCase{"tilted", {.n_receivers = n, .n_lights = 5000, .shading_tilt = 0.3f}},
           PairCase{"points", {.n_receivers = n, .n_lights = 5000, .kinds = {LightKind::point}}},
           PairCase{"directional",
                    {.n_receivers = n, .n_lights = 5000, .kinds = {LightKind::directional}, .glossy = true}},
           PairCase{"glossy_receivers", {.n_receivers = n, .n_lights = 5000, .glossy = true, .shading_tilt = 0.1f}},
           PairCase{"all_glossy", {.n_receivers = n, .n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true}},
           PairCase{"blinn_phong_receivers",
                    {.n_receivers = n, .n_lights = 5000, .glossy = true, .blinn_phong = 1, .shading_tilt = 0.1f}},
           PairCase{
               "all_blinn_phong",
               {.n_receivers = n, .n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true, .blinn_phong = 1}},
           PairCase{
               "mixed_gloss",
               {.n_receivers = n, .n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true, .blinn_phong = 0.4f}},
           PairCase{"everything", everything(n)},
       })
    check_pairs(c, n_pairs);
}

TEST(PairBound, IsNeverExceeded) { check_all_rooms(4000); }
TEST(PairBound, IsNeverExceededInAMillionPairsSlow) { check_all_rooms(150000); }

}  // namespace
}  // namespace myrialux
