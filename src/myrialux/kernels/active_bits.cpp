// Signs of up to four cosines a row, packed into bits; plain twin below.
#include "myrialux/kernels/active_bits.h"

#include "myrialux/base/assert.h"
#include "myrialux/kernels/targets.h"
// The rest of this file up to HWY_ONCE is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "myrialux/kernels/active_bits.cpp"
#include "hwy/foreach_target.h"
// Order matters: after foreach_target.h.
#include "myrialux/kernels/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {
namespace {

/// Lanes whose rows the light's own sides let be lit. @param w from the rows to the light, so that its front sees them
/// from the other way. @param flat n == ng
template <LitSides kSides>
HWY_INLINE Mask lit_lanes(const V3 w, const V3 n, const V3 ng, bool flat) {
  const V zero = hn::Zero(D()), from_ng = dot_unfused(ng, w), from_n = flat ? from_ng : dot_unfused(n, w);
  const Mask front = hn::And(hn::Lt(from_ng, zero), hn::Lt(from_n, zero));
  if constexpr (kSides == LitSides::front) return front;
  return hn::Or(front, hn::And(hn::Gt(from_ng, zero), hn::Gt(from_n, zero)));
}

/// Lanes whose rows have the light on one side of both normals.
HWY_INLINE Mask facing_lanes(const RowBlock& rows, std::size_t row, std::uint64_t both_sides, const V3 w) {
  const D d;
  const V zero = hn::Zero(d);
  const V at_ng = dot_unfused(load(d, rows.ng, row), w), at_n = dot_unfused(load(d, rows.n, row), w);
  const Mask front = hn::And(hn::Gt(at_ng, zero), hn::Gt(at_n, zero));
  if (!has_rows(both_sides, row)) return front;
  return hn::Or(front, hn::And(hn::And(hn::Lt(at_ng, zero), hn::Lt(at_n, zero)), mask_of(d, both_sides, row)));
}

template <bool kDistant, LitSides kSides>
HWY_INLINE std::uint64_t active_word(const RowBlock& rows, std::uint64_t both_sides, const ActivityLight& light,
                                     bool flat) {
  const D d;
  const V3 to = spread(d, light.to);
  std::uint64_t word = 0;
  for (std::size_t row = 0; row < kBlockRows; row += hn::Lanes(d)) {
    const V3 w = kDistant ? to : to - load(d, rows.p, row);
    Mask active;
    if constexpr (kSides == LitSides::all) {
      active = facing_lanes(rows, row, both_sides, w);
    } else {
      // Neighbouring rows mostly lie behind a light together: then their own normals need not be looked at.
      const Mask lit = lit_lanes<kSides>(w, spread(d, light.n), spread(d, light.ng), flat);
      if (hn::AllFalse(d, lit)) continue;
      active = hn::And(lit, facing_lanes(rows, row, both_sides, w));
    }
    word |= bits_of(active) << row;
  }
  return word;
}

template <bool kDistant, LitSides kSides>
void active_words(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides,
                  const ActivityLight& light, std::span<std::uint64_t> active) {
  const bool flat = light.n[0] == light.ng[0] && light.n[1] == light.ng[1] && light.n[2] == light.ng[2];
  for (std::size_t b = 0; b < blocks.size(); ++b)
    active[b] = active_word<kDistant, kSides>(blocks[b], both_sides[b], light, flat);
}

template <bool kDistant>
void active_any(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides, const ActivityLight& light,
                std::span<std::uint64_t> active) {
  switch (light.sides) {
    case LitSides::all:
      return active_words<kDistant, LitSides::all>(blocks, both_sides, light, active);
    case LitSides::front:
      return active_words<kDistant, LitSides::front>(blocks, both_sides, light, active);
    case LitSides::front_and_back:
      return active_words<kDistant, LitSides::front_and_back>(blocks, both_sides, light, active);
  }
}

void active(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides, const ActivityLight& light,
            std::span<std::uint64_t> words) {
  light.distant ? active_any<true>(blocks, both_sides, light, words)
                : active_any<false>(blocks, both_sides, light, words);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace myrialux {

HWY_EXPORT(active);

void active_bits(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides,
                 const ActivityLight& light, std::span<std::uint64_t> active) {
  MYRIALUX_ASSERT(both_sides.size() == blocks.size() && active.size() == blocks.size());
  HWY_DYNAMIC_DISPATCH(active)(blocks, both_sides, light, active);
}

namespace {

float dot(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

bool is_active(const RowBlock& rows, std::size_t row, bool both_sides, const ActivityLight& light) {
  float w[3], n[3], ng[3];
  for (int k = 0; k < 3; ++k) {
    w[k] = light.distant ? light.to[k] : light.to[k] - rows.p[k][row];
    n[k] = rows.n[k][row], ng[k] = rows.ng[k][row];
  }
  const float at_ng = dot(ng, w), at_n = dot(n, w);
  if (!(at_ng > 0 && at_n > 0) && !(both_sides && at_ng < 0 && at_n < 0)) return false;
  if (light.sides == LitSides::all) return true;
  const float from_ng = dot(light.ng, w), from_n = dot(light.n, w);
  if (from_ng < 0 && from_n < 0) return true;
  return light.sides == LitSides::front_and_back && from_ng > 0 && from_n > 0;
}

}  // namespace

void active_bits_plain(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides,
                       const ActivityLight& light, std::span<std::uint64_t> active) {
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    active[b] = 0;
    for (std::size_t row = 0; row < kBlockRows; ++row)
      if (is_active(blocks[b], row, both_sides[b] >> row & 1, light)) active[b] |= std::uint64_t{1} << row;
  }
}

}  // namespace myrialux
#endif
