// Completed columns of a slice that later ones are compared with.
#pragma once

#include <vector>

#include "myrialux/completion/block_masks.h"
#include "myrialux/kernels/nearest_bits.h"

namespace myrialux {

/// The last columns; the oldest is replaced first.
class RememberedColumns {
 public:
  enum class Kind : std::uint8_t { occluded, visible, mixed };  ///< of a column's known rows

  RememberedColumns(std::size_t capacity, std::size_t words)
      : capacity_(capacity), words_(words), block_words_((words * kBlocksInWord + 63) / 64) {}
  bool empty() const { return kinds_.empty(); }
  /// @param blocks mask of the blocks that have known rows
  void add(Words visible, Words known, Words blocks, Kind kind);
  /// The newest of those with the least Hamming distance on the rows of omega; rows not known count as different.
  NearestColumn nearest(Words samples, Words omega) const {
    return nearest_column({visible_, known_, words_}, newest_, samples, omega);
  }
  Words visible(std::size_t q) const { return Words(visible_).subspan(q * words_, words_); }
  Words known(std::size_t q) const { return Words(known_).subspan(q * words_, words_); }
  Words blocks(std::size_t q) const { return Words(blocks_).subspan(q * block_words_, block_words_); }
  Kind kind(std::size_t q) const { return kinds_[q]; }

 private:
  std::size_t capacity_, words_, block_words_, newest_ = 0;
  std::vector<std::uint64_t> visible_, known_;  ///< [columns * words]
  std::vector<std::uint64_t> blocks_;           ///< [columns * block_words_]
  std::vector<Kind> kinds_;
};

}  // namespace myrialux
