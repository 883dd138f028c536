// How wrong completed bits are, told by a few true rays: one or two random entries a row, and more where one is wrong.
#pragma once

#include "myrialux/clusters/cut.h"
#include "myrialux/matrix/bit_matrix.h"
#include "myrialux/matrix/block_doubts.h"
#include "myrialux/visibility/block_energies.h"

namespace myrialux {

/// One row of so many is looked at by energy, too.
inline constexpr std::uint32_t kRowsByEnergy = 2;
/// Rays that follow a wrong one found there, spread over the rows of its pixel.
inline constexpr std::uint32_t kFollowingRays = 32;

/// Sums over the rows that were looked at. Energies are luminances W T beta over a unit, the
/// error of a row is the sum over its entries of energy (completed - true).
struct MeterReading {
  std::uint64_t rays = 0;  ///< one a row that has active entries
  std::uint64_t false_visible = 0, false_occluded = 0;
  std::uint64_t more_rays = 0;        ///< by energy, following wrong ones, and all of completions that were done again
  std::uint64_t wrong_by_energy = 0;  ///< wrong entries on which squares and bias rest
  double squares = 0;                 ///< estimates the sum over pixels of (sum of their rows' errors)^2
  double bias = 0;                    ///< the sum over rows of their errors
};

/// A slice and what can be known of it.
struct CompletedSlice {
  const World& world;
  const Receivers& receivers;
  std::span<const ReceiverId> rows;
  const VirtualLights& lights;
  std::span<const Column> columns;
  const BlockEnergies& energies;
  const BlockDoubts& doubts;
  const BitMatrix& active;  ///< [rows x columns]
  float clamp_distance = 0;
  float unit = 1;         ///< radiance that counts as energy 1; > 0
  std::uint32_t spp = 1;  ///< receivers of one pixel: Receivers::sample / spp
};

/// Holds random entries against their rays, in two ways. One of each row, chosen evenly among its active ones, tells
/// how many are wrong: the share of wrong entries is the mean over rows of their own shares. One of every other row,
/// drawn by the energy of its block and the root of its doubt (some evenly), tells what wrong ones add: where errors
/// come from a handful of bright entries, evenly chosen ones miss them nearly always. The square of a pixel's error is
/// the sum over its wrong entries of their error times the pixel's: so where such an entry is wrong, kFollowingRays,
/// drawn alike, tell the pixel's error (of its rows in this slice). Wrong bits of a pixel come together: squares of
/// single entries alone would tell as little as a tenth. Unbiased in all numbers; `squares` may come out negative.
/// Cost: a scattered ray a row and a half, kFollowingRays for each that is wrong in the half.
MeterReading measure_errors(const CompletedSlice& slice, const BitMatrix& visible, Rng& rng);

}  // namespace myrialux
