// Which blocks of rows lie next to which.
#pragma once

#include "myrialux/completion/block_masks.h"
#include "myrialux/matrix/entry_source.h"

namespace myrialux {

/// The nearest other blocks of each block, by the middles of their rows; in the order of the blocks where the source
/// knows of no points.
class BlockNeighbours {
 public:
  /// Cost: n_blocks^2 distances. @param count neighbours of a block; at most n_blocks - 1
  BlockNeighbours(const EntrySource& source, std::size_t n_blocks, std::size_t count);
  /// Neighbours of block b as a mask of blocks.
  Words of(std::size_t b) const { return Words(near_).subspan(b * words_, words_); }

 private:
  std::size_t words_;
  std::vector<std::uint64_t> near_;  ///< [n_blocks * words_]
};

}  // namespace myrialux
