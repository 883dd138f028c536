// Sums of rows and lights of any kind: L_i += sum_c V_ic f_i(d) I_c(d) min(1 / d^2, 1 / clamp^2). [wang20, 4.6]
// A few columns at a time: first what arrives at the rows from each light, then what each kind of row makes of it.
#pragma once

#include <cstdint>
#include <span>

#include "myrialux/kernels/lobes.h"
#include "myrialux/kernels/shade_block.h"

namespace myrialux {

enum class LightShape : std::uint8_t { oriented, point, directional, spot, glossy };

struct SpotCone {
  float cos_cutoff, cos_beam;
  float cutoff, inverse_width;  ///< radians: falloff = (cutoff - angle) * inverse_width between beam and cutoff
};

struct GeneralLight {
  ColumnLight at;  ///< spot: n = axis; glossy: ng on the side of its frame's normal
  LightShape shape = LightShape::oriented;
  std::uint32_t extra = 0;  ///< spot, glossy: into `spots`, `lobes`
};

struct GeneralRun {
  std::span<const GeneralLight> lights;
  std::span<const std::uint64_t> visible;  ///< [lights.size()], bit r: row r sees the light and takes part
  std::span<const SpotCone> spots;
  std::span<const LightLobes> lobes;
  std::span<const float> tables;  ///< transmittances of rough coats, [n * kTableFloats]
  float clamp_distance = 0;       ///< 0: unclamped; then nothing is removed
  std::uint64_t tracked = 0;      ///< rows whose removed light is summed, in groups of 16
};

/// Columns are added in order; rows never mix, so a row's bits depend on its columns and the instruction set alone.
/// Rows of no class stay 0. The scalar twin is transfer() (transfer/transfer.h).
void shade_general(const RowBlock& rows, const RowLobes& row_lobes, const GeneralRun& run, BlockSums& sums);

}  // namespace myrialux
