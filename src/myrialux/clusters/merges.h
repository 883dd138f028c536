// A binary tree as the list of pairs that were merged, and its way into the nodes of a light tree.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/clusters/tree_nodes.h"

namespace myrialux {

/// Of n leaves: leaf k is node k, merge m is node n + m.
struct Merges {
  std::vector<std::array<std::uint32_t, 2>> parts;  ///< [n], of which n - 1 are used
  std::uint32_t root = 0;
};

/// Gives every node its place in the tree, children side by side and after their parent, leaves in depth-first order;
/// then fills the nodes from the leaves up. Parallel; any depth will do.
/// @param lights of the leaves; @param root where the root stands; @param first place of the first leaf in tree.order
void lay_out(const Merges& merges, std::span<const std::uint32_t> lights, std::uint32_t root, std::uint32_t first,
             const NodeMaker& maker, LightTree& tree);

}  // namespace myrialux
