// Matrix separation: sparse samples, validated guesses of the other bits, then what is of low rank in both.
// [huo15]; compared with in [wang20, 5.3.2]
#pragma once

#include "myrialux/base/rng.h"
#include "myrialux/completion/completion_stats.h"
#include "myrialux/completion/robust_pca.h"
#include "myrialux/matrix/entry_source.h"

namespace myrialux {

struct SeparationParams {
  float samples = 0.05f;          ///< share of a column's active rows traced at first and in each round of validation
  float error = 0.10f;            ///< largest share of a round's fresh samples that the best guess may miss
  std::uint32_t rounds = 10;      ///< of validation at most
  float energy = 0.01f;           ///< columns below this many times the mean column's energy are not validated
  bool separate = true;           ///< false: the guesses are the result
  float lambda = 1;               ///< price of a wrong guess in the separation, see RobustPcaParams
  std::uint32_t iterations = 20;  ///< of the separation at most; signs settle long before the values
};

/// Fills `visible` (n_rows x n_columns, all 0 at entry). Three steps, for all columns of a group together:
///  1. A share of each column's active rows is traced, drawn uniformly, besides the required ones.
///  2. Rounds of prediction and validation: guesses of entry_predictors.h from all samples so far, the same share of
///     fresh samples, the guess that misses fewest is taken. A column that misses more than `error` goes through
///     another round. Columns of little energy take the guess along the rows and are not validated.
///  3. Separation [robust_pca.h] of the group's matrix, +1 visible and -1 occluded: traced entries are certain,
///     guessed ones doubted, inactive ones missing. Untraced bits are the signs of the low-rank part. Groups of fewer
///     than 8 columns keep their guesses: there every column has a rank of its own.
/// Traced bits stay; no entry is asked for twice; inactive bits are 0.
/// Deviations from the print are listed in docs/methods/matrix-separation.md.
/// @throws Error (usage) for shares outside their range
CompletionStats complete_separation(EntrySource& source, const SeparationParams& params, Rng& rng, BitMatrix& visible);

}  // namespace myrialux
