// Samples centres among the columns of the reduced matrix and joins every column to one. [hasan07; ou11]
// Deviation: random projection by +-1, which keeps inner products; [ou11]'s program draws from [0, 1).
#include "myrialux/clusters/column_clusters.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "myrialux/base/parallel.h"
#include "myrialux/math/distribution.h"

namespace myrialux {
namespace {

constexpr std::size_t kTile = 256;  ///< columns read from all rows at a time

/// Items of Stage::cut; slices have theirs from 0 on.
constexpr std::uint64_t kProjectionItem = std::uint64_t{2} << 32, kCentreItem = std::uint64_t{3} << 32;

/// Calls body(first, n) for tiles of columns, in parallel.
template <class Body>
void for_each_tile(std::size_t n_columns, const Body& body) {
  parallel_for((n_columns + kTile - 1) / kTile,
               [&](std::size_t t) { body(t * kTile, std::min(kTile, n_columns - t * kTile)); });
}

double dot(std::span<const float> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t d = 0; d < a.size(); ++d) sum += static_cast<double>(a[d]) * b[d];
  return sum;
}

float norm_of(std::span<const float> x) {
  double sum = 0;
  for (const float v : x) sum += static_cast<double>(v) * static_cast<double>(v);
  return static_cast<float>(std::sqrt(sum));
}

/// Random matrix, [n_rows x n_dimensions].
std::vector<float> random_signs(std::size_t n_rows, std::size_t n_dimensions, RandomKey key) {
  std::vector<float> signs(n_rows * n_dimensions);
  const float length = 1 / std::sqrt(static_cast<float>(n_dimensions));
  parallel_for(n_rows, [&](std::size_t i) {
    Rng rng(key, Stage::cut, kProjectionItem + i);
    for (std::size_t d = 0; d < n_dimensions; ++d)
      signs[i * n_dimensions + d] = rng.next_uint() >> 31 ? length : -length;
  });
  return signs;
}

/// Sampled centres, side by side by dimension, so that a column meets all of them at once.
struct Centres {
  std::size_t n = 0;
  std::vector<float> x;     ///< [dimension x n]
  std::vector<float> norm;  ///< [n]
};
Centres sample_centres(const ColumnVectors& columns, std::uint32_t n_clusters, RandomKey key);
std::uint32_t cheapest_centre(const Centres& centres, std::span<const float> x, float norm, std::vector<float>& cost);

}  // namespace

std::vector<float> column_norms(const ReducedMatrix& reduced) {
  std::vector<float> norms(reduced.n_columns());
  for_each_tile(reduced.n_columns(), [&](std::size_t first, std::size_t n) {
    std::vector<float> values(n);
    std::vector<double> squares(n);
    for (std::size_t i = 0; i < reduced.n_rows(); ++i) {
      reduced.get(i, first, values);
      for (std::size_t k = 0; k < n; ++k) squares[k] += static_cast<double>(values[k]) * static_cast<double>(values[k]);
    }
    for (std::size_t k = 0; k < n; ++k) norms[first + k] = static_cast<float>(std::sqrt(squares[k]));
  });
  return norms;
}

ColumnVectors project_columns(const ReducedMatrix& reduced, std::uint32_t n_dimensions, RandomKey key) {
  const bool whole = reduced.n_rows() <= n_dimensions;
  const std::size_t dimension = whole ? reduced.n_rows() : n_dimensions;
  const std::vector<float> signs = whole ? std::vector<float>() : random_signs(reduced.n_rows(), dimension, key);
  ColumnVectors columns{dimension, std::vector<float>(reduced.n_columns() * dimension),
                        std::vector<float>(reduced.n_columns())};
  for_each_tile(reduced.n_columns(), [&](std::size_t first, std::size_t n) {
    std::vector<float> values(n);
    for (std::size_t i = 0; i < reduced.n_rows(); ++i) {
      reduced.get(i, first, values);
      for (std::size_t k = 0; k < n; ++k) {
        float* const x = columns.x.data() + (first + k) * dimension;
        if (whole) {
          x[i] = values[k];
        } else if (values[k] != 0) {  // most entries are: no sight, or the wrong side
          const float* const sign = signs.data() + i * dimension;
          for (std::size_t d = 0; d < dimension; ++d) x[d] += values[k] * sign[d];
        }
      }
    }
    for (std::size_t j = first; j < first + n; ++j) columns.norm[j] = norm_of(columns.column(j));
  });
  return columns;
}

