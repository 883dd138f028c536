// Hierarchy over virtual lights, built top-down along the principal axis of position and scaled normal. [wang20, 4.3]
#pragma once

#include <cstdint>
#include <vector>

#include "myrialux/lights/virtual_lights.h"

namespace myrialux {

/// 64 bytes. Only inner nodes are stored: a leaf follows from its light.
struct LightNode {
  Box3 box;                 ///< of positions; directional: of the unit directions towards the lights
  Vec3 cone_axis;           ///< unit; the normals of the lights' cosines lie within the cone (glossy: ng)
  float cone_cos = 1;       ///< cosine of its half angle; -1: any direction (point, spot, directional)
  float importance = 0;     ///< sum of VirtualLights::importance
  std::uint32_t first = 0;  ///< leaves below: LightTree::order[first .. first + count)
  std::uint32_t count : 30 = 0;
  LightKind kind : 2 = LightKind::oriented;
  std::uint32_t left = 0, right = 0;  ///< numbers of the children; 0: leaf
  LightId representative{};           ///< drawn from the leaves in proportion to importance; shared with one child
  bool is_leaf() const { return left == 0; }
};

/// What bounds of glossy nodes need besides: radiant intensity along w is at most (luminance, W/sr)
///   diffuse cos(n, w) + gloss shape(angle of w to the mirror cone) + any,   shape falling from 1: see lobe_bounds.h
struct GlossyNode {
  Vec3 mirror_axis;      ///< unit; mirror directions of the arrived power lie within the cone
  float mirror_cos = 1;  ///< cosine of its half angle
  float diffuse = 0, gloss = 0, any = 0;
  float alpha = 0;  ///< largest roughness below
};

/// Of one glossy light.
GlossyNode glossy_bounds(const World& world, const VirtualLights& lights, LightId light);

/// One binary tree a kind of light; roots listed. Leaves hold exactly one light. Nodes are numbered: inner ones first,
/// in preorder, the kinds one after another; then the leaves in their order. Refers to the lights it was built from.
struct LightTree {
  const VirtualLights* lights = nullptr;
  std::vector<LightNode> inner;
  std::vector<GlossyNode> glossy;  ///< of inner nodes of that kind, then of its leaves; see glossy_node()
  std::uint32_t first_glossy_inner = 0, n_glossy_inner = 0, first_glossy_leaf = 0;
  std::vector<std::uint32_t> roots;  ///< in the order of LightKind
  std::vector<LightId> order;        ///< leaves depth first, the kinds one after another
  std::vector<float> importance;     ///< indexed by light, those left out included

  std::uint32_t size() const { return static_cast<std::uint32_t>(inner.size() + order.size()); }
  std::uint32_t n_lights() const { return static_cast<std::uint32_t>(order.size()); }
  bool is_leaf(std::uint32_t n) const { return n >= inner.size(); }
  /// The number of the leaf at order[place].
  std::uint32_t leaf(std::uint32_t place) const { return static_cast<std::uint32_t>(inner.size()) + place; }
  LightNode node(std::uint32_t n) const { return is_leaf(n) ? leaf_node(n) : inner[n]; }
  LightId representative(std::uint32_t n) const {
    return is_leaf(n) ? order[n - inner.size()] : inner[n].representative;
  }
  /// Place in the order of the node's first leaf.
  std::uint32_t first_leaf(std::uint32_t n) const {
    return is_leaf(n) ? n - static_cast<std::uint32_t>(inner.size()) : inner[n].first;
  }
  /// Of a node of glossy lights.
  const GlossyNode& glossy_node(std::uint32_t n) const { return glossy[glossy_place(n)]; }
  std::size_t glossy_place(std::uint32_t n) const {
    return is_leaf(n) ? n_glossy_inner + (n - inner.size()) - first_glossy_leaf : n - first_glossy_inner;
  }
  std::uint64_t memory_bytes() const {
    return inner.size() * sizeof(LightNode) + glossy.size() * sizeof(GlossyNode) + order.size() * sizeof(LightId) +
           importance.size() * sizeof(float);
  }

 private:
  LightNode leaf_node(std::uint32_t n) const;
};

struct LightTreeParams {
  float normal_weight = 0.05f;  ///< times the scene radius, as for slices
  RandomKey key;                ///< representatives are drawn anew in every pass
};

/// O(n log n), parallel; the same tree for any number of threads. Lights of importance 0 are left out.
LightTree build_light_tree(const World& world, const VirtualLights& lights, float scene_radius,
                           const LightTreeParams& params);

}  // namespace myrialux
