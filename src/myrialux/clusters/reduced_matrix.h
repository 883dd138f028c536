// The reduced light matrix: one row of it a slice, at a receiver drawn from the slice, all lights as columns.
// [ou11; hasan07]
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/base/assert.h"

namespace myrialux {

/// R, luminance >= 0 with visibility, row by row. Two bytes an entry: the upper half of a float, rounded to nearest
/// (8 bits of mantissa, 0.4 % at most); where columns are compared and drawn more would be wasted.
class ReducedMatrix {
 public:
  ReducedMatrix() = default;
  ReducedMatrix(std::size_t n_rows, std::size_t n_columns)
      : n_rows_(n_rows), n_columns_(n_columns), entries_(n_rows * n_columns) {}
  std::size_t n_rows() const { return n_rows_; }
  std::size_t n_columns() const { return n_columns_; }
  std::uint64_t memory_bytes() const { return entries_.size() * sizeof(std::uint16_t); }

  /// Sets entries first_column, first_column + 1, ... of a row.
  void set(std::size_t row, std::size_t first_column, std::span<const float> values) {
    MYRIALUX_ASSERT(row < n_rows_ && first_column + values.size() <= n_columns_);
    std::uint16_t* to = entries_.data() + row * n_columns_ + first_column;
    for (std::size_t k = 0; k < values.size(); ++k)
      to[k] = static_cast<std::uint16_t>((std::bit_cast<std::uint32_t>(values[k]) + 0x8000u) >> 16);
  }
  /// Reads values.size() entries of a row from first_column on.
  void get(std::size_t row, std::size_t first_column, std::span<float> values) const {
    MYRIALUX_ASSERT(row < n_rows_ && first_column + values.size() <= n_columns_);
    const std::uint16_t* from = entries_.data() + row * n_columns_ + first_column;
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = std::bit_cast<float>(static_cast<std::uint32_t>(from[k]) << 16);
  }

 private:
  std::size_t n_rows_ = 0, n_columns_ = 0;
  std::vector<std::uint16_t> entries_;
};

}  // namespace myrialux
