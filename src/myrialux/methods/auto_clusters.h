// How many columns a slice should have (--clusters auto): so many that passes averaged for as long as one likes come
// closest to the truth, which is where more clusters would no longer pay beside the error of the light set. Ours:
// docs/clusters_auto.md.
#pragma once

#include "myrialux/methods/render.h"

namespace myrialux {

inline constexpr std::uint32_t kLeastAutoClusters = 64, kMostAutoClusters = 8000;

/// Memory of the choice at most: the largest cuts of all sampled slices, and what is traced at a time.
inline constexpr std::uint64_t kAutoBytes = 12 << 20;

struct ClusterChoice {
  std::uint32_t n_clusters = 1000;  ///< where nothing can be told: as by default
  /// Root mean squares over sampled receivers (without the worst 1 %) of the error of one pass, over their mean
  /// radiance from virtual lights:
  double light_set_error = 0;   ///< because it has these lights and no others
  double cluster_error = 0;     ///< because n_clusters lights stand for all
  double visibility_error = 0;  ///< allowed to completion (MethodParams::visibility_error)
  std::uint64_t rays = 0;       ///< shadow rays that it took
};

/// Work of a pass in units of one cluster of one receiver; the constants are measured (docs/clusters_auto.md).
double pass_work(double n_clusters, double lights_per_receiver);

/// Joins 16 receivers of up to 48 slices with some thousand lights each, and grows the cuts of these slices until a
/// larger one can no longer win. Sizes are 64, 125, 250, ... 8000. Same choice for any number of threads.
ClusterChoice choose_clusters(const FrameView& frame, const MethodParams& params, const Slices& slices,
                              const LightTree& tree);

/// `params` with the number of clusters chosen, if it asks for that; notes why, adds to `stats`.
MethodParams with_chosen_clusters(const FrameView& frame, const MethodParams& params, const Slices& slices,
                                  const LightTree& tree, Progress& progress, RenderStats& stats);

}  // namespace myrialux
