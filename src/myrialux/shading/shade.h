// Sums visible transfer: L_i += sum_c W_c V_ic T_ic, by vectorised kernels, in a fixed order. [wang20, 4.6]
#pragma once

#include <span>

#include "myrialux/clusters/cut.h"
#include "myrialux/matrix/bit_matrix.h"

namespace myrialux {

struct ShadeParams {
  float clamp_distance = 0;  ///< 0 = unclamped
};

struct ShadeResult {
  double radiance_sum = 0;      ///< luminance summed over rows, beta not included
  double clamped_away_sum = 0;  ///< luminance that clamping removed from visible entries; measured on the first 16 of
                                ///< every 128 rows and scaled up
};

/// @param visible [rows x columns]; @param radiance [rows], set; beta is not applied
ShadeResult shade_slice(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                        const VirtualLights& lights, std::span<const Column> columns, const BitMatrix& visible,
                        const ShadeParams& params, std::span<Rgb> radiance);

/// The same by plain scalar code over transfer(): the kernels' twin.
void shade_slice_plain(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                       const VirtualLights& lights, std::span<const Column> columns, const BitMatrix& visible,
                       const ShadeParams& params, std::span<Rgb> radiance);

}  // namespace myrialux
