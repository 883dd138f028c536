// Traces and shades pairs of clusters for blocks of at most 64 receivers: what the illumination cuts share. [bus15, 3]
#pragma once

#include "myrialux/clusters/point_tree.h"
#include "myrialux/methods/render.h"

namespace myrialux {

/// A light cluster as some of a block's receivers use it; bit r: receiver r of the block.
struct BlockPair {
  std::uint32_t light = 0;    ///< node of the light tree
  std::uint64_t covered = 0;  ///< receivers that the pair holds
  std::uint64_t trace = 0;    ///< of them, those whose shadow ray is traced
  std::uint64_t visible = 0;  ///< of the others, those that see the light
};

/// What pairs leave behind for the statistics.
struct PairReport {
  std::uint64_t bounds = 0, pairs = 0;  ///< bounds taken; pairs accepted
  std::uint64_t covered = 0;            ///< receivers in accepted pairs, summed over pairs
  std::uint64_t entries = 0, traced = 0, rays = 0, blocks = 0;
  double radiance = 0, clamped_away = 0;            ///< luminance
  double cut_s = 0, visibility_s = 0, shade_s = 0;  ///< CPU seconds
  std::uint64_t memory_bytes = 0;                   ///< largest
  PairReport& operator+=(const PairReport& r);
};

/// Sums the light of `pairs` to the block's receivers: rays in packets of 16 receivers towards one light, shading by
/// the kernels of slices. Sets their radiance, cut size and visibility fraction; pairs with the same light cluster are
/// joined, and all are taken in the order of the tree, whatever order they come in.
void render_block(const FrameView& frame, const LightTree& lights, const PointNode& block,
                  std::span<const ReceiverId> rows, float clamp_distance, std::vector<BlockPair>& pairs,
                  MethodResult& result, PairReport& report);

}  // namespace myrialux
