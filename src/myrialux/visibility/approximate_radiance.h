// Phase I of IlluminationCut: about how bright each receiver is, from pairs of clusters that are small for their
// distance. [bus15, 3]
#pragma once

#include "myrialux/clusters/light_tree.h"
#include "myrialux/clusters/point_tree.h"

namespace myrialux {

struct ApproximationParams {
  float radius = 0.1f;       ///< both clusters' radii stay below this share of their distance
  float aperture_deg = 20;   ///< full opening angle of the light cluster's cone of normals stays below this
  float clamp_distance = 0;  ///< as in shading
  float scene_radius = 0;    ///< distant lights count as two of these away
};

struct ApproximationCounters {
  std::uint64_t pairs = 0, rays = 0;
};

/// Sets `colour` of all point nodes: the least approximate radiance (luminance, beta not included) of their receivers.
/// Each pair costs one shadow ray, between the representatives; its light goes to all receivers of the point node as it
/// is at the representative. Same bits for any number of threads.
ApproximationCounters approximate_radiance(const World& world, const Receivers& receivers, const VirtualLights& lights,
                                           const LightTree& light_tree, const ApproximationParams& params,
                                           PointTree& point_tree);

}  // namespace myrialux
