// Clusters of the reduced matrix's columns: cost, partition, refinement, and who is drawn.
#include "myrialux/clusters/column_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "myrialux/base/parallel.h"
#include "myrialux/clusters/refined_clusters.h"
#include "support/statistics.h"

namespace myrialux {
namespace {

/// Few distinct directions, brightnesses over three decades, a third of the entries 0, every tenth column 0.
ReducedMatrix planted_matrix(std::size_t n_rows, std::size_t n_columns, std::uint64_t seed = 1) {
  ReducedMatrix matrix(n_rows, n_columns);
  std::vector<float> row(n_columns);
  for (std::size_t i = 0; i < n_rows; ++i) {
    for (std::size_t j = 0; j < n_columns; ++j) {
      Rng shape(RandomKey{seed}, Stage::test, i * 16 + j % 13), own(RandomKey{seed + 1}, Stage::test, j);
      const float brightness = std::pow(10.0f, -3 * own.next());
      row[j] = j % 10 == 9 || shape.next() < 0.33f ? 0 : brightness * shape.next();
    }
    matrix.set(i, 0, row);
  }
  return matrix;
}

std::vector<float> row_of(const ReducedMatrix& matrix, std::size_t i) {
  std::vector<float> row(matrix.n_columns());
  matrix.get(i, 0, row);
  return row;
}

std::vector<std::uint32_t> all_columns(std::size_t n) {
  std::vector<std::uint32_t> columns(n);
  std::iota(columns.begin(), columns.end(), 0u);
  return columns;
}

void expect_every_column_once(std::span<const std::uint32_t> order, std::size_t n) {
  std::vector<std::uint32_t> sorted(order.begin(), order.end());
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, all_columns(n));
}

TEST(ReducedMatrix, KeepsEntriesToTheirUpperHalf) {
  ReducedMatrix matrix(3, 70);
  std::vector<float> values(70), back(70);
  Rng rng({5}, Stage::test, 0);
  for (float& v : values) v = std::pow(10.0f, 60 * rng.next() - 30);
  values[3] = 0;
  matrix.set(1, 0, values);
  matrix.get(1, 0, back);
  for (std::size_t k = 0; k < values.size(); ++k) EXPECT_NEAR(back[k], values[k], values[k] * 0x1p-8f);
  EXPECT_EQ(back[3], 0);
  EXPECT_EQ(row_of(matrix, 0), std::vector<float>(70));
}

TEST(ColumnClusters, CostIsTheSumOverPairs) {
  const ReducedMatrix matrix = planted_matrix(20, 150);
  const ColumnVectors columns = project_columns(matrix, 64, {});
  ASSERT_EQ(columns.dimension, 20u);
  double by_pairs = 0;
  for (std::size_t a = 0; a < columns.size(); ++a)
    for (std::size_t b = 0; b < columns.size(); ++b) {
      double product = 0;
      for (std::size_t d = 0; d < columns.dimension; ++d)
        product += static_cast<double>(columns.column(a)[d]) * static_cast<double>(columns.column(b)[d]);
      by_pairs += static_cast<double>(columns.norm[a]) * static_cast<double>(columns.norm[b]) - product;
    }
  EXPECT_NEAR(cluster_cost(columns, all_columns(150)), by_pairs, 1e-6 * by_pairs);
}

TEST(ColumnClusters, ParallelColumnsCostNothing) {
  ReducedMatrix matrix(4, 5);
  for (std::size_t i = 0; i < 4; ++i) {
    const float x = static_cast<float>(i + 1);
    matrix.set(i, 0, std::vector<float>{x, 2 * x, 4 * x, 0.5f * x, 0});
  }
  const ColumnVectors columns = project_columns(matrix, 50, {});
  const double norms = std::accumulate(columns.norm.begin(), columns.norm.end(), 0.0);
  EXPECT_NEAR(cluster_cost(columns, all_columns(5)), 0, 1e-6 * norms * norms);
}

TEST(ColumnClusters, ProjectionKeepsNormsInTheMean) {
  const ReducedMatrix matrix = planted_matrix(300, 40);
  const std::vector<float> norms = column_norms(matrix);
  test::Sample ratio;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const ColumnVectors columns = project_columns(matrix, 50, {seed});
    ASSERT_EQ(columns.dimension, 50u);
    double projected = 0, exact = 0;
    for (std::size_t j = 0; j < norms.size(); ++j)
      projected += std::pow(columns.norm[j], 2), exact += std::pow(norms[j], 2);
    ratio.add(projected / exact);
  }
  EXPECT_LT(std::abs(test::z_score(ratio, 1)), 4);
  EXPECT_LT(std::sqrt(ratio.variance_of_mean() * 100), 0.3);  // about sqrt(2 / 50) = 0.2 for one column
}

