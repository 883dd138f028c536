// Adaptive matrix completion by projection onto the span of the columns traced before. [wang20, 3.2, algorithm 1; ks14]
#pragma once

#include "myrialux/completion/adaptive_columns.h"

namespace myrialux {

struct AmcParams {
  RowRates rows = {};
  float tolerance = 1e-6f;  ///< largest E, the sum of squared residuals of the samples (bits as 0 and 1)
};

/// complete_columns() with projections: samples x are projected onto the basis, c = Q_Omega^+ x; where
/// E = |Q_Omega c - x|^2 [eq. 3] is within the tolerance, the column is predicted as Q c, above 0.5 visible [eq. 2].
/// The span of no columns predicts a column of zeros. Algorithm 1 to the letter: {importance = false, adaptive = false,
/// resample = false, beta = 0}; the defaults are algorithm 2's, so that against bamc only the prediction differs, as in
/// [5.6]. Deviations from the print:
///  - equal rows and equal columns of Q_Omega are merged, with the roots of their numbers as weights, before the
///    pseudo-inverse is applied by a complete orthogonal decomposition: the same c as by SVD (a test compares them);
///  - a prediction that disagrees with a sample after rounding is none, so that traced bits stay;
///  - only columns that know every sampled row take part, and the prediction knows the rows that all columns of
///    coefficients other than 0 know (docs/decisions/0004-dont-care-entries.md).
/// Cost without rays: O(m n min(m, n)) a column for m distinct rows and n distinct columns of Q_Omega.
/// @throws Error (usage) for shares outside (0, 1] (beta may be 0) and a negative tolerance
CompletionStats complete_amc(EntrySource& source, const AmcParams& params, Rng& rng, BitMatrix& visible);

}  // namespace myrialux
