// The nodes of a light tree, one at a time: leaves from lights, inner nodes from their children. [walter05, 3]
#pragma once

#include <array>

#include "myrialux/clusters/light_tree.h"

namespace myrialux {

/// Fills nodes of a tree whose places and counts are known; first, count and left are the builder's business.
class NodeMaker {
 public:
  NodeMaker(const World& world, const VirtualLights& lights, RandomKey key, LightTree& tree)
      : world_(world), lights_(lights), key_(key), tree_(tree) {}
  /// Everything of a leaf; enters the light into the tree's order at node.first.
  void make_leaf(std::uint32_t node, std::uint32_t light) const;
  /// Bounds, sums and the representative from the node's children, which must be complete. The choice of the
  /// representative is keyed by the node's index.
  void join_children(std::uint32_t node) const;

 private:
  GlossyNode& glossy(std::uint32_t node) const { return tree_.glossy[node - tree_.first_glossy]; }

  const World& world_;
  const VirtualLights& lights_;
  RandomKey key_;
  LightTree& tree_;
};

/// Importance of every light.
std::vector<float> light_importance(const World& world, const VirtualLights& lights);

/// Makes room for trees of so many lights a kind: sets nodes, glossy, order and roots. Returns where each kind's root
/// stands; the other 2 n - 2 nodes of the kind follow it.
std::array<std::uint32_t, kLightKinds> reserve_nodes(const std::array<std::size_t, kLightKinds>& n_lights,
                                                     LightTree& tree);

/// The normal whose cosine the light's intensity has.
inline Vec3 cosine_normal(const VirtualLights& lights, std::size_t j) {
  return lights.kind[j] == LightKind::glossy ? lights.ng[j] : lights.n[j];
}

}  // namespace myrialux