TEST(ColumnClusters, SampledClustersPartitionTheColumnsZerosApart) {
  const ReducedMatrix matrix = planted_matrix(90, 700);
  const ColumnVectors columns = project_columns(matrix, 50, {});
  for (const std::uint32_t n : {1u, 30u, 2000u}) {
    const ColumnClusters clusters = sample_clusters(columns, n, {});
    expect_every_column_once(clusters.order, 700);
    EXPECT_LE(clusters.size(), n + 1);
    for (std::size_t c = 0; c < clusters.size(); ++c) {
      ASSERT_FALSE(clusters.columns(c).empty());
      EXPECT_TRUE(std::is_sorted(clusters.columns(c).begin(), clusters.columns(c).end()));
      for (const std::uint32_t j : clusters.columns(c))
        EXPECT_EQ(columns.norm[j] == 0, c + 1 == clusters.size()) << "column " << j;
    }
  }
}

TEST(ColumnClusters, MoreSampledClustersCostLess) {
  const ReducedMatrix matrix = planted_matrix(90, 2000);
  const ColumnVectors columns = project_columns(matrix, 90, {});
  double last = cluster_cost(columns, all_columns(2000));
  // Columns have 13 directions, so 64 centres find most of them. Measured shares of the first cost: 0.22, 0.014, 2e-5.
  for (const std::uint32_t n : {4u, 16u, 64u}) {
    const ColumnClusters clusters = sample_clusters(columns, n, {7});
    double cost = 0;
    for (std::size_t c = 0; c < clusters.size(); ++c) cost += cluster_cost(columns, clusters.columns(c));
    EXPECT_LT(cost, 0.5 * last) << n << " centres";
    last = cost;
  }
}

TEST(ColumnClusters, SameForAnyNumberOfThreads) {
  const ReducedMatrix matrix = planted_matrix(90, 3000);
  ColumnClusters first;
  for (const int n_threads : {1, 2, 7}) {
    const ThreadScope threads(n_threads);
    const ColumnClusters clusters = sample_clusters(project_columns(matrix, 50, {}), 100, {});
    if (first.order.empty()) first = clusters;
    EXPECT_EQ(clusters.order, first.order);
    EXPECT_EQ(clusters.begin, first.begin);
  }
}

TEST(ColumnClusters, MatrixOfZerosIsOneCluster) {
  const ColumnVectors columns = project_columns(ReducedMatrix(5, 30), 50, {});
  EXPECT_EQ(sample_clusters(columns, 10, {}).size(), 1u);
}

struct Local {
  ReducedMatrix matrix = planted_matrix(60, 900);
  std::vector<float> norms = column_norms(matrix);
  ColumnClusters clusters = sample_clusters(project_columns(matrix, 50, {}), 20, {});
  std::vector<LocalColumn> columns = local_columns(matrix, norms, std::vector<std::uint32_t>{7, 3, 40, 8, 9}, clusters);
};

TEST(RefinedClusters, LocalColumnsHoldTheNeighboursRows) {
  const Local l;
  const std::vector<float> row = row_of(l.matrix, 40);
  for (std::size_t k = 0; k < l.columns.size(); ++k) {
    EXPECT_EQ(l.columns[k].column, l.clusters.order[k]);
    EXPECT_EQ(l.columns[k].x[2], row[l.columns[k].column]);
    EXPECT_EQ(l.columns[k].x[5], 0);
    EXPECT_EQ(l.columns[k].global_norm, l.norms[l.columns[k].column]);
  }
}

TEST(RefinedClusters, LocalCostIsTheSumOverPairs) {
  const Local l;
  const auto cluster = std::span(l.columns).first(100);
  double by_pairs = 0;
  for (const LocalColumn& a : cluster)
    for (const LocalColumn& b : cluster) {
      double product = 0, aa = 0, bb = 0;
      for (std::size_t d = 0; d < kMostNeighbours; ++d) {
        product += static_cast<double>(a.x[d]) * static_cast<double>(b.x[d]);
        aa += std::pow(a.x[d], 2), bb += std::pow(b.x[d], 2);
      }
      by_pairs += std::sqrt(aa * bb) - product;
    }
  EXPECT_NEAR(local_cost(cluster), by_pairs, 1e-5 * by_pairs);
}

