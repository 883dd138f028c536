// Adaptive matrix completion over GF(2): a column is predicted to be a sum (exclusive or) of columns traced before,
// found by Gauss-Jordan elimination. [wang20, 5.6]
#pragma once

#include "myrialux/completion/adaptive_columns.h"

namespace myrialux {

/// complete_columns() with sums over GF(2). For every column the basis, restricted to the sampled rows, is brought to
/// reduced row echelon form; the samples at the leading ones are the coefficients, the other samples must come out
/// right. Where several sums fit, the one of the earlier columns is taken. The sum of no columns predicts a column of
/// zeros. Deviations from the print (its supplement is not public):
///  - the elimination runs on the sampled rows and remembers which columns it added, so that whole columns are added
///    only at the end: the same sum, found in words_for(samples) + words_for(basis) words a row operation instead of
///    words_for(rows);
///  - only columns that know every sampled row take part, and the sum knows the rows that all its columns know
///    (docs/decisions/0004-dont-care-entries.md).
/// Cost without rays: with n basis columns of rank r, n (samples + r (samples + n) / 64) operations a column.
/// @throws Error (usage) for shares outside (0, 1]; beta may be 0
CompletionStats complete_gauss_jordan(EntrySource& source, const RowRates& params, Rng& rng, BitMatrix& visible);

}  // namespace myrialux