double cluster_cost(const ColumnVectors& columns, std::span<const std::uint32_t> cluster) {
  std::vector<double> sum(columns.dimension);
  double norms = 0, square = 0;
  for (const std::uint32_t j : cluster) {
    norms += static_cast<double>(columns.norm[j]);
    const std::span<const float> x = columns.column(j);
    for (std::size_t d = 0; d < x.size(); ++d) sum[d] += static_cast<double>(x[d]);
  }
  for (const double s : sum) square += s * s;
  return std::max(0.0, norms * norms - square);
}

ColumnClusters sample_clusters(const ColumnVectors& columns, std::uint32_t n_clusters, RandomKey key) {
  const Centres centres = sample_centres(columns, n_clusters, key);
  const auto n_centres = static_cast<std::uint32_t>(centres.n);
  std::vector<std::uint32_t> cluster_of(columns.size());
  for_each_tile(columns.size(), [&](std::size_t first, std::size_t n) {
    std::vector<float> cost;
    for (std::size_t j = first; j < first + n; ++j)
      cluster_of[j] =
          columns.norm[j] > 0 ? cheapest_centre(centres, columns.column(j), columns.norm[j], cost) : n_centres;
  });

  // Sorted by counting; empty clusters are left out.
  std::vector<std::uint32_t> place(n_centres + 2);
  for (const std::uint32_t c : cluster_of) ++place[c + 1];
  ColumnClusters clusters;
  clusters.order.resize(columns.size());
  clusters.begin.push_back(0);
  for (std::size_t c = 0; c <= n_centres; ++c) {
    place[c + 1] += place[c];
    if (place[c + 1] > place[c]) clusters.begin.push_back(place[c + 1]);
  }
  for (std::size_t j = 0; j < columns.size(); ++j)
    clusters.order[place[cluster_of[j]]++] = static_cast<std::uint32_t>(j);
  return clusters;
}

namespace {

Centres sample_centres(const ColumnVectors& columns, std::uint32_t n_clusters, RandomKey key) {
  // What column j adds to the cost of one cluster of all: |x_j| sum |x| - x_j . sum x.
  std::vector<double> sum(columns.dimension);
  double norms = 0;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    norms += static_cast<double>(columns.norm[j]);
    const std::span<const float> x = columns.column(j);
    for (std::size_t d = 0; d < x.size(); ++d) sum[d] += static_cast<double>(x[d]);
  }
  std::vector<float> share(columns.size());
  for (std::size_t j = 0; j < columns.size(); ++j)
    share[j] =
        static_cast<float>(std::max(0.0, static_cast<double>(columns.norm[j]) * norms - dot(columns.column(j), sum)));
  if (norms <= 0) return {};
  // All columns parallel, up to rounding: nothing to choose between them.
  const Distribution1D by_cost(share);
  const Distribution1D chosen = by_cost.sum() > 1e-6 * norms * norms ? by_cost : Distribution1D(columns.norm);

  // Stratified draws; a map keeps the centres in order of columns.
  std::map<std::size_t, double> drawn;
  Rng rng(key, Stage::cut, kCentreItem);
  for (std::uint32_t k = 0; k < n_clusters; ++k) {
    const float u = (static_cast<float>(k) + rng.next()) / static_cast<float>(n_clusters);
    const Distribution1D::Sample s = chosen.sample(std::min(u, 0x1.fffffep-1f));
    drawn[s.index] += 1 / static_cast<double>(s.probability);
  }
  Centres centres;
  centres.n = drawn.size();
  centres.x.resize(columns.dimension * centres.n);
  std::size_t c = 0;
  for (const auto& [j, scale] : drawn) {
    centres.norm.push_back(static_cast<float>(scale * static_cast<double>(columns.norm[j])));
    for (std::size_t d = 0; d < columns.dimension; ++d)
      centres.x[d * centres.n + c] = static_cast<float>(scale * static_cast<double>(columns.column(j)[d]));
    ++c;
  }
  return centres;
}

std::uint32_t cheapest_centre(const Centres& centres, std::span<const float> x, float norm, std::vector<float>& cost) {
  cost.assign(centres.n, 0);
  for (std::size_t d = 0; d < x.size(); ++d) {
    const float* const row = centres.x.data() + d * centres.n;
    for (std::size_t c = 0; c < centres.n; ++c) cost[c] -= x[d] * row[c];
  }
  std::uint32_t best = 0;
  for (std::size_t c = 0; c < centres.n; ++c) {
    cost[c] += norm * centres.norm[c];
    if (cost[c] < cost[best]) best = static_cast<std::uint32_t>(c);
  }
  return best;
}

}  // namespace
}  // namespace myrialux
