// Cut bounds by Highway: the receivers of a group are the lanes, the cluster is broadcast. Twin: cut_bounds_plain.cpp
#include "myrialux/kernels/cut_bounds.h"

#include "myrialux/base/assert.h"
#include "myrialux/kernels/targets.h"
// The rest of this file up to HWY_ONCE is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "myrialux/kernels/cut_bounds.cpp"
#include "hwy/foreach_target.h"
// Order matters: after foreach_target.h.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, kCutLanes>;
using V = hn::Vec<Tag>;

/// The cluster's box as seen from the points, and squared distances. kPoint: it has no extent, `upper` and
/// `far_squared` are not set; the same bits in half the operations.
template <bool kPoint>
struct Relative {
  V lower[3], upper[3], near_squared, far_squared;
};
/// Unit vector and its frame: of the points (a lane each) or of the cluster (the same in all lanes).
struct FrameLanes {
  V axis[3], s[3], t[3];
};

bool is_point(const CutCluster& c) {
  return c.lower[0] == c.upper[0] && c.lower[1] == c.upper[1] && c.lower[2] == c.upper[2];
}

HWY_INLINE V positive(V x) { return hn::Max(x, hn::Zero(Tag())); }
HWY_INLINE V set(float x) { return hn::Set(Tag(), x); }
HWY_INLINE V load(const float* x) { return hn::Load(Tag(), x); }

HWY_INLINE FrameLanes load_frame(const float (&soa)[9][kCutLanes], std::size_t k) {
  FrameLanes f;
  for (int a = 0; a < 3; ++a)
    f.axis[a] = load(soa[a] + k), f.s[a] = load(soa[3 + a] + k), f.t[a] = load(soa[6 + a] + k);
  return f;
}
HWY_INLINE FrameLanes spread_frame(const AxisFrame& frame) {
  FrameLanes f;
  for (int a = 0; a < 3; ++a) f.axis[a] = set(frame.axis[a]), f.s[a] = set(frame.s[a]), f.t[a] = set(frame.t[a]);
  return f;
}

template <bool kPoint>
HWY_INLINE Relative<kPoint> relative_box(const CutPoints::Group& g, std::size_t k, const CutCluster& c) {
  Relative<kPoint> r;
  r.near_squared = set(0);
  if constexpr (!kPoint) r.far_squared = set(0);
  for (int a = 0; a < 3; ++a) {
    const V p = c.distant ? set(0) : load(g.p[a] + k);
    r.lower[a] = hn::Sub(set(c.lower[a]), p);
    if constexpr (kPoint) {
      r.near_squared = hn::Add(r.near_squared, hn::Mul(r.lower[a], r.lower[a]));
      continue;
    }
    r.upper[a] = hn::Sub(set(c.upper[a]), p);
    const V gap = positive(hn::Max(r.lower[a], hn::Neg(r.upper[a])));
    const V far = hn::Max(r.upper[a], hn::Neg(r.lower[a]));
    r.near_squared = hn::Add(r.near_squared, hn::Mul(gap, gap));
    r.far_squared = hn::Add(r.far_squared, hn::Mul(far, far));
  }
  return r;
}

/// Largest coordinate along the axis.
template <bool kPoint>
HWY_INLINE V along(const Relative<kPoint>& r, const V axis[3]) {
  V z = set(0);
  for (int a = 0; a < 3; ++a) {
    const V low = hn::Mul(axis[a], r.lower[a]);
    z = hn::Add(z, kPoint ? low : hn::Max(low, hn::Mul(axis[a], r.upper[a])));
  }
  return z;
}

template <bool kPoint>
HWY_INLINE V coordinate_gap_squared(const Relative<kPoint>& r, const V axis[3]) {
  if constexpr (kPoint) {
    const V x = along(r, axis);
    return hn::Mul(x, x);
  }
  V least = set(0), most = set(0);
  for (int a = 0; a < 3; ++a) {
    const V x = hn::Mul(axis[a], r.lower[a]), y = hn::Mul(axis[a], r.upper[a]);
    least = hn::Add(least, hn::Min(x, y)), most = hn::Add(most, hn::Max(x, y));
  }
  const V gap = positive(hn::Max(least, hn::Neg(most)));
  return hn::Mul(gap, gap);
}

template <bool kPoint>
HWY_INLINE V largest_cosine(const Relative<kPoint>& r, const FrameLanes& frame) {
  const V z = along(r, frame.axis);
  const V across = hn::Add(coordinate_gap_squared(r, frame.s), coordinate_gap_squared(r, frame.t));
  const V far_squared = kPoint ? r.near_squared : r.far_squared;
  const V length_squared = hn::IfThenElse(hn::Lt(z, set(0)), far_squared, hn::Add(hn::Mul(z, z), across));
  return hn::Div(z, hn::Sqrt(hn::Max(length_squared, set(1e-30f))));
}

HWY_INLINE V widen(V cosine, float cone_cos, float cone_sin) {
  const V sine = hn::Sqrt(positive(hn::Sub(set(1), hn::Mul(cosine, cosine))));
  const V wide = hn::Add(hn::Mul(cosine, set(cone_cos)), hn::Mul(sine, set(cone_sin)));
  return hn::IfThenElse(hn::Ge(cosine, set(cone_cos)), set(1), wide);
}

