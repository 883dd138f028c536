// Lanes are blocks. Plain twin below.
#include "myrialux/kernels/block_bounds.h"

#include <algorithm>
#include <cmath>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/targets.h"
// The rest of this file up to HWY_ONCE is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "myrialux/kernels/block_bounds.cpp"
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

HWY_INLINE V set(float x) { return hn::Set(Tag(), x); }
HWY_INLINE V load(const float* x) { return hn::Load(Tag(), x); }

/// Largest cosine to any direction within a cone, given the largest to its axis.
HWY_INLINE V widen(V cosine, V cone_cos, V cone_sin) {
  const V sine = hn::Sqrt(hn::Max(hn::Sub(set(1), hn::Mul(cosine, cosine)), set(0)));
  const V wide = hn::Add(hn::Mul(cosine, cone_cos), hn::Mul(sine, cone_sin));
  return hn::IfThenElse(hn::Ge(cosine, cone_cos), set(1), wide);
}

HWY_INLINE V shape(V cosine, V inverse_alpha2) {
  const V one = set(1);
  const V ratio = hn::Div(hn::Sub(one, cosine), hn::Max(hn::Add(one, cosine), set(1e-6f)));
  const V t = hn::Min(hn::Max(ratio, set(0)), set(1e6f)), x = hn::Mul(t, inverse_alpha2);
  const V inner = hn::Add(one, hn::Mul(x, set(0.5f)));
  return hn::Div(hn::Mul(hn::Add(one, t), hn::Add(one, t)), hn::Add(one, hn::Mul(x, inner)));
}

/// Where the light is from the blocks.
struct Ways {
  V w[3];       ///< unit, from the middle to the light
  V cos, sin;   ///< of the angle at which the light sees the block's radius
  V distance2;  ///< least squared distance, 1 for distant lights
};

HWY_INLINE Ways ways_to(const BlockCones& blocks, const BlockCones::Group& g, std::size_t k, const CutCluster& c) {
  Ways r;
  if (c.distant) {
    for (int a = 0; a < 3; ++a) r.w[a] = set(c.lower[a]);
    r.cos = set(1), r.sin = set(0), r.distance2 = set(1);
    return r;
  }
  V squared = set(0);
  for (int a = 0; a < 3; ++a) {
    r.w[a] = hn::Sub(set(c.lower[a]), load(g.p[a] + k));
    squared = hn::Add(squared, hn::Mul(r.w[a], r.w[a]));
  }
  const V length = hn::Sqrt(hn::Max(squared, set(1e-30f))), radius = load(g.radius + k);
  for (int a = 0; a < 3; ++a) r.w[a] = hn::Div(r.w[a], length);
  r.sin = hn::Min(hn::Div(radius, length), set(1));
  r.cos = hn::Sqrt(hn::Sub(set(1), hn::Mul(r.sin, r.sin)));
  const V least = hn::Max(hn::Sub(length, radius), set(0));
  r.distance2 = hn::Max(hn::Mul(least, least), set(blocks.least_distance_squared));
  return r;
}

HWY_INLINE V largest_cosine(const Ways& r, const ConeLanes& cone, std::size_t k) {
  V cosine = set(0);
  for (int a = 0; a < 3; ++a) cosine = hn::Add(cosine, hn::Mul(load(cone.axis[a] + k), r.w[a]));
  return widen(widen(cosine, load(cone.cos + k), load(cone.sin + k)), r.cos, r.sin);
}

/// The same for an axis of the light.
HWY_INLINE V largest_cosine(const Ways& r, const float (&axis)[3], float cone_cos, float cone_sin) {
  V cosine = set(0);
  for (int a = 0; a < 3; ++a) cosine = hn::Add(cosine, hn::Mul(set(axis[a]), r.w[a]));
  return widen(widen(cosine, set(cone_cos), set(cone_sin)), r.cos, r.sin);
}

HWY_INLINE V receiver_bound(const BlockCones& blocks, const BlockCones::Group& g, std::size_t k, const Ways& r) {
  const V cosine = hn::Max(largest_cosine(r, g.normal, k), set(0));
  const V bound = hn::Mul(load(g.diffuse + k), cosine);
  if (!blocks.any_gloss) return bound;
  const V lobe = shape(largest_cosine(r, g.mirror, k), load(g.inverse_alpha2 + k));
  const V gloss = hn::IfThenElseZero(hn::Gt(cosine, set(0)), hn::Mul(load(g.gloss + k), lobe));
  return hn::Add(hn::Add(bound, gloss), load(g.any + k));
}

HWY_INLINE V light_bound(const CutCluster& c, const Ways& r) {
  if (!c.has_cone) return set(c.diffuse);
  const V cosine = hn::Max(largest_cosine(r, c.back.axis, c.cone_cos, c.cone_sin), set(0));
  const V bound = hn::Mul(set(c.diffuse), cosine);
  if (!(c.gloss > 0 || c.any > 0)) return bound;
  const V lobe = shape(largest_cosine(r, c.mirror_back.axis, c.mirror_cos, c.mirror_sin), set(c.inverse_alpha2));
  const V gloss = hn::IfThenElseZero(hn::Gt(cosine, set(0)), hn::Mul(set(c.gloss), lobe));
  return hn::Add(hn::Add(bound, gloss), set(c.any));
}

