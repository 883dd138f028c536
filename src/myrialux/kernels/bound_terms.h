// Terms of the bounds between boxes of receivers and clusters of lights, one pair at a time: nearest and farthest
// distance, largest cosines to an axis or a cone, falloff of gloss. [walter05, 4.1; walter06]
#pragma once

#include <algorithm>
#include <cmath>

#include "myrialux/kernels/cut_bounds.h"

namespace myrialux {

/// Box of all vectors from the receivers to the lights.
struct RelativeBox {
  float lower[3], upper[3];
  float near_squared, far_squared;  ///< distances
};

/// @param lower, upper of the receivers' positions
inline RelativeBox relative_box(const float (&lower)[3], const float (&upper)[3], const CutCluster& c) {
  RelativeBox r{};
  for (int a = 0; a < 3; ++a) {
    r.lower[a] = c.lower[a] - (c.distant ? 0 : upper[a]), r.upper[a] = c.upper[a] - (c.distant ? 0 : lower[a]);
    const float gap = std::max(std::max(r.lower[a], -r.upper[a]), 0.0f);
    const float far = std::max(r.upper[a], -r.lower[a]);
    r.near_squared = r.near_squared + gap * gap, r.far_squared = r.far_squared + far * far;
  }
  return r;
}

/// Squared distance from 0 of the nearest value that the coordinate along `axis` takes in the box.
inline float coordinate_gap_squared(const RelativeBox& r, const float (&axis)[3]) {
  float least = 0, most = 0;
  for (int a = 0; a < 3; ++a) {
    const float x = axis[a] * r.lower[a], y = axis[a] * r.upper[a];
    least = least + std::min(x, y), most = most + std::max(x, y);
  }
  const float gap = std::max(std::max(least, -most), 0.0f);
  return gap * gap;
}

/// Largest cosine between the frame's axis and any direction into the box.
inline float largest_cosine(const RelativeBox& r, const AxisFrame& frame) {
  float z = 0;
  for (int a = 0; a < 3; ++a) z = z + std::max(frame.axis[a] * r.lower[a], frame.axis[a] * r.upper[a]);
  const float across = coordinate_gap_squared(r, frame.s) + coordinate_gap_squared(r, frame.t);
  const float length_squared = z < 0 ? r.far_squared : z * z + across;
  return z / std::sqrt(std::max(length_squared, 1e-30f));
}

/// Largest cosine to any direction within a cone, given the largest to its axis.
inline float widen(float cosine, float cone_cos, float cone_sin) {
  const float sine = std::sqrt(std::max(1 - cosine * cosine, 0.0f));
  return cosine >= cone_cos ? 1 : cosine * cone_cos + sine * cone_sin;
}

/// Of a gloss lobe, relative to its value in the mirror direction. lobe_bounds.h
inline float gloss_shape(float cosine, float inverse_alpha2, float c1, float c2, float c3, float t_least) {
  const float ratio = (1 - cosine) / std::max(1 + cosine, 1e-6f);
  const float t = std::min(std::max(ratio, t_least), 1e6f), x = t * inverse_alpha2;
  return (1 + t) * (1 + t) / (1 + x * (c1 + x * (c2 + x * c3)));
}

/// Largest intensity of the cluster along any direction from the box to the cluster.
inline float light_bound(const CutCluster& c, const RelativeBox& r) {
  if (!c.has_cone) return c.diffuse;
  const float cosine = std::max(widen(largest_cosine(r, c.back), c.cone_cos, c.cone_sin), 0.0f);
  float bound = c.diffuse * cosine;
  if (c.gloss > 0 || c.any > 0) {
    const float mirror = widen(largest_cosine(r, c.mirror_back), c.mirror_cos, c.mirror_sin);
    const float lobe = gloss_shape(mirror, c.inverse_alpha2, 1, 0.5f, 0, 0);
    bound = bound + (cosine > 0 ? c.gloss * lobe : 0.0f);
    bound = bound + c.any;
  }
  return bound;
}

}  // namespace myrialux
