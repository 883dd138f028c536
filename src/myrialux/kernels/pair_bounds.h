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

/// Largest product of both cosines whatever lies between: directions along which the receivers' normal and the lights'
/// lean by x and y have x + y >= gamma, the angle between one normal and the other reversed, so the product is at most
/// cos^2 (gamma / 2). Lights and receivers of one plane get 0 though their boxes overlap.
inline float largest_cosine_product(const PairReceivers& g, const CutCluster& c) {
  float between = 0;
  for (int a = 0; a < 3; ++a) between = between + g.normal.axis[a] * c.back.axis[a];
  const float gamma = widen(widen(between, g.normal_cos, g.normal_sin), c.cone_cos, c.cone_sin);
  return std::max(0.5f + 0.5f * gamma, 0.0f);
}

/// Of the transfer from any of the lights, times importance, to any of the receivers, and of the sum over the lights
/// (luminance). Largest cosine over the box of differences to the cone's axis, widened by the cone: no receiver's own
/// normal (mirror direction) can be nearer to a direction that occurs, and cosines and shape() fall with the angle.
/// @param least_distance_squared clamp distance squared; > 0
inline float bound_pair(const PairReceivers& g, const CutCluster& c, float least_distance_squared) {
  const RelativeBox r = relative_box(g.lower, g.upper, c);
  const float cosine = std::max(widen(largest_cosine(r, g.normal), g.normal_cos, g.normal_sin), 0.0f);
  float gloss = g.any;
  if (g.gloss > 0 && cosine > 0) {
    const float mirror = widen(largest_cosine(r, g.mirror), g.mirror_cos, g.mirror_sin);
    gloss = gloss + g.gloss * gloss_shape(mirror, g.inverse_alpha2, g.c1, g.c2, g.c3, g.t_least);
  }
  if (!(g.diffuse * cosine + gloss > 0)) return 0;
  const float light = light_bound(c, r);
  float lit = cosine * light;
  if (c.has_cone && c.gloss == 0 && c.any == 0) lit = std::min(lit, c.diffuse * largest_cosine_product(g, c));
  const float bound = g.diffuse * lit + gloss * light;
  return c.distant ? bound : bound / std::max(r.near_squared, least_distance_squared);
}

}  // namespace myrialux