void bound_all(const BlockCones& blocks, const CutCluster& light, std::span<float> bounds) {
  for (std::size_t g = 0; g < blocks.groups.size(); ++g)
    for (std::size_t k = 0; k < kCutLanes; k += hn::Lanes(Tag())) {
      const BlockCones::Group& group = blocks.groups[g];
      const Ways r = ways_to(blocks, group, k, light);
      const V bound = hn::Div(hn::Mul(receiver_bound(blocks, group, k, r), light_bound(light, r)), r.distance2);
      hn::StoreU(bound, Tag(), bounds.data() + g * kCutLanes + k);
    }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace myrialux {

HWY_EXPORT(bound_all);

void bound_blocks(const BlockCones& blocks, const CutCluster& light, std::span<float> bounds) {
  MYRIALUX_ASSERT(bounds.size() >= blocks.groups.size() * kCutLanes);
  HWY_DYNAMIC_DISPATCH(bound_all)(blocks, light, bounds);
}

namespace {

float widen_plain(float cosine, float cone_cos, float cone_sin) {
  const float sine = std::sqrt(std::max(1 - cosine * cosine, 0.0f));
  return cosine >= cone_cos ? 1 : cosine * cone_cos + sine * cone_sin;
}

float shape_plain(float cosine, float inverse_alpha2) {
  const float ratio = (1 - cosine) / std::max(1 + cosine, 1e-6f);
  const float t = std::min(std::max(ratio, 0.0f), 1e6f), x = t * inverse_alpha2;
  return (1 + t) * (1 + t) / (1 + x * (1 + x * 0.5f));
}

/// See Ways.
struct Way {
  float w[3], cos, sin, distance2;
};

Way way_to(const BlockCones& blocks, const BlockCones::Group& g, std::size_t k, const CutCluster& c) {
  Way r{{c.lower[0], c.lower[1], c.lower[2]}, 1, 0, 1};
  if (c.distant) return r;
  float squared = 0;
  for (int a = 0; a < 3; ++a) r.w[a] = c.lower[a] - g.p[a][k], squared = squared + r.w[a] * r.w[a];
  const float length = std::sqrt(std::max(squared, 1e-30f)), radius = g.radius[k];
  for (float& x : r.w) x = x / length;
  r.sin = std::min(radius / length, 1.0f), r.cos = std::sqrt(1 - r.sin * r.sin);
  const float least = std::max(length - radius, 0.0f);
  r.distance2 = std::max(least * least, blocks.least_distance_squared);
  return r;
}

float largest_cosine_plain(const Way& r, float x, float y, float z, float cone_cos, float cone_sin) {
  const float cosine = 0 + x * r.w[0] + y * r.w[1] + z * r.w[2];
  return widen_plain(widen_plain(cosine, cone_cos, cone_sin), r.cos, r.sin);
}

float largest_cosine_plain(const Way& r, const ConeLanes& c, std::size_t k) {
  return largest_cosine_plain(r, c.axis[0][k], c.axis[1][k], c.axis[2][k], c.cos[k], c.sin[k]);
}

float largest_cosine_plain(const Way& r, const float (&axis)[3], float cone_cos, float cone_sin) {
  return largest_cosine_plain(r, axis[0], axis[1], axis[2], cone_cos, cone_sin);
}

float receiver_bound_plain(const BlockCones& blocks, const BlockCones::Group& g, std::size_t k, const Way& r) {
  const float cosine = std::max(largest_cosine_plain(r, g.normal, k), 0.0f);
  const float bound = g.diffuse[k] * cosine;
  if (!blocks.any_gloss) return bound;
  const float lobe = shape_plain(largest_cosine_plain(r, g.mirror, k), g.inverse_alpha2[k]);
  return bound + (cosine > 0 ? g.gloss[k] * lobe : 0.0f) + g.any[k];
}

float light_bound_plain(const CutCluster& c, const Way& r) {
  if (!c.has_cone) return c.diffuse;
  const float cosine = std::max(largest_cosine_plain(r, c.back.axis, c.cone_cos, c.cone_sin), 0.0f);
  const float bound = c.diffuse * cosine;
  if (!(c.gloss > 0 || c.any > 0)) return bound;
  const float lobe =
      shape_plain(largest_cosine_plain(r, c.mirror_back.axis, c.mirror_cos, c.mirror_sin), c.inverse_alpha2);
  return bound + (cosine > 0 ? c.gloss * lobe : 0.0f) + c.any;
}

}  // namespace

void bound_blocks_plain(const BlockCones& blocks, const CutCluster& light, std::span<float> bounds) {
  for (std::size_t i = 0; i < blocks.groups.size() * kCutLanes; ++i) {
    const BlockCones::Group& g = blocks.groups[i / kCutLanes];
    const Way r = way_to(blocks, g, i % kCutLanes, light);
    bounds[i] = receiver_bound_plain(blocks, g, i % kCutLanes, r) * light_bound_plain(light, r) / r.distance2;
  }
}

}  // namespace myrialux
#endif
