// What the entries of a block of 16 rows may bring at most: where a completion should look.
#pragma once

#include <vector>

#include "myrialux/base/short_float.h"
#include "myrialux/clusters/cut.h"
#include "myrialux/kernels/block_bounds.h"

namespace myrialux {

/// Of one slice: an upper bound of W T beta (luminance, no occlusion) over the rows of each block, for each column.
class BlockEnergies {
 public:
  /// @param clamp_distance as CutParams
  /// @param unit radiance that counts as energy 1; > 0
  /// Cost: 4 evaluations of 16 bounds a column for 1024 rows.
  BlockEnergies(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                const VirtualLights& lights, const LightTree& tree, std::span<const Column> columns,
                float clamp_distance, float unit);

  /// Of column j. @param energies [blocks, in whole words of rows]; 0 for blocks beyond the rows
  void of(std::size_t j, std::span<float> energies) const;
  /// Of one block.
  float of(std::size_t j, std::size_t b) const { return from_short(bounds_[j * n_blocks_ + b]); }
  std::size_t n_columns() const { return n_columns_; }
  /// Those with rows.
  std::size_t n_blocks() const { return n_blocks_; }
  std::size_t memory_bytes() const { return bounds_.size() * sizeof(std::uint16_t); }

 private:
  std::size_t n_columns_, n_blocks_;
  std::vector<std::uint16_t> bounds_;  ///< [columns x blocks], rounded up to 8 bits of mantissa
};

}  // namespace myrialux
