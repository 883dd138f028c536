// Hierarchy over virtual lights, built bottom-up: the pair that is cheapest to stand for by one light joins first.
// [walter05, 5], made fast as approximate agglomerative clustering [gu13].
#pragma once

#include "myrialux/clusters/light_tree.h"

namespace myrialux {

struct AgglomerativeParams {
  /// Groups that compete for partners at a time. More come nearer to true greedy clustering, at a higher price.
  std::uint32_t n_competing = 32;
  RandomKey key;  ///< as LightTreeParams
};

/// The same kind of tree as build_light_tree(), one a kind of light. O(n (log n + n_competing)), parallel; the same
/// tree for any number of threads. Lights of importance 0 are left out. The order is by construction; depth is not
/// bounded but by the number of lights.
LightTree build_agglomerative_tree(const World& world, const VirtualLights& lights, float scene_radius,
                                   const AgglomerativeParams& params);

}  // namespace myrialux
