// Upper bound of what a cluster of lights sends to a cluster of receivers: box to box, cone to cone. [walter06]
// Scalar: a cut needs four such bounds a step, fewer than would fill vectors.
#pragma once

#include "myrialux/kernels/bound_terms.h"

namespace myrialux {

/// A cluster of receivers. For each of them f(wi, wo) cos wi is at most
///   diffuse cos(normal cone) + gloss shape(mirror cone) [cos > 0] + any
struct PairReceivers {
  float lower[3], upper[3];  ///< of positions
  AxisFrame normal;          ///< frame of the axis of the normals' cone
  float normal_cos, normal_sin;
  AxisFrame mirror;  ///< the same for mirror directions of wo
  float mirror_cos, mirror_sin;
  float diffuse, gloss, any;
  float inverse_alpha2, c1, c2, c3, t_least;  ///< shape()
};

/// Of light and any receiver's transfer, and of the sum over the cluster's lights for any receiver (luminance).
/// Largest cosine over the box of differences to the cone's axis, widened by the cone: no receiver's own normal (mirror
/// direction) can be nearer to a direction that occurs, and cosines and shape() fall with the angle.
/// @param least_distance_squared clamp distance squared; > 0
inline float bound_pair(const PairReceivers& g, const CutCluster& c, float least_distance_squared) {
  const RelativeBox r = relative_box(g.lower, g.upper, c);
  const float cosine = widen(largest_cosine(r, g.normal), g.normal_cos, g.normal_sin);
  float bound = g.diffuse * std::max(cosine, 0.0f) + g.any;
  if (g.gloss > 0 && cosine > 0) {
    const float mirror = widen(largest_cosine(r, g.mirror), g.mirror_cos, g.mirror_sin);
    bound = bound + g.gloss * gloss_shape(mirror, g.inverse_alpha2, g.c1, g.c2, g.c3, g.t_least);
  }
  if (!(bound > 0)) return 0;
  bound = bound * light_bound(c, r);
  return c.distant ? bound : bound / std::max(r.near_squared, least_distance_squared);
}

}  // namespace myrialux
