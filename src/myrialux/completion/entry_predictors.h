// Three guesses of a column's unsampled bits from sparse samples: along the rows, by a plane through them, and from the
// columns beside it. [huo15, prediction of visibility]
#pragma once

#include <array>
#include <span>
#include <vector>

#include "myrialux/matrix/entry_source.h"

namespace myrialux {

/// Bits traced so far, and where.
struct SampledBits {
  const BitMatrix& visible;
  const BitMatrix& traced;
};

/// Columns [begin, end) that a guess may look at.
struct ColumnRange {
  std::size_t begin = 0, end = 0;
};

/// Each fills `bits` [words_per_column] for all rows; bits of rows traced are theirs to guess, too. Ties are visible.
/// False (bits untouched): the column has no sample, or the guess needs what is not there.

/// The majority of the three sampled rows nearest in the order of rows.
bool predict_by_neighbours(const SampledBits& sampled, std::size_t j, MutableWords bits);

/// The sign of a linear function of the row's point, fitted to the samples (+1 visible, -1 occluded) by least squares.
bool predict_by_plane(const SampledBits& sampled, std::size_t j, std::span<const RowPoint> points, MutableWords bits);

/// Naive Bayes: odds of the column times odds of the row (its block of 16 rows, in the three columns on either side and
/// this one) over the odds of all of these columns; one sample of each kind is added to every count.
bool predict_by_columns(const SampledBits& sampled, std::size_t j, ColumnRange range, MutableWords bits);

}  // namespace myrialux
