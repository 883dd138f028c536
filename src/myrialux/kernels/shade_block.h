// What shading kernels read and write: 64 rows of a slice side by side, lights one after another.
#pragma once

#include <cstddef>
#include <cstdint>

namespace myrialux {

inline constexpr std::size_t kBlockRows = 64;  ///< rows of one word of visibility bits
using BlockFloats = float[kBlockRows];

/// Rows of the last block that do not exist keep finite numbers; their bits are 0.
struct alignas(64) RowBlock {
  BlockFloats p[3];   ///< on the surface
  BlockFloats n[3];   ///< unit shading normal
  BlockFloats ng[3];  ///< unit geometric normal
};

/// One column. Flat, so that a kernel broadcasts straight from memory.
struct ColumnLight {
  float p[3];    ///< position; unused by directional lights
  float n[3];    ///< oriented: emission normal; directional: direction of travel
  float ng[3];   ///< oriented: geometric normal
  float rgb[3];  ///< LightKind's `light` times the column's weight
};

/// Sums over columns, added to by kernels.
struct alignas(64) BlockSums {
  BlockFloats rgb[3];
  BlockFloats removed[3];  ///< what clamping took from `rgb`, only of the rows in `tracked`
};

/// Squared distances are at least this, so that receivers on a light stay finite.
inline constexpr float kLeastSquaredDistance = 1e-30f;
/// Largest 1 / d^2 that counts; enough for all distances where there is no clamping.
constexpr float inverse_squared_clamp(float clamp_distance) {
  return clamp_distance > 0 ? 1 / (clamp_distance * clamp_distance) : 3e38f;
}

/// Rows whose clamped-away light is summed: the first 16 of every 128, since it costs a third more.
constexpr bool is_tracked_row(std::size_t row_in_slice) { return row_in_slice / 16 % 8 == 0; }

}  // namespace myrialux
