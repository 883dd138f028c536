// The nodes of a light tree, one at a time: leaves from lights, inner nodes from their children. [walter05, 3]
#pragma once

#include <array>

#include "myrialux/clusters/light_tree.h"

namespace myrialux {

/// What a node's representative is drawn by: its number if leaves stood among the inner nodes, children side by side
/// and all that is below them behind.
struct DrawKey {
  std::uint32_t number, descendants;  ///< those of the node begin at `descendants`
  DrawKey left() const { return {descendants, descendants + 2}; }
  DrawKey right(std::uint32_t n_left) const { return {descendants + 1, descendants + 2 * n_left}; }
};

/// Where the tree of one kind begins: its inner nodes, its draws, its leaves.
struct RootPlace {
  std::uint32_t inner = 0;
  DrawKey key{};
  std::uint32_t first = 0;
};

/// Fills nodes of a tree whose places and counts are known, see set_places().
class NodeMaker {
 public:
  NodeMaker(const World& world, const VirtualLights& lights, RandomKey key, LightTree& tree)
      : world_(world), lights_(lights), key_(key), tree_(tree) {}
  /// Enters the light into the tree's order.
  void make_leaf(std::uint32_t place, std::uint32_t light) const;
  /// Bounds, sums and the representative from the node's children, which must be complete.
  void join_children(std::uint32_t node, DrawKey key) const;

 private:
  const World& world_;
  const VirtualLights& lights_;
  RandomKey key_;
  LightTree& tree_;
};

/// Importance of every light.
std::vector<float> light_importance(const World& world, const VirtualLights& lights);

/// Makes room for trees of so many lights a kind: sets inner, glossy, order and roots. Returns where each kind begins.
std::array<RootPlace, kLightKinds> reserve_nodes(const std::array<std::size_t, kLightKinds>& n_lights, LightTree& tree);

/// Sets first, count, left and right of an inner node: the left subtree follows it, the right one behind.
void set_places(std::uint32_t node, std::uint32_t first, std::uint32_t count, std::uint32_t n_left, LightTree& tree);

/// The normal whose cosine the light's intensity has.
inline Vec3 cosine_normal(const VirtualLights& lights, std::size_t j) {
  return lights.kind[j] == LightKind::glossy ? lights.ng[j] : lights.n[j];
}

}  // namespace myrialux
