// Clusters of one slice: the global ones, split where the rows of its neighbourhood tell their columns apart. [ou11]
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/clusters/column_clusters.h"
#include "myrialux/clusters/cut.h"

namespace myrialux {

inline constexpr std::size_t kMostNeighbours = 8;

/// The slices whose rows a slice's clusters are judged by: those with the nearest centres (mean position, mean normal
/// times normal_scale), itself first, nearest next, ties to the lower number.
using Neighbours = std::vector<std::uint32_t>;
/// @param n_neighbours 1 to kMostNeighbours, the slice itself included
std::vector<Neighbours> find_neighbours(const Receivers& receivers, const Slices& slices, float normal_scale,
                                        std::uint32_t n_neighbours);

/// A column as one slice sees it; moved around whole, so that every split reads memory in order. 48 bytes.
struct LocalColumn {
  std::array<float, kMostNeighbours> x;  ///< entries in the neighbours' rows, 0 beyond their number
  float norm;                            ///< of x
  float global_norm;                     ///< over all rows
  std::uint32_t column;
  float key;  ///< position along the line being split
};

/// The columns in the order of `clusters`.
std::vector<LocalColumn> local_columns(const ReducedMatrix& reduced, std::span<const float> global_norms,
                                       std::span<const std::uint32_t> neighbours, const ColumnClusters& clusters);

/// As cluster_cost(), over the neighbours' rows.
double local_cost(std::span<const LocalColumn> cluster);

/// Splits until there are n_clusters or every cluster holds one column; sorts `columns` by cluster. Next to be split is
/// the largest cost [ou11], among those without cost the largest sum of global norms, then the most columns. Split in
/// two at the middle of the projections on the line through the two columns of largest norms; by count, in
/// the order of columns, where all project to one point.
/// Cost: two passes over a cluster a split.
/// @param first  where each cluster begins in `columns`, and their number at the end
/// @return the same for the refined clusters, ascending
std::vector<std::uint32_t> refine_clusters(std::span<LocalColumn> columns, std::span<const std::uint32_t> first,
                                           std::uint32_t n_clusters);

/// How one column is drawn to stand for its cluster; its weight is 1 / probability, so that sums are right in the mean
/// wherever the probability is above 0.
struct DrawParams {
  float local_share = 0;  ///< drawn by norms in the neighbourhood; the rest by norms over all rows of R
  float power_share = 0;  ///< of all: drawn by `importance` alone, whatever R says; 0: clusters that no row sees vanish
};
struct Drawn {
  std::uint32_t column;
  float weight;
};
/// Weight 0: the cluster stands for nothing. Clusters of one column have weight 1.
/// @param importance by column; @param u uniform in [0, 1)
Drawn draw_representative(std::span<const LocalColumn> cluster, std::span<const float> importance,
                          const DrawParams& params, float u);

}  // namespace myrialux
