// Hierarchy over virtual lights, built top-down along the principal axis of position and scaled normal. [wang20, 4.3]
#pragma once

#include <cstdint>
#include <vector>

#include "myrialux/lights/virtual_lights.h"

namespace myrialux {

/// 64 bytes.
struct LightNode {
  Box3 box;                            ///< of positions; directional: of the unit directions towards the lights
  Vec3 cone_axis;                      ///< unit; the normals of the lights' cosines lie within the cone (glossy: ng)
  float cone_cos = 1;                  ///< cosine of its half angle; -1: any direction (point, spot, directional)
  float importance = 0;                ///< sum of VirtualLights::importance
  std::uint32_t first = 0, count = 0;  ///< leaves below: LightTree::order[first .. first + count)
  std::uint32_t left = 0;              ///< index of the left child; the right one follows it. 0: leaf
  LightId representative{};            ///< drawn from the leaves in proportion to importance; shared with one child
  LightKind kind = LightKind::oriented;
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

/// One binary tree a kind of light; roots listed. Leaves hold exactly one light.
struct LightTree {
  std::vector<LightNode> nodes;
  std::vector<GlossyNode> glossy;  ///< of the nodes first_glossy, first_glossy + 1, ...
  std::uint32_t first_glossy = 0;
  std::vector<std::uint32_t> roots;  ///< in the order of LightKind
  std::vector<LightId> order;        ///< leaves depth first, the kinds one after another
  std::vector<float> importance;     ///< indexed by light, those left out included
  std::uint64_t memory_bytes() const {
    return nodes.size() * sizeof(LightNode) + glossy.size() * sizeof(GlossyNode) + order.size() * sizeof(LightId) +
           importance.size() * sizeof(float);
  }
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
