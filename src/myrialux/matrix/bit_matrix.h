// Boolean matrices, column by column, 64 rows a word. Knows no geometry.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/base/assert.h"

namespace myrialux {

using Words = std::span<const std::uint64_t>;  ///< bits of a column, [ceil(n_rows / 64)], spare bits 0
using MutableWords = std::span<std::uint64_t>;

inline bool test_bit(Words w, std::size_t i) { return (w[i / 64] >> (i % 64)) & 1; }
inline void set_bit(MutableWords w, std::size_t i) { w[i / 64] |= std::uint64_t{1} << (i % 64); }
inline void clear_bit(MutableWords w, std::size_t i) { w[i / 64] &= ~(std::uint64_t{1} << (i % 64)); }
inline std::size_t count_bits(Words w) {
  std::size_t n = 0;
  for (const std::uint64_t word : w) n += static_cast<std::size_t>(std::popcount(word));
  return n;
}

/// n_rows x n_columns bits; each column starts at a word boundary.
class BitMatrix {
 public:
  BitMatrix() = default;
  BitMatrix(std::size_t n_rows, std::size_t n_columns)
      : n_rows_(n_rows),
        n_columns_(n_columns),
        words_per_column_((n_rows + 63) / 64),
        words_(words_per_column_ * n_columns) {}
  std::size_t n_rows() const { return n_rows_; }
  std::size_t n_columns() const { return n_columns_; }
  std::size_t words_per_column() const { return words_per_column_; }
  std::size_t n_words() const { return words_.size(); }
  Words column(std::size_t j) const { return Words(words_).subspan(j * words_per_column_, words_per_column_); }
  MutableWords column(std::size_t j) { return MutableWords(words_).subspan(j * words_per_column_, words_per_column_); }
  bool test(std::size_t i, std::size_t j) const {
    MYRIALUX_ASSERT(i < n_rows_ && j < n_columns_);
    return test_bit(column(j), i);
  }
  void set(std::size_t i, std::size_t j) { set_bit(column(j), i); }
  std::size_t count() const { return count_bits(words_); }
  /// Mask of the rows that exist in the last word.
  std::uint64_t tail_mask() const {
    return n_rows_ % 64 == 0 ? ~std::uint64_t{0} : (std::uint64_t{1} << n_rows_ % 64) - 1;
  }
  bool operator==(const BitMatrix&) const = default;

 private:
  std::size_t n_rows_ = 0, n_columns_ = 0, words_per_column_ = 0;
  std::vector<std::uint64_t> words_;
};

}  // namespace myrialux