TEST(RefinedClusters, PartitionTheColumnsIntoAsManyAsAskedFor) {
  for (const std::uint32_t n : {5u, 21u, 64u, 300u, 899u, 900u, 5000u}) {
    Local l;
    const std::vector<std::uint32_t> begins = refine_clusters(l.columns, l.clusters.begin, n);
    EXPECT_EQ(begins.size() - 1, std::clamp<std::size_t>(n, l.clusters.size(), 900));
    EXPECT_EQ(begins.front(), 0u);
    EXPECT_EQ(begins.back(), 900u);
    EXPECT_TRUE(std::adjacent_find(begins.begin(), begins.end(), std::greater_equal<>()) == begins.end());
    std::vector<std::uint32_t> order;
    for (const LocalColumn& c : l.columns) order.push_back(c.column);
    expect_every_column_once(order, 900);
  }
}

TEST(RefinedClusters, CostFallsAsTheyGrowInNumber) {
  double last = INFINITY;
  for (const std::uint32_t n : {20u, 40u, 80u, 160u}) {
    Local l;
    const std::vector<std::uint32_t> begins = refine_clusters(l.columns, l.clusters.begin, n);
    double cost = 0;
    for (std::size_t c = 0; c + 1 < begins.size(); ++c)
      cost += local_cost(std::span(l.columns).subspan(begins[c], begins[c + 1] - begins[c]));
    EXPECT_LT(cost, 0.7 * last) << n;
    last = cost;
  }
}

/// A cluster of four: seen nearby, seen elsewhere only, seen by no row, and seen by both.
std::vector<LocalColumn> mixed_cluster() {
  return {{{3, 4}, 5, 8, 0, 0}, {{}, 0, 2, 1, 0}, {{}, 0, 0, 2, 0}, {{1}, 1, 1, 3, 0}};
}
constexpr float kPower[] = {1, 2, 3, 4};

/// Mean over u of weight * value[drawn].
double mean_of_draws(const DrawParams& params, std::span<const float> value) {
  constexpr int kDraws = 100000;
  const std::vector<LocalColumn> cluster = mixed_cluster();
  double sum = 0;
  for (int k = 0; k < kDraws; ++k) {
    const Drawn d = draw_representative(cluster, kPower, params, (static_cast<float>(k) + 0.5f) / kDraws);
    sum += static_cast<double>(d.weight) * static_cast<double>(value[d.column]);
  }
  return sum / kDraws;
}

TEST(RefinedClusters, DrawsAreRightInTheMeanWhereTheyAreDrawnAtAll) {
  const float value[] = {7, 11, 13, 17};
  // Stratified u: the mean is off by at most a few weights over the number of draws.
  EXPECT_NEAR(mean_of_draws({.local_share = 0, .power_share = 0}, value), 7 + 11 + 17, 0.02);
  EXPECT_NEAR(mean_of_draws({.local_share = 0.5f, .power_share = 0}, value), 7 + 11 + 17, 0.02);
  EXPECT_NEAR(mean_of_draws({.local_share = 1, .power_share = 0}, value), 7 + 17, 0.02);
  EXPECT_NEAR(mean_of_draws({.local_share = 0.5f, .power_share = 0.1f}, value), 7 + 11 + 13 + 17, 0.02);
}

TEST(RefinedClusters, ClusterThatNoRowSeesVanishesUnlessDrawnByPower) {
  const std::vector<LocalColumn> dark = {{{}, 0, 0, 0, 0}, {{}, 0, 0, 1, 0}};
  EXPECT_EQ(draw_representative(dark, kPower, {}, 0.5f).weight, 0);
  EXPECT_EQ(draw_representative(dark, kPower, {.local_share = 1, .power_share = 0}, 0.5f).weight, 0);
  const Drawn d = draw_representative(dark, kPower, {.local_share = 0, .power_share = 0.1f}, 0.5f);
  EXPECT_EQ(d.column, 1u);
  EXPECT_FLOAT_EQ(d.weight, 1.5f);
  EXPECT_EQ(draw_representative(std::span(dark).first(1), kPower, {}, 0.5f).weight, 1);  // alone it stands for itself
}

}  // namespace
}  // namespace myrialux
