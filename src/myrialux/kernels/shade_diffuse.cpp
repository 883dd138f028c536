// Diffuse rows under diffuse lights: rows in lanes, columns in the inner loop, sums in registers. [wang20, 4.6]
#include "myrialux/kernels/shade_diffuse.h"

#include <algorithm>
#include <cmath>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/targets.h"
// The rest of this file up to HWY_ONCE is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "myrialux/kernels/shade_diffuse.cpp"
#include "hwy/foreach_target.h"
// Order matters: after foreach_target.h.
#include "myrialux/kernels/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {
namespace {

/// One vector of rows against all columns: sums stay in registers, lights are broadcast.
template <DiffuseLight kKind, bool kBumpy, bool kTrack>
HWY_INLINE void shade_rows(const RowBlock& rows, const DiffuseRun& run, std::size_t row, BlockSums& sums) {
  const D d;
  const V3 p = load(d, rows.p, row), n = load(d, rows.n, row), ng = load(d, rows.ng, row);
  V3 sum = load(d, sums.rgb, row), removed = load(d, sums.removed, row);
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f), least = hn::Set(d, kLeastSquaredDistance);
  const V bound = hn::Set(d, inverse_squared_clamp(run.clamp_distance));
  for (std::size_t c = 0; c < run.lights.size(); ++c) {
    if (!has_rows(run.visible[c], row)) continue;
    const ColumnLight& light = run.lights[c];
    Mask mask = mask_of(d, run.visible[c], row);
    const V3 light_n = spread(d, light.n), rgb = spread(d, light.rgb);
    if constexpr (kKind == DiffuseLight::directional) {
      if constexpr (kBumpy) mask = hn::And(mask, hn::Lt(dot_unfused(light_n, ng), zero));
      const V cos_i = hn::Max(hn::Neg(dot(n, light_n)), zero);
      sum = add_scaled(sum, hn::IfThenElseZero(mask, cos_i), rgb);
    } else {
      // Cosines times distance: the distances they are still to be divided by make up the other 1 / d^2.
      const V3 to_light = spread(d, light.p) - p;
      const V inverse = hn::Div(one, hn::Max(dot(to_light, to_light), least));
      const V cos_i = hn::Max(dot(n, to_light), zero);
      if constexpr (kBumpy) mask = hn::And(mask, hn::Gt(dot_unfused(to_light, ng), zero));
      V pair;
      if constexpr (kKind == DiffuseLight::oriented) {
        if constexpr (kBumpy) mask = hn::And(mask, hn::Lt(dot_unfused(to_light, spread(d, light.ng)), zero));
        pair = hn::Mul(hn::Mul(cos_i, inverse), hn::Max(hn::Neg(dot(light_n, to_light)), zero));
      } else {
        pair = hn::Mul(cos_i, hn::Sqrt(inverse));
      }
      const V clamped = hn::Min(inverse, bound);
      sum = add_scaled(sum, hn::IfThenElseZero(mask, hn::Mul(pair, clamped)), rgb);
      if constexpr (kTrack)
        removed = add_scaled(removed, hn::IfThenElseZero(mask, hn::Mul(pair, hn::Sub(inverse, clamped))), rgb);
    }
  }
  store(d, sum, sums.rgb, row);
  if constexpr (kTrack) store(d, removed, sums.removed, row);
}

template <DiffuseLight kKind, bool kBumpy>
void shade_kind(const RowBlock& rows, const DiffuseRun& run, BlockSums& sums) {
  const bool clamps = kKind != DiffuseLight::directional && run.clamp_distance > 0;
  for (std::size_t row = 0; row < kBlockRows; row += hn::Lanes(D())) {
    if (clamps && (run.tracked >> row & 1))
      shade_rows<kKind, kBumpy, true>(rows, run, row, sums);
    else
      shade_rows<kKind, kBumpy, false>(rows, run, row, sums);
  }
}

template <bool kBumpy>
void shade_any(const RowBlock& rows, const DiffuseRun& run, BlockSums& sums) {
  switch (run.kind) {
    case DiffuseLight::oriented:
      return shade_kind<DiffuseLight::oriented, kBumpy>(rows, run, sums);
    case DiffuseLight::point:
      return shade_kind<DiffuseLight::point, kBumpy>(rows, run, sums);
    case DiffuseLight::directional:
      return shade_kind<DiffuseLight::directional, kBumpy>(rows, run, sums);
  }
}

void shade(const RowBlock& rows, const DiffuseRun& run, BlockSums& sums) {
  run.bumpy ? shade_any<true>(rows, run, sums) : shade_any<false>(rows, run, sums);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace myrialux {

HWY_EXPORT(shade);

void shade_diffuse(const RowBlock& rows, const DiffuseRun& run, BlockSums& sums) {
  MYRIALUX_ASSERT(run.lights.size() == run.visible.size());
  HWY_DYNAMIC_DISPATCH(shade)(rows, run, sums);
}

namespace {

float dot(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Factor of the colour of light c for one row; `removed`: what clamping took from it.
float pair_factor(DiffuseLight kind, const ColumnLight& light, const float* p, const float* n, const float* ng,
                  float bound, float& removed) {
  removed = 0;
  if (kind == DiffuseLight::directional) return dot(light.n, ng) < 0 ? std::max(-dot(n, light.n), 0.0f) : 0.0f;
  const float to_light[3] = {light.p[0] - p[0], light.p[1] - p[1], light.p[2] - p[2]};
  const float cos_i = std::max(dot(n, to_light), 0.0f);
  if (dot(to_light, ng) <= 0) return 0;
  const float inverse = 1 / std::max(dot(to_light, to_light), kLeastSquaredDistance);
  float pair = cos_i * std::sqrt(inverse);
  if (kind == DiffuseLight::oriented) {
    if (dot(to_light, light.ng) >= 0) return 0;
    pair = cos_i * inverse * std::max(-dot(light.n, to_light), 0.0f);
  }
  const float clamped = std::min(inverse, bound);
  removed = pair * (inverse - clamped);
  return pair * clamped;
}

}  // namespace

void shade_diffuse_plain(const RowBlock& rows, const DiffuseRun& run, BlockSums& sums) {
  MYRIALUX_ASSERT(run.lights.size() == run.visible.size());
  const float bound = inverse_squared_clamp(run.clamp_distance);
  for (std::size_t row = 0; row < kBlockRows; ++row) {
    const float p[3] = {rows.p[0][row], rows.p[1][row], rows.p[2][row]};
    const float n[3] = {rows.n[0][row], rows.n[1][row], rows.n[2][row]};
    const float ng[3] = {rows.ng[0][row], rows.ng[1][row], rows.ng[2][row]};
    const bool tracked = run.clamp_distance > 0 && (run.tracked >> row & 1);
    for (std::size_t c = 0; c < run.lights.size(); ++c) {
      if (!(run.visible[c] >> row & 1)) continue;
      float removed = 0;
      const float factor = pair_factor(run.kind, run.lights[c], p, n, ng, bound, removed);
      for (int k = 0; k < 3; ++k) {
        sums.rgb[k][row] += factor * run.lights[c].rgb[k];
        if (tracked) sums.removed[k][row] += removed * run.lights[c].rgb[k];
      }
    }
  }
}

}  // namespace myrialux
#endif
