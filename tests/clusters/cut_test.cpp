// Light cuts: exact size, every light once, unbiased with random representatives, better with more clusters.
#include "myrialux/clusters/cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "myrialux/base/parallel.h"
#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

using test::Room;

constexpr float kClamp = 0.2f;
const std::vector<LightKind> kAllKinds = {LightKind::oriented, LightKind::glossy, LightKind::point,
                                          LightKind::directional};

std::vector<ReceiverId> all_rows(const Room& room) {
  std::vector<ReceiverId> rows;
  for (std::size_t i = 0; i < room.receivers.size(); ++i) rows.push_back(static_cast<ReceiverId>(i));
  return rows;
}

LightTree build(const Room& room, RandomKey key = {}) {
  return build_light_tree(room.world(), room.lights, Room::kRadius, {.key = key});
}

std::vector<Column> cut(const Room& room, const LightTree& tree, std::uint32_t n_clusters,
                        std::uint32_t n_points = 16) {
  return light_cut(room.world(), room.receivers, all_rows(room), room.lights, tree,
                   {.n_clusters = n_clusters, .n_points = n_points, .clamp_distance = kClamp});
}

double light_of(const Room& room, ReceiverId i, LightId j) {
  return luminance(transfer(room.world(), room.receivers, i, room.lights, j, kClamp));
}
double light_of_all(const Room& room, ReceiverId i) {
  double sum = 0;
  for (std::size_t j = 0; j < room.lights.size(); ++j) sum += light_of(room, i, static_cast<LightId>(j));
  return sum;
}
double light_of_cut(const Room& room, ReceiverId i, std::span<const Column> columns) {
  double sum = 0;
  for (const Column& c : columns) sum += c.weight * light_of(room, i, c.light);
  return sum;
}

TEST(LightCut, HasExactlyTheSizeAskedForAndHoldsEveryLightOnce) {
  const Room room({.n_receivers = 100, .n_lights = 997, .kinds = kAllKinds, .glossy = true});
  const LightTree tree = build(room);
  for (const std::uint32_t n : {1u, 4u, 5u, 63u, 64u, 65u, 500u, 996u, 997u, 5000u}) {
    const std::vector<Column> columns = cut(room, tree, n);
    EXPECT_EQ(columns.size(), std::clamp<std::size_t>(n, 4, 997));  // at least one a kind
    std::vector<int> seen(room.lights.size());
    double weighted = 0;
    for (const Column& c : columns) {
      const LightNode node = tree.node(c.node);
      EXPECT_EQ(c.count, node.count);
      EXPECT_EQ(c.light, node.representative);
      for (std::uint32_t l = node.first; l < node.first + node.count; ++l) ++seen[index(tree.order[l])];
      weighted += static_cast<double>(c.weight) * tree.importance[index(c.light)];
    }
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](int s) { return s == 1; }));
    const double total = std::accumulate(tree.importance.begin(), tree.importance.end(), 0.0);
    EXPECT_NEAR(weighted, total, 1e-5 * total);
  }
}

TEST(LightCut, GrowsStepByStepIntoTheSameCut) {
  const Room room({.n_receivers = 100, .n_lights = 997, .kinds = kAllKinds, .glossy = true});
  const LightTree tree = build(room);
  GrowingCut growing(room.world(), room.receivers, all_rows(room), tree,
                     {.n_clusters = 1, .n_points = 16, .clamp_distance = kClamp});
  for (const std::uint32_t n : {4u, 5u, 64u, 500u, 5000u}) {
    growing.grow(n);
    std::vector<std::uint32_t> nodes = growing.nodes(), expected;
    for (const Column& c : cut(room, tree, n)) expected.push_back(c.node);
    std::sort(nodes.begin(), nodes.end()), std::sort(expected.begin(), expected.end());
    EXPECT_EQ(nodes, expected);
    EXPECT_EQ(growing.size(), nodes.size());
  }
}

TEST(LightCut, OfAllLightsIsExact) {
  const Room room({.n_receivers = 50, .n_lights = 300, .kinds = kAllKinds, .glossy = true, .glass = true});
  const std::vector<Column> columns = cut(room, build(room), 300);
  for (const Column& c : columns) EXPECT_EQ(c.weight, 1);
  for (const ReceiverId i : all_rows(room)) {
    const double all = light_of_all(room, i);
    EXPECT_NEAR(light_of_cut(room, i, columns), all, 1e-12 + 1e-9 * all);
  }
}

