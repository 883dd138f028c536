// How wrong completed bits are, told by a few true rays: one random entry a row, and more where that one is wrong.
#pragma once

#include "myrialux/clusters/cut.h"
#include "myrialux/matrix/bit_matrix.h"

namespace myrialux {

/// Rays that follow a wrong one, spread over the rows of its pixel.
inline constexpr std::uint32_t kFollowingRays = 32;

/// Sums over the rows that were looked at; they add up over slices. Energies are luminances W T beta over a unit, the
/// error of a row is the sum over its entries of energy (completed - true).
struct MeterReading {
  std::uint64_t rays = 0;  ///< one a row that has active entries
  std::uint64_t false_visible = 0, false_occluded = 0;
  std::uint64_t more_rays = 0;  ///< those that followed wrong ones, and all of completions that were done again
  double squares = 0;           ///< estimates the sum over pixels of (sum of the pixel's rows' errors)^2
  double bias = 0;              ///< the sum over rows of their errors
  MeterReading& operator+=(const MeterReading& o) {
    rays += o.rays, more_rays += o.more_rays;
    false_visible += o.false_visible, false_occluded += o.false_occluded;
    squares += o.squares, bias += o.bias;
    return *this;
  }
};

/// A slice and what can be known of it.
struct CompletedSlice {
  const World& world;
  const Receivers& receivers;
  std::span<const ReceiverId> rows;
  const VirtualLights& lights;
  std::span<const Column> columns;
  const BitMatrix& active;  ///< [rows x columns]
  float clamp_distance = 0;
  float unit = 1;         ///< radiance that counts as energy 1; > 0
  std::uint32_t spp = 1;  ///< receivers of one pixel: Receivers::sample / spp
};

/// Holds one active entry of each row, chosen evenly among the row's, against its ray. Unbiased in all numbers; the
/// share of wrong entries is the mean over rows of their own shares. The square of a pixel's error is the sum over its
/// wrong entries of their error times the pixel's: so where an entry is found wrong, kFollowingRays tell the pixel's
/// error (of its rows in this slice). Wrong bits of a pixel come together, so that the squares of single entries alone
/// would tell a tenth of it, and how many come together differs from slice to slice. Cost: a scattered ray a row, and
/// kFollowingRays for each that is wrong.
MeterReading measure_errors(const CompletedSlice& slice, const BitMatrix& visible, Rng& rng);

/// Number of set bits in each row, [n_rows].
std::vector<std::uint32_t> bits_of_rows(const BitMatrix& bits);

}  // namespace myrialux
