// Adaptive matrix completion, column after column: sample some rows, predict the rest from columns traced before,
// verify, else trace the column whole. What predicts is exchangeable. [wang20, 4.5, algorithms 1, 2 and 4]
#pragma once

#include <cstdint>

#include "myrialux/base/rng.h"
#include "myrialux/completion/completion_stats.h"
#include "myrialux/matrix/entry_source.h"

namespace myrialux {

/// Which rows of a column are looked at; the parameters that bamc, amc and gauss-jordan share.
struct RowRates {
  float alpha = 0.025f;    ///< share of the rows sampled in each column at first
  float beta = 0.025f;     ///< share of the rows verified in a predicted column; added to alpha when one fails
  float omega = 0.40f;     ///< largest alpha
  bool importance = true;  ///< sample rows where earlier columns changed (algorithm 3); false: uniformly
  bool adaptive = true;    ///< raise alpha after a failed verification; false: keep it
  bool resample = true;    ///< new rows for each column (algorithm 2); false: after a column traced whole (algorithm 1)
};

/// Predicts a column from a few of its rows and the columns of its group that were traced whole. Bits of a column
/// outside its known rows mean nothing (docs/decisions/0004-dont-care-entries.md).
class ColumnPredictor {
 public:
  virtual ~ColumnPredictor() = default;
  /// Forgets all columns: a new group begins.
  virtual void reset(std::size_t words_per_column) = 0;
  /// False when no samples whatever could be predicted from: then none are taken.
  virtual bool ready() const = 0;
  virtual void add(Words visible, Words known) = 0;
  /// True if a prediction agrees with `samples` in all rows of `omega`: sets `bits` and the rows `known` in them.
  virtual bool predict(Words samples, Words omega, Rng& rng, MutableWords bits, MutableWords known) = 0;
};

/// Fills `visible` (n_rows x n_columns, all 0 at entry): traced bits as traced, others predicted; inactive bits are 0.
/// No entry is asked for twice. Each group of columns starts afresh with predictor, alpha and row distribution.
/// Columns with at most 16 active rows are traced whole and not shown to the predictor.
/// @param name of the method, for messages
/// @throws Error (usage) for shares outside (0, 1]; beta may be 0: no verification
CompletionStats complete_columns(EntrySource& source, const RowRates& rates, const char* name,
                                 ColumnPredictor& predictor, Rng& rng, BitMatrix& visible);

}  // namespace myrialux
