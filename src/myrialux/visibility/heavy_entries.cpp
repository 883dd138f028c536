// Columns that cannot reach the limit anywhere in the slice's box are left out first; the others are bounded packet by
// packet.
#include "myrialux/visibility/heavy_entries.h"

#include <algorithm>

#include "myrialux/clusters/bounds.h"

namespace myrialux {
namespace {

constexpr std::size_t kGroupsInWord = 64 / kCutLanes;

/// Largest path weight of each group of rows.
std::vector<float> largest_beta(const Receivers& receivers, std::span<const ReceiverId> rows);
/// Largest f cos of any row and direction, times its path weight.
float brightest_row(const CutPoints& points, std::span<const float> beta);
/// Where the rows are.
Box3 box_of(const Receivers& receivers, std::span<const ReceiverId> rows);
/// Upper bound of the cluster's weight at any row of the slice.
float slice_bound(const CutCluster& cluster, const Box3& rows, float brightest, float least_distance_squared);

}  // namespace

BitMatrix heavy_entries(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                        const VirtualLights& lights, const LightTree& tree, std::span<const Column> columns,
                        const BitMatrix& active, float clamp_distance, float limit) {
  MYRIALUX_ASSERT(limit > 0 && active.n_rows() == rows.size() && active.n_columns() == columns.size());
  BitMatrix heavy(rows.size(), columns.size());
  const CutPoints points = make_cut_points(world, receivers, rows, clamp_distance);
  const std::vector<float> beta = largest_beta(receivers, rows);
  const float brightest = brightest_row(points, beta);
  const Box3 box = box_of(receivers, rows);

  std::vector<float> bounds(points.groups.size());
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const LightId light = columns[j].light;
    const CutCluster cluster =
        make_light_cluster(world, lights, light, tree.importance[index(light)], columns[j].weight);
    if (slice_bound(cluster, box, brightest, points.least_distance_squared) <= limit) continue;
    bound_groups(points, cluster, bounds);
    for (std::size_t g = 0; g < bounds.size(); ++g) {
      if (bounds[g] * beta[g] <= limit) continue;
      const std::uint64_t group = std::uint64_t{0xffff} << g % kGroupsInWord * kCutLanes;
      heavy.column(j)[g / kGroupsInWord] |= active.column(j)[g / kGroupsInWord] & group;
    }
  }
  return heavy;
}

namespace {

std::vector<float> largest_beta(const Receivers& receivers, std::span<const ReceiverId> rows) {
  std::vector<float> beta((rows.size() + kCutLanes - 1) / kCutLanes);
  for (std::size_t k = 0; k < rows.size(); ++k)
    beta[k / kCutLanes] = std::max(beta[k / kCutLanes], luminance(receivers.beta[index(rows[k])]));
  return beta;
}

/// Largest shape() of the lane's lobe: see peak_gloss().
float peak_shape(const CutPoints::Group& p, std::size_t k) {
  const float t = p.t_least[k], x = t * p.inverse_alpha2[k];
  return (1 + t) * (1 + t) / (1 + x * (p.c1[k] + x * (p.c2[k] + x * p.c3[k])));
}

float brightest_row(const CutPoints& points, std::span<const float> beta) {
  float brightest = 0;
  for (std::size_t g = 0; g < points.groups.size(); ++g)
    for (std::size_t k = 0; k < kCutLanes; ++k) {
      const CutPoints::Group& p = points.groups[g];
      brightest = std::max(brightest, beta[g] * (p.diffuse[k] + p.gloss[k] * peak_shape(p, k) + p.any[k]));
    }
  return brightest;
}

Box3 box_of(const Receivers& receivers, std::span<const ReceiverId> rows) {
  Box3 box;
  for (const ReceiverId i : rows) box.add(receivers.p[index(i)]);
  return box;
}

float slice_bound(const CutCluster& cluster, const Box3& rows, float brightest, float least_distance_squared) {
  const float intensity = cluster.diffuse + cluster.gloss + cluster.any;
  if (cluster.distant) return brightest * intensity;
  float distance_squared = 0;
  for (int a = 0; a < 3; ++a) {
    const float gap = std::max({0.0f, rows.lower[a] - cluster.upper[a], cluster.lower[a] - rows.upper[a]});
    distance_squared += gap * gap;
  }
  return brightest * intensity / std::max(distance_squared, least_distance_squared);
}

}  // namespace
}  // namespace myrialux
