// Global clusters of the reduced matrix's columns: sampled centres, every column joined to the cheapest.
// [hasan07; ou11]
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/clusters/reduced_matrix.h"

namespace myrialux {

/// Columns as vectors of equal length, one after another, and their Euclidean norms.
struct ColumnVectors {
  std::size_t dimension = 0;
  std::vector<float> x;     ///< [n_columns x dimension]
  std::vector<float> norm;  ///< [n_columns]
  std::size_t size() const { return norm.size(); }
  std::span<const float> column(std::size_t j) const { return std::span(x).subspan(j * dimension, dimension); }
};

/// Norms of R's columns over all its rows. Same bits for any number of threads.
std::vector<float> column_norms(const ReducedMatrix& reduced);

/// Columns projected from n_rows to n_dimensions by a random matrix of +-1 / sqrt(n_dimensions), which keeps inner
/// products in the mean; taken as they are where there are no more rows than that. Same bits for any number of threads.
ColumnVectors project_columns(const ReducedMatrix& reduced, std::uint32_t n_dimensions, RandomKey key);

/// What it costs to let one column stand for all of a cluster: sum over pairs of |x_a| |x_b| - x_a . x_b, each pair
/// counted twice. [hasan07]  In linear time, as (sum of norms)^2 - |sum of vectors|^2.
double cluster_cost(const ColumnVectors& columns, std::span<const std::uint32_t> cluster);

/// A partition of columns: cluster c holds order[begin[c] .. begin[c + 1]).
struct ColumnClusters {
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> begin;  ///< [n_clusters + 1]
  std::size_t size() const { return begin.empty() ? 0 : begin.size() - 1; }
  std::span<const std::uint32_t> columns(std::size_t c) const {
    return std::span(order).subspan(begin[c], begin[c + 1] - begin[c]);
  }
};

/// Draws n_clusters centres (one drawn k times counts once) with probability p in proportion to what a column adds to
/// the cost of all in one cluster, and joins each column to the centre of least |c| |x| - c . x, centres scaled by
/// k / p. Columns of zeros make one more cluster, the last. None is empty; columns ascend in each.
ColumnClusters sample_clusters(const ColumnVectors& columns, std::uint32_t n_clusters, RandomKey key);

}  // namespace myrialux
