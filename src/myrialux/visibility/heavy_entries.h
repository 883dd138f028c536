// Entries of a slice that may carry more light than a picture can bear to have guessed.
// Not part of [wang20]: docs/decisions/0006-heavy-entries-are-traced.md.
#pragma once

#include "myrialux/clusters/cut.h"
#include "myrialux/matrix/bit_matrix.h"

namespace myrialux {

/// Active entries whose weight W T beta (luminance, no occlusion) may exceed `limit`, in whole packets: where one row
/// of 16 adjacent ones may, all active rows of the packet are marked, since they are traced at the price of one. By
/// upper bounds of T [walter05, 4.1], so that no entry above the limit is missed; rough lobes are bounded by their
/// shape about the mirror direction. Few columns come near the limit, the others cost a distance each.
/// @param active [rows x columns]
/// @param clamp_distance as CutParams
/// @param limit radiance, > 0
BitMatrix heavy_entries(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                        const VirtualLights& lights, const LightTree& tree, std::span<const Column> columns,
                        const BitMatrix& active, float clamp_distance, float limit);

}  // namespace myrialux