HWY_INLINE V shape(V cosine, V inverse_alpha2, V c1, V c2, V c3, V t_least) {
  const V one = set(1);
  const V ratio = hn::Div(hn::Sub(one, cosine), hn::Max(hn::Add(one, cosine), set(1e-6f)));
  const V t = hn::Min(hn::Max(ratio, t_least), set(1e6f)), x = hn::Mul(t, inverse_alpha2);
  const V inner = hn::Add(c1, hn::Mul(x, hn::Add(c2, hn::Mul(x, c3))));
  return hn::Div(hn::Mul(hn::Add(one, t), hn::Add(one, t)), hn::Add(one, hn::Mul(x, inner)));
}

template <bool kPoint>
HWY_INLINE V receiver_bound(const CutPoints& points, const CutPoints::Group& g, std::size_t k,
                            const Relative<kPoint>& r) {
  const V cosine = largest_cosine(r, load_frame(g.normal, k));
  const V bound = hn::Mul(load(g.diffuse + k), positive(cosine));
  if (!points.any_gloss) return bound;
  const V lobe = shape(largest_cosine(r, load_frame(g.mirror, k)), load(g.inverse_alpha2 + k), load(g.c1 + k),
                       load(g.c2 + k), load(g.c3 + k), load(g.t_least + k));
  const V gloss = hn::IfThenElseZero(hn::Gt(cosine, set(0)), hn::Mul(load(g.gloss + k), lobe));
  return hn::Add(hn::Add(bound, gloss), load(g.any + k));
}

template <bool kPoint>
HWY_INLINE V light_bound(const CutCluster& c, const Relative<kPoint>& r) {
  if (!c.has_cone) return set(c.diffuse);
  const V cosine = positive(widen(largest_cosine(r, spread_frame(c.back)), c.cone_cos, c.cone_sin));
  const V bound = hn::Mul(set(c.diffuse), cosine);
  if (!(c.gloss > 0 || c.any > 0)) return bound;
  const V mirror = widen(largest_cosine(r, spread_frame(c.mirror_back)), c.mirror_cos, c.mirror_sin);
  const V lobe = shape(mirror, set(c.inverse_alpha2), set(1), set(0.5f), set(0), set(0));
  const V gloss = hn::IfThenElseZero(hn::Gt(cosine, set(0)), hn::Mul(set(c.gloss), lobe));
  return hn::Add(hn::Add(bound, gloss), set(c.any));
}

/// At the lanes from k on.
template <bool kPoint = false>
HWY_INLINE V bound_vector(const CutPoints& points, const CutPoints::Group& g, std::size_t k, const CutCluster& c) {
  const Relative<kPoint> r = relative_box<kPoint>(g, k, c);
  const V bound = hn::Mul(receiver_bound(points, g, k, r), light_bound(c, r));
  return c.distant ? bound : hn::Div(bound, hn::Max(r.near_squared, set(points.least_distance_squared)));
}

/// Larger of `largest` and the bounds at the group's points, lane by lane.
HWY_INLINE V bound_group(const CutPoints& points, const CutPoints::Group& g, const CutCluster& c, V largest) {
  for (std::size_t k = 0; k < kCutLanes; k += hn::Lanes(Tag()))
    largest = hn::Max(largest, bound_vector(points, g, k, c));
  return largest;
}

void bound_clusters(const CutPoints& points, std::span<const CutCluster> clusters, std::span<float> bounds) {
  for (std::size_t n = 0; n < clusters.size(); ++n) {
    V largest = set(0);
    for (const CutPoints::Group& g : points.groups) largest = bound_group(points, g, clusters[n], largest);
    bounds[n] = hn::GetLane(hn::MaxOfLanes(Tag(), largest));
  }
}

void bound_groups(const CutPoints& points, const CutCluster& cluster, std::span<float> bounds) {
  for (std::size_t g = 0; g < bounds.size(); ++g)
    bounds[g] = hn::GetLane(hn::MaxOfLanes(Tag(), bound_group(points, points.groups[g], cluster, set(0))));
}

template <bool kPoint>
HWY_INLINE void bound_all_lanes(const CutPoints& points, const CutPoints::Group& g, const CutCluster& cluster,
                                std::span<float, kCutLanes> bounds) {
  for (std::size_t k = 0; k < kCutLanes; k += hn::Lanes(Tag()))
    hn::StoreU(bound_vector<kPoint>(points, g, k, cluster), Tag(), bounds.data() + k);
}

void bound_lanes(const CutPoints& points, std::size_t group, const CutCluster& cluster,
                 std::span<float, kCutLanes> bounds) {
  const CutPoints::Group& g = points.groups[group];
  if (is_point(cluster)) return bound_all_lanes<true>(points, g, cluster, bounds);
  bound_all_lanes<false>(points, g, cluster, bounds);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace myrialux {
HWY_EXPORT(bound_clusters);
HWY_EXPORT(bound_groups);
HWY_EXPORT(bound_lanes);
void bound_clusters(const CutPoints& points, std::span<const CutCluster> clusters, std::span<float> bounds) {
  MYRIALUX_ASSERT(clusters.size() == bounds.size() && points.least_distance_squared > 0);
  HWY_DYNAMIC_DISPATCH(bound_clusters)(points, clusters, bounds);
}
void bound_groups(const CutPoints& points, const CutCluster& cluster, std::span<float> bounds) {
  MYRIALUX_ASSERT(points.groups.size() == bounds.size() && points.least_distance_squared > 0);
  HWY_DYNAMIC_DISPATCH(bound_groups)(points, cluster, bounds);
}
void bound_lanes(const CutPoints& points, std::size_t group, const CutCluster& cluster,
                 std::span<float, kCutLanes> bounds) {
  MYRIALUX_ASSERT(group < points.groups.size() && points.least_distance_squared > 0);
  HWY_DYNAMIC_DISPATCH(bound_lanes)(points, group, cluster, bounds);
}
}  // namespace myrialux
#endif
