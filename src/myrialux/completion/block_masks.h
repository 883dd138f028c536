// Masks of blocks of 16 rows, four a word of rows: one bit a block, 64 blocks a word.
#pragma once

#include <cstdint>
#include <vector>

#include "myrialux/matrix/bit_ops.h"

namespace myrialux {

inline constexpr std::size_t kRowsInBlock = 16;
inline constexpr std::size_t kBlocksInWord = 64 / kRowsInBlock;

/// Bit k: any of bits [16 k, 16 k + 16) is set; k < 4.
inline std::uint64_t any_in_blocks(std::uint64_t rows) {
  constexpr std::uint64_t low = 0x7fff7fff7fff7fff;
  // The highest bit of each block gathers all of its bits: adding carries into it if one below is set.
  const std::uint64_t any = (((rows & low) + low) | rows) >> 15 & 0x0001000100010001;
  return (any * 0x1000200040008000) >> 60;
}

/// All 16 rows of each of the four blocks.
inline std::uint64_t rows_of_blocks(std::uint64_t four) {
  const std::uint64_t spread = (four & 1) | (four & 2) << 15 | (four & 4) << 30 | (four & 8) << 45;
  return spread * 0xffff;
}

/// One bit a block of a column.
class BlockMask {
 public:
  explicit BlockMask(std::size_t n_blocks) : words_((n_blocks + 63) / 64) {}
  void clear() { words_.assign(words_.size(), 0); }
  bool empty() const {
    std::uint64_t any = 0;
    for (const std::uint64_t word : words_) any |= word;
    return any == 0;
  }
  bool test(std::size_t b) const { return words_[b / 64] >> b % 64 & 1; }
  void set(std::size_t b) { words_[b / 64] |= std::uint64_t{1} << b % 64; }
  /// The four blocks of word w of the rows.
  std::uint64_t four(std::size_t w) const { return words_[w / 16] >> w % 16 * 4 & 15; }
  void add_four(std::size_t w, std::uint64_t four) { words_[w / 16] |= four << w % 16 * 4; }
  std::size_t n_words() const { return words_.size(); }
  std::uint64_t& operator[](std::size_t word) { return words_[word]; }
  std::uint64_t operator[](std::size_t word) const { return words_[word]; }
  Words words() const { return words_; }
  MutableWords words() { return words_; }

 private:
  std::vector<std::uint64_t> words_;
};

}  // namespace myrialux
