// Three-vectors of vectors: a point, direction or colour in each lane. Included once for each instruction set.
#include "myrialux/kernels/shade_block.h"
#include "myrialux/kernels/targets.h"
// Order matters: targets.h before Highway.
#include "hwy/highway.h"

#if defined(MYRIALUX_KERNELS_VEC3_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MYRIALUX_KERNELS_VEC3_INL
#undef MYRIALUX_KERNELS_VEC3_INL
#else
#define MYRIALUX_KERNELS_VEC3_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
using Mask = hn::Mask<D>;

struct V3 {
  V x, y, z;
};

HWY_INLINE V3 load(D d, const BlockFloats* a, std::size_t row) {
  return {hn::Load(d, a[0] + row), hn::Load(d, a[1] + row), hn::Load(d, a[2] + row)};
}
HWY_INLINE void store(D d, V3 v, BlockFloats* a, std::size_t row) {
  hn::Store(v.x, d, a[0] + row), hn::Store(v.y, d, a[1] + row), hn::Store(v.z, d, a[2] + row);
}
HWY_INLINE V3 spread(D d, const float* a) { return {hn::Set(d, a[0]), hn::Set(d, a[1]), hn::Set(d, a[2])}; }

HWY_INLINE V3 operator+(V3 a, V3 b) { return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)}; }
HWY_INLINE V3 operator-(V3 a, V3 b) { return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)}; }
HWY_INLINE V3 operator*(V3 a, V3 b) { return {hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)}; }
HWY_INLINE V3 operator*(V3 a, V s) { return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)}; }
HWY_INLINE V dot(V3 a, V3 b) { return hn::MulAdd(a.z, b.z, hn::MulAdd(a.y, b.y, hn::Mul(a.x, b.x))); }
/// The same bits as the scalar dot product, for tests of the sign: nothing fused.
HWY_INLINE V dot_unfused(V3 a, V3 b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
/// sum + s * a
HWY_INLINE V3 add_scaled(V3 sum, V s, V3 a) {
  return {hn::MulAdd(s, a.x, sum.x), hn::MulAdd(s, a.y, sum.y), hn::MulAdd(s, a.z, sum.z)};
}
/// Lanes of a vector that starts at row `row`.
HWY_INLINE Mask mask_of(D d, std::uint64_t bits, std::size_t row) {
  const std::uint64_t of_row = bits >> row;
  return hn::LoadMaskBits(d, reinterpret_cast<const std::uint8_t*>(&of_row));
}
/// The lanes as bits, lowest first.
HWY_INLINE std::uint64_t bits_of(Mask mask) {
  std::uint64_t bits = 0;
  hn::StoreMaskBits(D(), mask, reinterpret_cast<std::uint8_t*>(&bits));
  return bits;
}
/// Whether any row of the vector that starts at `row` is set.
HWY_INLINE bool has_rows(std::uint64_t bits, std::size_t row) {
  return (bits >> row & ((std::uint64_t{1} << hn::Lanes(D())) - 1)) != 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();
#endif
