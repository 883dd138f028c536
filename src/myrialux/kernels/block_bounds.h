// Upper bounds of what one light sends to blocks of receivers, 16 blocks at once: each block is a ball of positions and
// cones of normals and mirror directions. [walter05, 4.1, with spheres for boxes]
// Correctly rounded operations in a fixed order, as in cut_bounds.h: the same bits on every machine.
#pragma once

#include "myrialux/kernels/cut_bounds.h"

namespace myrialux {

/// Directions within an angle of an axis.
struct ConeLanes {
  float axis[3][kCutLanes];
  float cos[kCutLanes], sin[kCutLanes];  ///< of the angle; cos -1: any direction
};

/// Blocks of receivers, structure of arrays; unused lanes are all 0. f(wi, wo) cos wi beta of any receiver
///   <= diffuse cos_n + gloss / (1 + t (1 + t / 2)) (1 + tan^2)^2 [cos_n > 0] + any,   t = tan^2 / alpha^2,
/// with tan of half the angle to the mirror direction.
struct BlockCones {
  struct alignas(64) Group {
    float p[3][kCutLanes], radius[kCutLanes];
    ConeLanes normal, mirror;
    float diffuse[kCutLanes], gloss[kCutLanes], any[kCutLanes];
    float inverse_alpha2[kCutLanes];
  };
  std::vector<Group> groups;
  bool any_gloss = false;            ///< false: mirror is not looked at
  float least_distance_squared = 0;  ///< clamp distance squared; > 0
};

/// Bounds of one light over each block. @param light its box must be a point
/// @param bounds [groups.size() * 16]
void bound_blocks(const BlockCones& blocks, const CutCluster& light, std::span<float> bounds);
void bound_blocks_plain(const BlockCones& blocks, const CutCluster& light, std::span<float> bounds);

}  // namespace myrialux
