// Localized completion: rows in blocks of 16, each block of a column copied from the column that looks most alike or
// traced whole, so that rays travel in packets of neighbours. Ours, from the wrong blocks of [wang20, figure 8].
#pragma once

#include <cstdint>

#include "myrialux/base/rng.h"
#include "myrialux/completion/completion_stats.h"
#include "myrialux/matrix/block_doubts.h"
#include "myrialux/matrix/entry_source.h"

namespace myrialux {

/// Energies are those of the source's blocks: 1 is the mean of the picture. Why these values: docs/methods/lbamc.md.
struct LocalizedParams {
  std::uint32_t first_samples = 16;  ///< rows of a column looked at first, in as many blocks; >= 1
  std::uint32_t samples = 32;        ///< rows in all where the first do not settle the column
  float watch = 0.01f;               ///< blocks of more energy get a sample of their own in columns not settled
  float settle = 0.05f;              ///< the same in all columns
  float guard = 3;                   ///< blocks of more energy are traced
  float risk = 2e-4f;                ///< blocks are traced, not copied, where energy^2 times doubt is larger
  std::uint32_t few = 64;            ///< columns of no more active rows are traced whole
  std::uint32_t memory = 64;         ///< completed columns that a column is compared with; >= 1
  std::uint32_t flood = 4;           ///< nearest blocks that are traced, too, where a traced block is not as predicted
  float copy_mixed = 1e-3f;          ///< mixed blocks of less energy are copied, not traced
  float whole = 0.003f;              ///< doubtful blocks of less energy are traced in one row of four
};

/// The same with all energies times `slack`: larger ones leave more to copies. @param slack > 0
LocalizedParams with_slack(const LocalizedParams& params, float slack);

/// Fills `visible` (n_rows x n_columns, all 0 at entry): traced bits as traced, others copied; inactive bits are 0. No
/// entry is asked for twice. Column after column:
///  1. A column of few active rows is traced whole, and so is the first.
///  2. Blocks of great energy are traced, and a few rows spread evenly over the others, other ones from column to
///     column. If all agree and the nearest remembered column is uniform and of their value, no more rows are sampled.
///  3. Otherwise more rows are traced, by energy. The nearest column (least Hamming distance) is the prediction.
///  4. Blocks that are mixed in it, that it does not know, that a sample contradicts or that are worth too much to be
///     copied are traced: wholly if they may bring much, else one row in four, which speak for their neighbours. Where
///     one is not in the state that was predicted (visible, occluded, mixed), its nearest blocks are traced in turn.
///  5. The others are copied; uniform ones are so in all their rows.
/// How often samples contradict the blocks predicted uniform tells how wrong copies would be; its running mean over the
/// last columns is the doubt, of which `risk` makes a limit of energy: where copies fail, as in hair and foliage, most
/// blocks that matter are traced. Groups of columns are not told apart: the nearest column is found wherever it is.
/// @throws Error (usage) for counts of 0 where >= 1 is asked for, negative energies
/// @param doubts set where not null; all 0 at entry
CompletionStats complete_localized(EntrySource& source, const LocalizedParams& params, Rng& rng, BitMatrix& visible,
                                   BlockDoubts* doubts = nullptr);

}  // namespace myrialux
