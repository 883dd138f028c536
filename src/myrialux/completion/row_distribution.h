// Where in a column to look: rows weighted by how often visibility changed near them. [wang20, 4.5.2, algorithm 3]
#pragma once

#include <cstdint>
#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/completion/indexed_sums.h"
#include "myrialux/matrix/bit_ops.h"

namespace myrialux {

/// The distribution d over the rows of one column group, and draws from it. Keeps its memory from group to group.
/// Weights are integers in units of 2^-40, so that sums are exact; a draw picks a row within 2^-32 of its probability.
class RowDistribution {
 public:
  /// Uniform: d_i = 1 / n_rows.
  void reset(std::size_t n_rows);

  /// Adds P(v_i) = 1 / (b s_i) for a fully traced column [eq. 5, 6]: b runs of equal bits, s_i active rows in the run
  /// of row i. Inactive rows neither end a run nor count in it, and gain nothing. Cost: O(n_rows).
  void add_column(Words active, Words visible);

  /// Sets in `drawn` (all 0 at entry) `count` different rows of `eligible`, drawn one after the other in proportion to
  /// the d of those not yet drawn. All of `eligible` when it has no more than `count`.
  void draw(std::size_t count, Words eligible, Rng& rng, MutableWords drawn);

  /// The same with equal weights; takes no account of d.
  void draw_uniform(std::size_t count, Words eligible, Rng& rng, MutableWords drawn);

  /// d_i, not normalised.
  double weight(std::size_t i) const { return static_cast<double>(weights_[i]) * 0x1p-40; }

 private:
  void add_to_rows(std::size_t begin, std::size_t end, Words active, std::uint64_t amount);
  void list_rows(Words eligible, Words drawn);

  std::vector<std::uint64_t> weights_;  ///< [n_rows]
  IndexedSums sums_;                    ///< of weights_, when clean_
  bool clean_ = false;
  std::vector<std::uint32_t> rows_;    ///< rows still to choose from, listed once rejection gets slow
  IndexedSums listed_sums_;            ///< of their weights
  std::vector<std::uint64_t> filled_;  ///< a column with each inactive bit equal to the active one before it
};

}  // namespace myrialux
