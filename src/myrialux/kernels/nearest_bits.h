// Which of many bit columns agrees best with a few samples: Hamming distances by population counts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace myrialux {

/// Columns side by side, `words` 64-bit words each; bits outside a column's known rows mean nothing.
struct BitColumns {
  std::span<const std::uint64_t> visible, known;  ///< [n_columns * words]
  std::size_t words = 0;
};

struct NearestColumn {
  std::size_t column = 0;
  std::size_t distance = 0;  ///< samples that the column contradicts or does not know
};

/// The column of least distance to `samples` in the rows of `omega`; of equally near ones the first in the order
/// first, first - 1, ..., 0, n - 1, ..., first + 1. Stops at distance 0.
/// Same answer on every instruction set. Cost: a few operations a word and column.
/// @param samples, omega [words]; n_columns >= 1
NearestColumn nearest_column(const BitColumns& columns, std::size_t first, std::span<const std::uint64_t> samples,
                             std::span<const std::uint64_t> omega);
NearestColumn nearest_column_plain(const BitColumns& columns, std::size_t first, std::span<const std::uint64_t> samples,
                                   std::span<const std::uint64_t> omega);

}  // namespace myrialux
