// The light cut of a slice: nodes refined by the largest upper bound of their error over the slice's points.
// Bounds after Lightcuts [walter05, 4]; shared by a slice as in [wang20, 4.3].
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "myrialux/clusters/light_tree.h"
#include "myrialux/clusters/slices.h"

namespace myrialux {

struct CutParams {
  std::uint32_t n_clusters = 1000;  ///< exact size of the cut (smaller only if the tree ends; at least one a kind)
  std::uint32_t n_points = 16;      ///< receivers of the slice at which bounds are taken; 0 = all
  float clamp_distance = 0;         ///< geometry bound 1 / max(d^2, clamp^2); 0 = no clamp
};

/// One column of a slice: a representative light and what its cluster weighs.
struct Column {
  LightId light{};
  float weight = 1;         ///< W: cluster importance / importance of the representative
  std::uint32_t node = 0;   ///< of the tree
  std::uint32_t count = 1;  ///< lights in the cluster
  std::uint8_t octant = 0;  ///< see octant(), with slice_centre()
};

/// A slice's cut while it grows, for those who look at several sizes: a cut of n is one of n - 1 refined once. Keeps
/// references to the tree.
class GrowingCut {
 public:
  GrowingCut(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows, const LightTree& tree,
             const CutParams& params);
  ~GrowingCut();
  GrowingCut(GrowingCut&&) noexcept;
  GrowingCut& operator=(GrowingCut&&) noexcept;

  /// Refines up to n_clusters, or until nothing is left to refine. Never shrinks.
  void grow(std::uint32_t n_clusters);
  std::size_t size() const;
  /// The cut's nodes: disjoint, all lights below them, in no particular order.
  std::vector<std::uint32_t> nodes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Columns are ordered by (kind, octant of the direction to the slice's centre, depth-first position in the tree).
/// Deterministic: ties by node index.
std::vector<Column> light_cut(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                              const VirtualLights& lights, const LightTree& tree, const CutParams& params);

/// Upper bound of the node's contribution to receiver i (luminance, beta not included), for tests and refinement: of
/// the sum of its lights' transfer as well as of weight times the transfer of any of its lights (glossy lights: as far
/// as their importance is at least their peak intensity). Up to rounding, a few parts in a million.
float cluster_bound(const World& world, const Receivers& receivers, ReceiverId i, const LightTree& tree,
                    std::uint32_t node, float clamp_distance);

/// Mean position of a slice's rows, the centre that octants are seen from. [wang20, 4.5.2]
inline Vec3 slice_centre(const Receivers& receivers, std::span<const ReceiverId> rows) {
  double x = 0, y = 0, z = 0;
  for (const ReceiverId i : rows)
    x += receivers.p[index(i)].x, y += receivers.p[index(i)].y, z += receivers.p[index(i)].z;
  const double share = 1 / static_cast<double>(std::max<std::size_t>(rows.size(), 1));
  return {static_cast<float>(x * share), static_cast<float>(y * share), static_cast<float>(z * share)};
}

/// Octant (0..7) of the direction from the slice's centre to the light (directional: to where it comes from).
std::uint32_t octant(Vec3 slice_centre, const VirtualLights& lights, LightId j);

}  // namespace myrialux
