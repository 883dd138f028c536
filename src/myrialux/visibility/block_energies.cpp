// Bounds of the light cut's kernel, of columns instead of clusters.
#include "myrialux/visibility/block_energies.h"

#include <algorithm>

#include "myrialux/base/assert.h"
#include "myrialux/clusters/bounds.h"
#include "myrialux/kernels/shadow_ends.h"

namespace myrialux {
namespace {

std::vector<ReceiverId> middle_rows(std::span<const ReceiverId> rows) {
  std::vector<ReceiverId> middles;
  for (std::size_t first = 0; first < rows.size(); first += kPacketRows)
    middles.push_back(rows[first + std::min(kPacketRows, rows.size() - first) / 2]);
  return middles;
}

}  // namespace

BlockEnergies::BlockEnergies(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                             const VirtualLights& lights, const LightTree& tree, std::span<const Column> columns,
                             float clamp_distance, float unit)
    : world_(world), lights_(lights), tree_(tree), columns_(columns.begin(), columns.end()) {
  MYRIALUX_ASSERT(unit > 0);
  const std::vector<ReceiverId> middles = middle_rows(rows);
  points_ = make_cut_points(world, receivers, middles, clamp_distance);
  for (const ReceiverId i : middles) beta_.push_back(luminance(receivers.beta[index(i)]) / unit);
}

void BlockEnergies::of(std::size_t j, std::span<float> energies) const {
  MYRIALUX_ASSERT(energies.size() >= beta_.size());
  const LightId light = columns_[j].light;
  const CutCluster cluster =
      make_light_cluster(world_, lights_, light, tree_.importance[index(light)], columns_[j].weight);
  float bounds[kCutLanes];
  std::fill(energies.begin(), energies.end(), 0.0f);
  for (std::size_t g = 0; g < points_.groups.size(); ++g) {
    bound_lanes(points_, g, cluster, bounds);
    const std::size_t first = g * kCutLanes, n = std::min(kCutLanes, beta_.size() - first);
    for (std::size_t k = 0; k < n; ++k) energies[first + k] = bounds[k] * beta_[first + k];
  }
}

std::size_t BlockEnergies::memory_bytes() const {
  return columns_.size() * sizeof(Column) + points_.groups.size() * sizeof(CutPoints::Group) +
         beta_.size() * sizeof(float);
}

}  // namespace myrialux