TEST(LightCut, OfNoLightsIsEmpty) {
  const Room room({.n_receivers = 3, .n_lights = 0});
  EXPECT_TRUE(cut(room, build(room), 10).empty());
}

TEST(LightCut, IsOrderedByKindOctantAndTree) {
  const Room room({.n_receivers = 100, .n_lights = 2000, .kinds = kAllKinds, .glossy = true});
  const LightTree tree = build(room);
  const std::vector<Column> columns = cut(room, tree, 300);
  const Vec3 centre = slice_centre(room.receivers, all_rows(room));
  const auto key = [&](const Column& c) {
    return std::tuple(tree.node(c.node).kind, c.octant, tree.node(c.node).first);
  };
  for (std::size_t k = 0; k < columns.size(); ++k) {
    EXPECT_EQ(columns[k].octant, octant(centre, room.lights, columns[k].light));
    if (k > 0) {
      EXPECT_LT(key(columns[k - 1]), key(columns[k]));
    }
  }
}

TEST(LightCut, WithRandomRepresentativesIsUnbiased) {
  // Mean over passes of the clustered sum against the sum over all lights: z-test, 4.5 sigma.
  const Room room({.n_receivers = 24, .n_lights = 1200, .kinds = kAllKinds, .glossy = true, .glass = true});
  double truth = 0;
  for (const ReceiverId i : all_rows(room)) truth += light_of_all(room, i);
  constexpr int kPasses = 300;
  double sum = 0, sum2 = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    const std::vector<Column> columns =
        cut(room, build(room, {.seed = 2, .pass = static_cast<std::uint32_t>(pass)}), 80);
    double estimate = 0;
    for (const ReceiverId i : all_rows(room)) estimate += light_of_cut(room, i, columns);
    sum += estimate, sum2 += estimate * estimate;
  }
  const double mean = sum / kPasses, variance = (sum2 / kPasses - mean * mean) / (kPasses - 1);
  EXPECT_LT(std::fabs(mean - truth), 4.5 * std::sqrt(variance)) << mean << " against " << truth;
  EXPECT_LT(std::sqrt(variance), 0.02 * truth);  // the test would see a bias of a tenth
}

TEST(LightCut, ErrsLessWithMoreClusters) {
  // Relative RMSE over receivers and passes at least halves each time the number of clusters grows fourfold:
  // columns without clusters converge like 1 / sqrt(n), which is that.
  const Room room({.n_receivers = 32, .n_lights = 20000});
  const LightTree trees[] = {build(room, {.pass = 0}), build(room, {.pass = 1}), build(room, {.pass = 2})};
  std::vector<double> truth;
  for (const ReceiverId i : all_rows(room)) truth.push_back(light_of_all(room, i));
  double last = 0;
  for (const std::uint32_t n : {50u, 200u, 800u, 3200u}) {
    double error = 0;
    for (const LightTree& tree : trees) {
      const std::vector<Column> columns = cut(room, tree, n);
      for (std::size_t i = 0; i < truth.size(); ++i)
        error += std::pow(light_of_cut(room, static_cast<ReceiverId>(i), columns) / truth[i] - 1, 2);
    }
    error = std::sqrt(error / static_cast<double>(3 * truth.size()));
    RecordProperty("relative_rmse_" + std::to_string(n), std::to_string(error));
    if (last > 0) {
      EXPECT_LT(error, 0.6 * last) << n;
    }
    last = error;
  }
  EXPECT_LT(last, 0.02);
}

TEST(LightCut, IsTheSameForAnyNumberOfThreads) {
  const Room room({.n_receivers = 200, .n_lights = 20000, .kinds = kAllKinds, .glossy = true});
  std::vector<Column> first;
  for (const int threads : {1, 2, 7}) {
    const ThreadScope scope(threads);
    const std::vector<Column> columns = cut(room, build(room), 700, 0);
    if (first.empty()) first = columns;
    ASSERT_EQ(columns.size(), first.size());
    for (std::size_t k = 0; k < columns.size(); ++k) {
      ASSERT_EQ(columns[k].node, first[k].node);
      ASSERT_EQ(columns[k].light, first[k].light);
      ASSERT_EQ(columns[k].weight, first[k].weight);
    }
  }
}

}  // namespace
}  // namespace myrialux
