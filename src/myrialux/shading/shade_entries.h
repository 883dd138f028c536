// Single entries of the light matrix, V T, by the kernels that else sum them.
#pragma once

#include <span>

#include "myrialux/shading/shade.h"

namespace myrialux {

/// Luminance of each visible entry, 0 for the others; weights of columns and beta are not applied.
/// @param rows at most 64
/// @param visible [rows x columns]
/// @param entries [columns x 64], set; column by column, rows that do not exist are 0
void shade_entries(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                   const VirtualLights& lights, std::span<const Column> columns, const BitMatrix& visible,
                   const ShadeParams& params, std::span<float> entries);

}  // namespace myrialux
