// Receivers and tree nodes in the form the bounding kernel reads.
#pragma once

#include <span>

#include "myrialux/clusters/light_tree.h"
#include "myrialux/kernels/cut_bounds.h"
#include "myrialux/receivers/receivers.h"

namespace myrialux {

/// @param clamp_distance as CutParams; 0 leaves a least distance of 1e-10
CutPoints make_cut_points(const World& world, const Receivers& receivers, std::span<const ReceiverId> points,
                          float clamp_distance);

CutCluster make_cut_cluster(const LightTree& tree, std::uint32_t node);

}  // namespace myrialux
