// Least squares against columns of bits: c = A^+ x, the shortest of the vectors that bring A c nearest to x.
#pragma once

#include <vector>

#include "myrialux/matrix/bit_ops.h"

namespace myrialux {

/// Projections with bit columns packed [words_for(n_rows)] each. Keeps its memory from call to call.
class BitProjection {
 public:
  /// @param columns A, [n_columns * words_for(n_rows)], spare bits 0
  /// @param x [words_for(n_rows)]
  /// Valid until the next call. Equal rows and columns of A are merged first: a row that stands m times weighs
  /// sqrt(m) with the mean of its x, a column that stands n times weighs sqrt(n), which its coefficient is spread over.
  const std::vector<double>& solve(std::size_t n_rows, std::size_t n_columns, Words columns, Words x);

 private:
  std::vector<double> c_;                        ///< [n_columns]
  std::vector<std::size_t> column_of_, row_of_;  ///< the merged column or row that one belongs to
  std::vector<std::uint64_t> transposed_;        ///< rows of the merged columns
};

}  // namespace myrialux
