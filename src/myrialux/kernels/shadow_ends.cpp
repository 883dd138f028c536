// Offsets take the sign of a cosine, row by row; plain twin below.
#include "myrialux/kernels/shadow_ends.h"

#include <bit>
#include <cmath>
#include <limits>

#include "myrialux/kernels/targets.h"
// The rest of this file up to HWY_ONCE is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "myrialux/kernels/shadow_ends.cpp"
#include "hwy/foreach_target.h"
// Order matters: after foreach_target.h.
#include "myrialux/kernels/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE V3 load_at(D d, const float* const a[3], std::size_t row) {
  return {hn::Load(d, a[0] + row), hn::Load(d, a[1] + row), hn::Load(d, a[2] + row)};
}
HWY_INLINE void store_at(D d, V3 v, float* const a[3], std::size_t row) {
  hn::Store(v.x, d, a[0] + row), hn::Store(v.y, d, a[1] + row), hn::Store(v.z, d, a[2] + row);
}
/// p + ng * copysign(offset, cos)
HWY_INLINE V3 move_off(V3 p, V3 ng, V offset, V3 direction) {
  return p + ng * hn::CopySign(offset, dot_unfused(ng, direction));
}

/// Calls use(first row, from, to) for one vector of rows after the other.
template <SegmentEnd kEnd, class Use>
HWY_INLINE void visit_ends(const PacketRows& rows, const ShadowLight& light, const Use& use) {
  const D d;
  const V3 light_p = spread(d, light.p), light_ng = spread(d, light.ng);
  const V light_offset = hn::Set(d, light.offset);
  for (std::size_t row = 0; row < kPacketRows; row += hn::Lanes(d)) {
    const V3 p = load_at(d, rows.p, row), ng = load_at(d, rows.ng, row);
    const V3 w = kEnd == SegmentEnd::direction ? light_p : light_p - p;
    const V3 from = move_off(p, ng, hn::Load(d, rows.offset + row), w);
    if constexpr (kEnd == SegmentEnd::surface) {
      const V3 back{hn::Neg(w.x), hn::Neg(w.y), hn::Neg(w.z)};  // not -dot: a cosine of 0 must keep its sign
      use(row, from, move_off(light_p, light_ng, light_offset, back));
    } else {
      use(row, from, light_p);
    }
  }
}

template <SegmentEnd kEnd>
void ends_of(const PacketRows& rows, const ShadowLight& light, float* const from[3], float* const to[3]) {
  visit_ends<kEnd>(rows, light, [&](std::size_t row, V3 a, V3 b) {
    const D d;
    store_at(d, a, from, row), store_at(d, b, to, row);
  });
}

template <SegmentEnd kEnd>
void rays_of(const PacketRows& rows, const ShadowLight& light, float far, const PacketRays& rays) {
  visit_ends<kEnd>(rows, light, [&](std::size_t row, V3 a, V3 b) {
    const D d;
    store_at(d, a, rays.origin, row);
    store_at(d, kEnd == SegmentEnd::direction ? b : b - a, rays.direction, row);
    hn::Store(hn::Set(d, kEnd == SegmentEnd::direction ? std::numeric_limits<float>::infinity() : far), d,
              rays.far + row);
  });
}

void rays(const PacketRows& rows, const ShadowLight& light, float far, const PacketRays& to) {
  switch (light.end) {
    case SegmentEnd::surface:
      return rays_of<SegmentEnd::surface>(rows, light, far, to);
    case SegmentEnd::open:
      return rays_of<SegmentEnd::open>(rows, light, far, to);
    case SegmentEnd::direction:
      return rays_of<SegmentEnd::direction>(rows, light, far, to);
  }
}

void rays_to(const float* const from[3], std::uint32_t which, const KnownEnd& end, float far, const PacketRays& to) {
  const D d;
  const V3 p = spread(d, end.p);
  const V t = hn::Set(d, end.distant ? std::numeric_limits<float>::infinity() : far);
  std::size_t packet = 0;
  for (; which != 0; which &= which - 1, packet += to.stride) {
    const std::size_t first = kPacketRows * static_cast<std::size_t>(std::countr_zero(which));
    for (std::size_t row = 0; row < kPacketRows; row += hn::Lanes(d)) {
      const V3 a = load_at(d, from, first + row);
      store_at(d, a, to.origin, packet + row);
      store_at(d, end.distant ? p : p - a, to.direction, packet + row);
      hn::Store(t, d, to.far + packet + row);
    }
  }
}

void ends(const PacketRows& rows, const ShadowLight& light, float* const from[3], float* const to[3]) {
  switch (light.end) {
    case SegmentEnd::surface:
      return ends_of<SegmentEnd::surface>(rows, light, from, to);
    case SegmentEnd::open:
      return ends_of<SegmentEnd::open>(rows, light, from, to);
    case SegmentEnd::direction:
      return ends_of<SegmentEnd::direction>(rows, light, from, to);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace myrialux {

HWY_EXPORT(ends);
HWY_EXPORT(rays);
HWY_EXPORT(rays_to);

void shadow_ends(const PacketRows& rows, const ShadowLight& light, float* const from[3], float* const to[3]) {
  HWY_DYNAMIC_DISPATCH(ends)(rows, light, from, to);
}

void shadow_rays(const PacketRows& rows, const ShadowLight& light, float far, const PacketRays& to) {
  HWY_DYNAMIC_DISPATCH(rays)(rows, light, far, to);
}

void shadow_rays_to(const float* const from[3], std::uint32_t which, const KnownEnd& end, float far,
                    const PacketRays& to) {
  HWY_DYNAMIC_DISPATCH(rays_to)(from, which, end, far, to);
}

void shadow_ends_plain(const PacketRows& rows, const ShadowLight& light, float* const from[3], float* const to[3]) {
  for (std::size_t row = 0; row < kPacketRows; ++row) {
    float w[3], cos_row = 0, cos_light = 0;
    for (int k = 0; k < 3; ++k) {
      w[k] = light.end == SegmentEnd::direction ? light.p[k] : light.p[k] - rows.p[k][row];
      const float at_row = rows.ng[k][row] * w[k], at_light = light.ng[k] * -w[k];
      cos_row = k == 0 ? at_row : cos_row + at_row;
      cos_light = k == 0 ? at_light : cos_light + at_light;
    }
    for (int k = 0; k < 3; ++k) {
      from[k][row] = rows.p[k][row] + rows.ng[k][row] * std::copysign(rows.offset[row], cos_row);
      to[k][row] = light.end == SegmentEnd::surface ? light.p[k] + light.ng[k] * std::copysign(light.offset, cos_light)
                                                    : light.p[k];
    }
  }
}

void shadow_rays_plain(const PacketRows& rows, const ShadowLight& light, float far, const PacketRays& rays) {
  const bool distant = light.end == SegmentEnd::direction;
  shadow_ends_plain(rows, light, rays.origin, rays.direction);
  for (std::size_t row = 0; row < kPacketRows; ++row) {
    for (int k = 0; k < 3 && !distant; ++k) rays.direction[k][row] -= rays.origin[k][row];
    rays.far[row] = distant ? std::numeric_limits<float>::infinity() : far;
  }
}

}  // namespace myrialux
#endif
