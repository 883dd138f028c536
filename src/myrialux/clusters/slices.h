// Slices: groups of nearby, alike oriented receivers that share their columns. [wang20, 4.2]
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/receivers/receivers.h"

namespace myrialux {

struct SliceParams {
  std::uint32_t max_rows = 1024;
  std::uint32_t block_rows = 16;  ///< order inside a slice continues the splits down to such blocks
  float normal_weight = 0.05f;    ///< times the radius of the scene's bounding sphere
};

/// A permutation of the receivers cut into slices: slice s holds order[begin[s] .. begin[s + 1]).
struct Slices {
  Array<ReceiverId> order;
  std::vector<std::uint32_t> begin;  ///< [n_slices + 1]
  std::size_t size() const { return begin.empty() ? 0 : begin.size() - 1; }
  std::span<const ReceiverId> rows(std::size_t s) const {
    return std::span(order).subspan(begin[s], begin[s + 1] - begin[s]);
  }
};

/// 6-D kd-tree over (position, normal * weight), split in the dimension of largest variance; split points are rounded
/// to whole slices so that all but one slice are full. Ties broken by index: same result for any number of threads.
Slices make_slices(const Receivers& receivers, float scene_radius, const SliceParams& params);

}  // namespace myrialux
