// What each column of a slice may bring: the scale on which a completion decides where rays are worth it.
#pragma once

#include "myrialux/clusters/cut.h"

namespace myrialux {

/// Mean of W T beta (luminance, no occlusion) over at most 16 receivers of the slice, evenly spaced in its order;
/// [n_columns]. Cost: 16 n_columns evaluations of T.
/// @param clamp_distance as CutParams
std::vector<float> column_energies(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                                   const VirtualLights& lights, std::span<const Column> columns, float clamp_distance);

}  // namespace myrialux
