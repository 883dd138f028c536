// Boolean adaptive matrix completion. [wang20, 4.5, algorithms 2 to 4]
#pragma once

#include <cstdint>

#include "myrialux/base/rng.h"
#include "myrialux/matrix/entry_source.h"

namespace myrialux {

struct BamcParams {
  float alpha = 0.025f;    ///< share of the rows sampled in each column at first
  float beta = 0.025f;     ///< share of the rows verified in a matched column; added to alpha when one fails
  float omega = 0.40f;     ///< largest alpha
  bool importance = true;  ///< sample rows where earlier columns changed (algorithm 3); false: uniformly
  bool adaptive = true;    ///< raise alpha after a failed verification; false: keep it
};

struct CompletionStats {
  std::uint64_t entries = 0;           ///< active entries
  std::uint64_t traced = 0;            ///< entries asked of the source
  std::uint64_t full_columns = 0;      ///< columns traced whole
  std::uint64_t verified_columns = 0;  ///< columns copied and found right by verification
  CompletionStats& operator+=(const CompletionStats& o) {
    entries += o.entries, traced += o.traced, full_columns += o.full_columns, verified_columns += o.verified_columns;
    return *this;
  }
};

/// Fills `visible` (n_rows x n_columns, all 0 at entry): traced bits as traced, others completed; inactive bits are 0.
/// No entry is asked for twice. Deviations from the print:
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
