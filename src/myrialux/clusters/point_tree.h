// Hierarchy over all receivers of a frame: a compressed octree whose first levels divide the normals. [bus15, 3]
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/clusters/cone.h"
#include "myrialux/kernels/pair_bounds.h"
#include "myrialux/receivers/receivers.h"

namespace myrialux {

/// How the gloss of a node's receivers falls off about the mirror direction: coefficients of shape(), lobe_bounds.h.
enum class GlossShape : std::uint8_t {
  ggx,          ///< 2, 1, 0
  beckmann,     ///< 1, 1/2, 1/6
  blinn_phong,  ///< with a = alpha^2: 1 + a, (1 + a) / 2, (1 - a^2) / 6
  common,       ///< 1, 1/2, 0: above all
};

/// 96 bytes.
struct PointNode {
  Box3 box;                               ///< of positions
  Cone normals{};                         ///< all shading normals lie within
  Cone mirrors{};                         ///< mirror directions of wo at receivers with gloss; cosine -1: any direction
  float diffuse = 0, gloss = 0, any = 0;  ///< largest of LobeBounds' below, largest channel
  float alpha = 0;                        ///< largest roughness of a gloss below
  std::uint32_t first = 0, count = 0;     ///< PointTree::order[first .. first + count)
  std::uint32_t children = 0;             ///< index of the first child, the others follow. 0: leaf
  ReceiverId representative{};            ///< drawn evenly from the receivers
  float colour = 0;                       ///< least approximate radiance of the receivers, luminance; set by phase I
  std::uint8_t n_children = 0;            ///< 2 to 8, or 0
  GlossShape shape = GlossShape::common;
  bool is_leaf() const { return children == 0; }
};

/// Root is node 0; leaves hold exactly one receiver; children stand behind their parents.
struct PointTree {
  std::vector<PointNode> nodes;
  std::vector<ReceiverId> order;  ///< z-order: the receivers of every node are consecutive
  std::span<const ReceiverId> rows(const PointNode& node) const {
    return std::span(order).subspan(node.first, node.count);
  }
  std::uint64_t memory_bytes() const { return nodes.size() * sizeof(PointNode) + order.size() * sizeof(ReceiverId); }
};

struct PointTreeParams {
  std::uint32_t normal_levels = 3;  ///< of octants of normals before those of positions
  RandomKey key;
};
inline constexpr std::uint32_t kMaxNormalLevels = 5;

/// O(n log n), parallel; the same tree for any number of threads. No nodes if there are no receivers. Receivers whose
/// codes agree (18 bits a coordinate at three levels of normals) are split by count.
PointTree build_point_tree(const World& world, const Receivers& receivers, const PointTreeParams& params);

/// The node in the form that bound_pair() reads.
PairReceivers make_pair_receivers(const PointNode& node);

}  // namespace myrialux
