// How sure completed bits are, by blocks of rows.
#pragma once

#include <vector>

#include "myrialux/base/short_float.h"

namespace myrialux {

/// The share of the active bits of a block of 16 rows, not counting traced ones, that is expected to be wrong.
/// Estimated from how often samples contradict; see docs/methods/lbamc.md. Kept to 8 bits of mantissa, rounded up.
class BlockDoubts {
 public:
  BlockDoubts(std::size_t n_rows, std::size_t n_columns)
      : n_blocks_((n_rows + 15) / 16), doubts_(n_blocks_ * n_columns) {}
  std::size_t n_blocks() const { return n_blocks_; }
  void set(std::size_t block, std::size_t j, float doubt) { doubts_[j * n_blocks_ + block] = short_above(doubt); }
  /// 0: all active rows are traced.
  float operator()(std::size_t block, std::size_t j) const { return from_short(doubts_[j * n_blocks_ + block]); }
  std::size_t memory_bytes() const { return doubts_.size() * sizeof(std::uint16_t); }

 private:
  std::size_t n_blocks_;
  std::vector<std::uint16_t> doubts_;
};

}  // namespace myrialux
