// A matrix split into one of low rank and one of few entries: min |A|_* + lambda |E|_1, A + E = D. [candes11; lin10]
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace myrialux {

/// What is known of an entry of D.
enum class EntryKind : std::uint8_t {
  missing,  ///< nothing: E is free there and costs nothing
  doubted,  ///< D may be wrong: E costs lambda
  certain,  ///< D is right: E = 0
};

struct RobustPcaParams {
  float lambda = 1;                   ///< times 1 / sqrt(max(rows, columns)), the weight of [candes11, theorem 1.1]
  float tolerance = 1e-4f;            ///< |D - A - E|_F / |D|_F at which iteration ends
  std::uint32_t max_iterations = 60;  ///< each multiplies D's size by the rank a few times
};

struct RobustPca {
  std::vector<float> low_rank;  ///< A [n_rows * n_columns], column by column
  std::size_t rank = 0;
  std::uint32_t n_iterations = 0;
  bool converged = false;
};

/// Inexact augmented Lagrange multipliers [lin10, algorithm 5]: A by thresholding singular values, E by thresholding
/// entries, once a round; penalty times 1.2 a round. Only singular values above the threshold are computed, by subspace
/// iteration from the subspace of the round before.
/// @param d [n_rows * n_columns], column by column; missing entries are not read
/// @param kind the same; empty: all doubted
/// Cost: about 4 n_rows n_columns (rank + 8) multiply-adds a round; some 20 to 30 rounds.
RobustPca robust_pca(std::size_t n_rows, std::size_t n_columns, std::span<const float> d,
                     std::span<const EntryKind> kind, const RobustPcaParams& params);

}  // namespace myrialux
