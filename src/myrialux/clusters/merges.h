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

/// Gives every node its place in the tree, in preorder, and every leaf its own, depth first; then fills the nodes from
/// the leaves up. Parallel; any depth will do.
/// @param lights of the leaves; @param root where the kind begins, as reserve_nodes() says
void lay_out(const Merges& merges, std::span<const std::uint32_t> lights, const RootPlace& root, const NodeMaker& maker,
             LightTree& tree);

}  // namespace myrialux
