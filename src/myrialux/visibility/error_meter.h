// How wrong completed bits are, told by a few true rays: one random entry a row.
#pragma once

#include "myrialux/clusters/cut.h"
#include "myrialux/matrix/bit_matrix.h"

namespace myrialux {

/// Sums over the rows that were looked at; they add up over slices. Energies are luminances W T beta over a unit.
struct MeterReading {
  std::uint64_t rays = 0;  ///< one a row that has active entries
  std::uint64_t false_visible = 0, false_occluded = 0;
  std::uint64_t discarded_rays = 0;  ///< of completions that were done again
  double squares = 0;                ///< estimates the sum over rows and wrong entries of energy^2
  double bias = 0;                   ///< the sum over rows and entries of energy (completed - true)
  MeterReading& operator+=(const MeterReading& o) {
    rays += o.rays, discarded_rays += o.discarded_rays, false_visible += o.false_visible,
        false_occluded += o.false_occluded;
    squares += o.squares, bias += o.bias;
    return *this;
  }
};

/// A slice with its bits, completed or true.
struct CompletedSlice {
  const World& world;
  const Receivers& receivers;
  std::span<const ReceiverId> rows;
  const VirtualLights& lights;
  std::span<const Column> columns;
  const BitMatrix& active;  ///< [rows x columns]
  float clamp_distance = 0;
  float unit = 1;  ///< radiance that counts as energy 1; > 0
};

/// Holds one active entry of each row, chosen evenly among the row's, against its ray. Unbiased in all five numbers;
/// the share of wrong entries is the mean over rows of their own shares. Cost: a scattered ray a row.
MeterReading measure_errors(const CompletedSlice& slice, const BitMatrix& visible, Rng& rng);

/// Of all active entries, where the true bits are known: the sum over rows and wrong entries of energy^2.
double sum_wrong_squares(const CompletedSlice& slice, const BitMatrix& visible, const BitMatrix& truth);

/// Number of set bits in each row, [n_rows].
std::vector<std::uint32_t> bits_of_rows(const BitMatrix& bits);

}  // namespace myrialux
