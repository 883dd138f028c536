// Hierarchy over the receivers of one pixel: the other half of a multidimensional lightcut. [walter06]
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/kernels/pair_bounds.h"
#include "myrialux/receivers/receivers.h"

namespace myrialux {

/// A cluster of receivers. A receiver's strength is the largest component of its path weight beta.
struct GatherNode {
  PairReceivers bounds;                ///< of the receivers' transfer without beta
  float strength = 0;                  ///< sum over the receivers
  float diagonal = 0;                  ///< of the box
  std::uint32_t first = 0, count = 0;  ///< GatherTree::order[first .. first + count)
  std::uint32_t left = 0;              ///< index of the left child; the right one follows it. 0: leaf
  ReceiverId representative{};         ///< drawn in proportion to strength; shared with one child
  bool same_beta = true;               ///< all receivers weigh the same
  bool is_leaf() const { return left == 0; }
};

/// Root is node 0; leaves hold exactly one receiver. Built anew for each pixel, keeping its memory.
struct GatherTree {
  std::vector<GatherNode> nodes;  ///< children stand behind their parents
  std::vector<ReceiverId> order;  ///< leaves depth first
};

/// Halves receivers by count along the widest side of their box in (position, normal * normal_scale). Receivers of
/// strength 0 are left out; no nodes if none is left. O(n log n) of n receivers.
/// @param rng draws representatives: always the same number of draws for the same receivers
void build_gather_tree(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                       float normal_scale, Rng& rng, GatherTree& tree);

}  // namespace myrialux
