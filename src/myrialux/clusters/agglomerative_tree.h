// Hierarchy over virtual lights, built bottom-up: the two groups that are cheapest to stand for by one light are joined
// first. [walter05], made fast as approximate agglomerative clustering [gu13].
#pragma once

#include "myrialux/clusters/light_tree.h"

namespace myrialux {

struct AgglomerativeParams {
  /// Groups that compete for partners at the lowest level; as many lights as there are make it the greedy clustering of
  /// [walter05], in n^2 time and memory. Measured: no better cuts above 16 (docs/methods/lightcuts.md).
  std::uint32_t n_competing = 32;
  RandomKey key;  ///< as LightTreeParams::key
};

/// The same form as build_light_tree() gives, one tree a kind of light; not balanced. The measure is that of
/// light_metric.h; glossy lights count by position and geometric normal, not by their lobes.
/// O(n log n), parallel; the same tree for any number of threads. Lights of importance 0 are left out.
LightTree build_agglomerative_tree(const World& world, const VirtualLights& lights, float scene_radius,
                                   const AgglomerativeParams& params);

}  // namespace myrialux
