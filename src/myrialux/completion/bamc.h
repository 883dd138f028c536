// Boolean adaptive matrix completion. [wang20, 4.5, algorithms 2 to 4]
#pragma once

#include "myrialux/completion/adaptive_columns.h"

namespace myrialux {

using BamcParams = RowRates;

/// complete_columns() with boolean matching: a column is predicted to be a traced one that agrees with its samples, or
/// the complement of one. Deviations from the print:
///  - alpha counts rows, not columns; alpha = Min(alpha + beta, omega), printed as Max; alpha starts at most at omega.
///  - Matches are columns of Q that agree with the samples or whose complement does. The print's union reads so.
///  - Omega's indices are distinct: drawn one after the other from d without replacement.
///  - Only active rows are sampled, matched and verified (docs/decisions/0004-dont-care-entries.md); a source with all
///    rows active gives the published form. Columns with at most 16 active rows are traced whole, outside of Q.
/// Each group of columns starts afresh with Q, d and alpha: the sub-matrices "are recovered separately" [4.5.2], each
/// by a call of algorithm 2 whose alpha is an argument. "Per-slice" rates [4.5.3] are then those of sub-matrices, also
/// called sliced matrices there.
/// Cost without rays: 0.6 us (few samples) to 8 us (40 % sampled) for a column of 1024 rows.
/// @throws Error (usage) for shares outside (0, 1]; beta may be 0
CompletionStats complete_bamc(EntrySource& source, const BamcParams& params, Rng& rng, BitMatrix& visible);

/// Every active entry traced.
CompletionStats trace_all(EntrySource& source, BitMatrix& visible);

}  // namespace myrialux
