// The plain twin of the cut bounds: one receiver at a time, same operations in the same order. [walter05, 4.1]
#include <algorithm>
#include <cmath>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/cut_bounds.h"

namespace myrialux {
namespace {

/// The cluster's box as seen from the point.
struct Relative {
  float lower[3], upper[3];
  float near_squared, far_squared;  ///< distances
};

Relative relative_box(const CutPoints::Group& g, std::size_t k, const CutCluster& c) {
  Relative r{};
  for (int a = 0; a < 3; ++a) {
    const float p = c.distant ? 0 : g.p[a][k];
    r.lower[a] = c.lower[a] - p, r.upper[a] = c.upper[a] - p;
    const float gap = std::max(std::max(r.lower[a], -r.upper[a]), 0.0f);
    const float far = std::max(r.upper[a], -r.lower[a]);
    r.near_squared = r.near_squared + gap * gap, r.far_squared = r.far_squared + far * far;
  }
  return r;
}

/// Squared distance from 0 of the nearest value that the coordinate along `axis` takes in the box.
float coordinate_gap_squared(const Relative& r, const float axis[3]) {
  float least = 0, most = 0;
  for (int a = 0; a < 3; ++a) {
    const float x = axis[a] * r.lower[a], y = axis[a] * r.upper[a];
    least = least + std::min(x, y), most = most + std::max(x, y);
  }
  const float gap = std::max(std::max(least, -most), 0.0f);
  return gap * gap;
}

/// Largest cosine between the frame's axis and any direction into the box.
float largest_cosine(const Relative& r, const AxisFrame& frame) {
  float z = 0;
  for (int a = 0; a < 3; ++a) z = z + std::max(frame.axis[a] * r.lower[a], frame.axis[a] * r.upper[a]);
  const float across = coordinate_gap_squared(r, frame.s) + coordinate_gap_squared(r, frame.t);
  const float length_squared = z < 0 ? r.far_squared : z * z + across;
  return z / std::sqrt(std::max(length_squared, 1e-30f));
}

/// Largest cosine to any direction within a cone, given the largest to its axis.
float widen(float cosine, float cone_cos, float cone_sin) {
  const float sine = std::sqrt(std::max(1 - cosine * cosine, 0.0f));
  return cosine >= cone_cos ? 1 : cosine * cone_cos + sine * cone_sin;
}

/// Of a gloss lobe, relative to its value in the mirror direction. lobe_bounds.h
float shape(float cosine, float inverse_alpha2, float c1, float c2, float c3, float t_least) {
  const float ratio = (1 - cosine) / std::max(1 + cosine, 1e-6f);
  const float t = std::min(std::max(ratio, t_least), 1e6f), x = t * inverse_alpha2;
  return (1 + t) * (1 + t) / (1 + x * (c1 + x * (c2 + x * c3)));
}

AxisFrame frame_of(const float (&soa)[9][kCutLanes], std::size_t k) {
  AxisFrame f;
  for (int a = 0; a < 3; ++a) f.axis[a] = soa[a][k], f.s[a] = soa[3 + a][k], f.t[a] = soa[6 + a][k];
  return f;
}

float receiver_bound(const CutPoints& points, const CutPoints::Group& g, std::size_t k, const Relative& r) {
  const float cosine = largest_cosine(r, frame_of(g.normal, k));
  float bound = g.diffuse[k] * std::max(cosine, 0.0f);
  if (points.any_gloss) {
    const float lobe =
        shape(largest_cosine(r, frame_of(g.mirror, k)), g.inverse_alpha2[k], g.c1[k], g.c2[k], g.c3[k], g.t_least[k]);
    bound = bound + (cosine > 0 ? g.gloss[k] * lobe : 0.0f);
    bound = bound + g.any[k];
  }
  return bound;
}

float light_bound(const CutCluster& c, const Relative& r) {
  if (!c.has_cone) return c.diffuse;
  const float cosine = std::max(widen(largest_cosine(r, c.back), c.cone_cos, c.cone_sin), 0.0f);
  float bound = c.diffuse * cosine;
  if (c.gloss > 0 || c.any > 0) {
    const float mirror = widen(largest_cosine(r, c.mirror_back), c.mirror_cos, c.mirror_sin);
    const float lobe = shape(mirror, c.inverse_alpha2, 1, 0.5f, 0, 0);
    bound = bound + (cosine > 0 ? c.gloss * lobe : 0.0f);
    bound = bound + c.any;
  }
  return bound;
}

float bound_group(const CutPoints& points, const CutPoints::Group& g, const CutCluster& c) {
  float largest = 0;
  for (std::size_t k = 0; k < kCutLanes; ++k) {
    const Relative r = relative_box(g, k, c);
    float bound = receiver_bound(points, g, k, r) * light_bound(c, r);
    if (!c.distant) bound = bound / std::max(r.near_squared, points.least_distance_squared);
    largest = std::max(largest, bound);
  }
  return largest;
}

}  // namespace

void bound_clusters_plain(const CutPoints& points, std::span<const CutCluster> clusters, std::span<float> bounds) {
  MYRIALUX_ASSERT(clusters.size() == bounds.size() && points.least_distance_squared > 0);
  for (std::size_t n = 0; n < clusters.size(); ++n) {
    bounds[n] = 0;
    for (const CutPoints::Group& g : points.groups)
      bounds[n] = std::max(bounds[n], bound_group(points, g, clusters[n]));
  }
}

void bound_groups_plain(const CutPoints& points, const CutCluster& cluster, std::span<float> bounds) {
  MYRIALUX_ASSERT(points.groups.size() == bounds.size() && points.least_distance_squared > 0);
  for (std::size_t g = 0; g < bounds.size(); ++g) bounds[g] = bound_group(points, points.groups[g], cluster);
}

}  // namespace myrialux
