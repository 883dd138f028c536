// Irradiance-like sums of diffuse rows: E_i += sum_c V_ic rgb_c cos_i cos_c min(1 / d^2, 1 / clamp^2). [wang20, 4.6]
// The row's diffuse albedo / pi is left to the caller, once a row. About 20 flops a pair.
#pragma once

#include <cstdint>
#include <span>

#include "myrialux/kernels/shade_block.h"

namespace myrialux {

/// How a column sends light to diffuse rows.
enum class DiffuseLight : std::uint8_t {
  oriented,     ///< cos at the light, 1 / d^2
  point,        ///< 1 / d^2
  directional,  ///< neither
};

struct DiffuseRun {
  DiffuseLight kind = DiffuseLight::oriented;
  std::span<const ColumnLight> lights;
  std::span<const std::uint64_t> visible;  ///< [lights.size()], bit r: row r sees the light and takes part
  bool bumpy = true;                       ///< false: n == ng in all rows and lights, which halves the cosines
  float clamp_distance = 0;                ///< 0: unclamped; then nothing is removed and `tracked` is not looked at
  std::uint64_t tracked = 0;               ///< rows whose removed light is summed, in groups of 16
};

/// Columns are added in order; rows never mix, so a row's bits depend on its columns and the instruction set alone.
void shade_diffuse(const RowBlock& rows, const DiffuseRun& run, BlockSums& sums);

/// The same by plain scalar code.
void shade_diffuse_plain(const RowBlock& rows, const DiffuseRun& run, BlockSums& sums);

}  // namespace myrialux
