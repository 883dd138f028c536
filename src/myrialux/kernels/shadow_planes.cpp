// Triangles are the lanes where planes are made, rows where they are tried.
#include "myrialux/kernels/shadow_planes.h"

#include <bit>

#include "myrialux/kernels/targets.h"
// The rest of this file up to HWY_ONCE is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "myrialux/kernels/shadow_planes.cpp"
#include "hwy/foreach_target.h"
// Order matters: after foreach_target.h.
#include "myrialux/kernels/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {
namespace {

/// Of lengths and products that a plane's value is made of; single precision has 6e-8.
constexpr float kMargin = 1e-5f, kMarginOfCoordinates = 2e-6f;
/// Least sine of the angle between ray and triangle, and least distance from it to the light over that to the rows.
constexpr float kLeastSine = 1e-4f;

HWY_INLINE V3 cross(V3 a, V3 b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE V length(V3 a) { return hn::Sqrt(dot_unfused(a, a)); }
HWY_INLINE V3 corner(D d, const OccluderCorners& corners, int k, std::size_t t) {
  return {hn::Load(d, corners.v[k][0] + t), hn::Load(d, corners.v[k][1] + t), hn::Load(d, corners.v[k][2] + t)};
}

std::uint32_t planes_of(const OccluderCorners& corners, const KnownEnd& end, const RowsBound& rows,
                        ShadowPlanes& planes) {
  const D d;
  const V3 to = spread(d, end.p), centre = spread(d, rows.centre);
  const V zero = hn::Zero(d), one = hn::Set(d, 1), radius = hn::Set(d, rows.radius);
  const V margin = hn::Set(d, kMargin), coordinates = hn::Set(d, kMarginOfCoordinates * rows.largest);
  std::uint64_t near = 0;
  for (std::size_t t = 0; t < kOccluders; t += hn::Lanes(d)) {
    V3 v[3], edge[3], w[3];
    for (int k = 0; k < 3; ++k) v[k] = corner(d, corners, k, t);
    V longest_edge = zero, longest_w = one, ray = one;
    for (int k = 0; k < 3; ++k) {
      edge[k] = v[(k + 1) % 3] - v[k];
      longest_edge = hn::Max(longest_edge, length(edge[k]));
      w[k] = end.distant ? to : to - v[k];
    }
    if (!end.distant) {
      longest_w = hn::Max(hn::Max(length(w[0]), length(w[1])), length(w[2]));
      ray = hn::Add(length(to - centre), radius);
    }
    const V farthest = hn::Add(hn::Add(length(v[0] - centre), radius), longest_edge);  // from a row to a corner
    const V3 n = cross(edge[0], v[2] - v[0]);
    const V area = length(n), side = dot_unfused(n, w[0]);
    const V sign = hn::CopySign(one, hn::Neg(side));
    const Mask valid = hn::Gt(
        hn::Abs(side), hn::Mul(hn::Mul(area, hn::Set(d, kLeastSine)), end.distant ? one : hn::Add(ray, farthest)));
    const V inwards = hn::Mul(longest_edge, hn::Add(hn::Mul(margin, hn::Mul(hn::Add(ray, longest_w), farthest)),
                                                    hn::Mul(coordinates, longest_w)));
    Mask reaches = valid;
    const auto store = [&](int k, V3 normal, V3 point, V moved) {
      const V3 turned = normal * sign;
      hn::Store(turned.x, d, planes.n[k][0] + t);
      hn::Store(turned.y, d, planes.n[k][1] + t);
      hn::Store(turned.z, d, planes.n[k][2] + t);
      const V offset = hn::Neg(hn::Add(dot_unfused(turned, point), moved));
      hn::Store(offset, d, planes.d[k] + t);
      const V most = hn::Add(hn::Add(dot_unfused(turned, centre), offset), hn::Mul(length(turned), radius));
      reaches = hn::And(reaches, hn::Gt(most, zero));
    };
    for (int k = 0; k < 3; ++k) store(k, cross(edge[k], w[k]), v[k], inwards);
    const V own = hn::Mul(area, hn::Add(hn::Mul(margin, farthest), coordinates));
    store(3, n, v[0], hn::IfThenElse(valid, own, hn::Set(d, 1e30f)));
    near |= bits_of(reaches) << t;
  }
  return static_cast<std::uint32_t>(near);
}

std::uint64_t in_shadow(const float* const p[3], std::uint64_t rows, const ShadowPlanes& planes,
                        std::span<const std::uint8_t> order, std::span<std::uint32_t, kOccluders> counts) {
  const D d;
  std::uint64_t found = 0;
  for (std::size_t row = 0; row < kBlockRows; row += hn::Lanes(d)) {
    if (!has_rows(rows, row)) continue;
    const V x = hn::Load(d, p[0] + row), y = hn::Load(d, p[1] + row), z = hn::Load(d, p[2] + row);
    const std::uint64_t all = (rows >> row) & ((std::uint64_t{1} << hn::Lanes(d)) - 1);
    std::uint64_t left = all;
    for (const std::uint8_t t : order) {
      const auto value = [&](int k) {
        const V3 n{hn::Set(d, planes.n[k][0][t]), hn::Set(d, planes.n[k][1][t]), hn::Set(d, planes.n[k][2][t])};
        return hn::Add(dot_unfused(n, {x, y, z}), hn::Set(d, planes.d[k][t]));
      };
      const V least = hn::Min(hn::Min(value(0), value(1)), hn::Min(value(2), value(3)));
      const std::uint64_t blocked = bits_of(hn::Gt(least, hn::Zero(d))) & left;
      if (blocked == 0) continue;
      counts[t] += static_cast<std::uint32_t>(std::popcount(blocked));
      left &= ~blocked;
      if (left == 0) break;
    }
    found |= (all & ~left) << row;
  }
  return found;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace myrialux {

HWY_EXPORT(planes_of);
HWY_EXPORT(in_shadow);

std::uint32_t shadow_planes(const OccluderCorners& corners, const KnownEnd& end, const RowsBound& rows,
                            ShadowPlanes& planes) {
  return HWY_DYNAMIC_DISPATCH(planes_of)(corners, end, rows, planes);
}

std::uint64_t shadowed_rows(const float* const p[3], std::uint64_t rows, const ShadowPlanes& planes,
                            std::span<const std::uint8_t> order, std::span<std::uint32_t, kOccluders> counts) {
  return HWY_DYNAMIC_DISPATCH(in_shadow)(p, rows, planes, order, counts);
}

}  // namespace myrialux
#endif
