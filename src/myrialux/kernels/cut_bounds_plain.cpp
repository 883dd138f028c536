// The plain twin of the cut bounds: one receiver at a time, same operations in the same order. [walter05, 4.1]
#include <algorithm>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/bound_terms.h"

namespace myrialux {
namespace {

AxisFrame frame_of(const float (&soa)[9][kCutLanes], std::size_t k) {
  AxisFrame f;
  for (int a = 0; a < 3; ++a) f.axis[a] = soa[a][k], f.s[a] = soa[3 + a][k], f.t[a] = soa[6 + a][k];
  return f;
}

float receiver_bound(const CutPoints& points, const CutPoints::Group& g, std::size_t k, const RelativeBox& r) {
  const float cosine = largest_cosine(r, frame_of(g.normal, k));
  float bound = g.diffuse[k] * std::max(cosine, 0.0f);
  if (points.any_gloss) {
    const float lobe = gloss_shape(largest_cosine(r, frame_of(g.mirror, k)), g.inverse_alpha2[k], g.c1[k], g.c2[k],
                                   g.c3[k], g.t_least[k]);
    bound = bound + (cosine > 0 ? g.gloss[k] * lobe : 0.0f);
    bound = bound + g.any[k];
  }
  return bound;
}

float bound_lane(const CutPoints& points, const CutPoints::Group& g, std::size_t k, const CutCluster& c) {
  const float p[3] = {g.p[0][k], g.p[1][k], g.p[2][k]};
  const RelativeBox r = relative_box(p, p, c);
  const float bound = receiver_bound(points, g, k, r) * light_bound(c, r);
  return c.distant ? bound : bound / std::max(r.near_squared, points.least_distance_squared);
}

float bound_group(const CutPoints& points, const CutPoints::Group& g, const CutCluster& c) {
  float largest = 0;
  for (std::size_t k = 0; k < kCutLanes; ++k) largest = std::max(largest, bound_lane(points, g, k, c));
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

void bound_lanes_plain(const CutPoints& points, std::size_t group, const CutCluster& cluster,
                       std::span<float, kCutLanes> bounds) {
  MYRIALUX_ASSERT(group < points.groups.size() && points.least_distance_squared > 0);
  for (std::size_t k = 0; k < kCutLanes; ++k) bounds[k] = bound_lane(points, points.groups[group], k, cluster);
}

}  // namespace myrialux
