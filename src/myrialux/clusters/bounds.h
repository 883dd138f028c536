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

/// Two more vectors for a unit one.
AxisFrame axis_frame(Vec3 axis);

CutCluster make_cut_cluster(const LightTree& tree, std::uint32_t node);

/// One light times `weight` as a cluster of its own: bounds of a column's entries rather than of its cluster's.
CutCluster make_light_cluster(const World& world, const VirtualLights& lights, LightId light, float importance,
                              float weight);

}  // namespace myrialux
