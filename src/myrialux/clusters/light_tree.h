// Hierarchy over virtual lights, built top-down along the principal axis of position and scaled normal. [wang20, 4.3]
#pragma once

#include <cstdint>
#include <vector>

#include "myrialux/lights/virtual_lights.h"

namespace myrialux {

struct LightNode {
  Box3 box;                            ///< of positions (directional: of directions)
  Vec3 cone_axis;                      ///< unit; all normals lie within the cone
  float cone_cos = 1;                  ///< cosine of its half angle; -1: any direction
  Rgb power;                           ///< sum of what weights are made of (see representative)
  float importance = 0;                ///< sum of VirtualLights::importance
  std::uint32_t first = 0, count = 0;  ///< leaves below: LightTree::order[first .. first + count)
  std::uint32_t left = 0;              ///< index of the left child; the right one follows it. 0: leaf
  LightId representative{};            ///< drawn from the leaves in proportion to importance; shared with one child
  LightKind kind = LightKind::oriented;
  bool is_leaf() const { return left == 0; }
};

/// One binary tree a kind of light; roots listed. Leaves hold exactly one light.
struct LightTree {
  std::vector<LightNode> nodes;
  std::vector<std::uint32_t> roots;
  std::vector<LightId> order;
  std::vector<float> importance;  ///< [n_lights]
  std::uint32_t n_lights() const { return static_cast<std::uint32_t>(order.size()); }
};

struct LightTreeParams {
  float normal_weight = 0.05f;  ///< times the scene radius, as for slices
  RandomKey key;                ///< representatives are drawn anew in every pass
};

/// O(n log n), parallel; the same tree for any number of threads. Lights of importance 0 are left out.
LightTree build_light_tree(const World& world, const VirtualLights& lights, float scene_radius,
                           const LightTreeParams& params);

}  // namespace myrialux
