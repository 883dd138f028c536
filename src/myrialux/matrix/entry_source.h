// Where a completion gets true bits from: traced rays in a render, a known matrix in a test.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "myrialux/matrix/bit_matrix.h"

namespace myrialux {

/// Numbers by which rows can be told near or far: their coordinates.
using RowPoint = std::array<float, 3>;

class EntrySource {
 public:
  virtual ~EntrySource() = default;
  virtual std::size_t n_rows() const = 0;
  virtual std::size_t n_columns() const = 0;
  /// Rows of column j that matter: bits of others are "don't care" and never asked for.
  virtual Words active(std::size_t j) const = 0;
  /// Active rows of column j that weigh too much to be guessed; completion traces them before anything else and takes
  /// them for samples. Empty: none.
  virtual Words required(std::size_t j) const {
    (void)j;
    return {};
  }
  /// What column j may bring at most, in any unit: the mean of its entries' weights, all visible. 1: nothing is known.
  virtual float energy(std::size_t j) const {
    (void)j;
    return 1;
  }
  /// What the entries of each block of 16 rows of column j may bring, all visible; 1: the mean of the picture, from all
  /// columns together. Where nothing is known, all columns share it evenly. @param energies [blocks]
  virtual void block_energies(std::size_t j, std::span<float> energies) const {
    (void)j;
    std::fill(energies.begin(), energies.end(), 1 / static_cast<float>(n_columns()));
  }
  /// [n_rows], or empty: nothing is known but the order of the rows, in which neighbours are near.
  virtual std::span<const RowPoint> row_points() const { return {}; }
  /// Columns of one group are alike (same octant) and completed together: groups are [begin, end) runs of columns.
  virtual std::size_t n_groups() const { return 1; }
  virtual std::size_t group_end(std::size_t g) const {
    (void)g;
    return n_columns();
  }
  /// Sets bit i of `visible` for each wanted row i that is unoccluded, clears it for the other wanted rows.
  /// Bits of rows not wanted stay as they are. `wanted` must lie within active(j).
  virtual void trace(std::size_t j, Words wanted, MutableWords visible) = 0;
};

}  // namespace myrialux
