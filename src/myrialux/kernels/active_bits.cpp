// Signs of up to four cosines a row, packed into bits; plain twin below.
#include "myrialux/kernels/active_bits.h"

#include <algorithm>
#include <cstring>

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

/// kFlat: shading and geometric normals of all rows are the same; kFlatLight: the light's are.
template <bool kDistant, LitSides kSides, bool kFlat, bool kFlatLight>
HWY_INLINE std::uint64_t active_word(const RowBlock& rows, std::uint64_t both_sides, const ActivityLight& light) {
  const D d;
  const V zero = hn::Zero(d);
  const V3 to = spread(d, light.to), light_n = spread(d, light.n), light_ng = spread(d, light.ng);
  std::uint64_t word = 0;
  for (std::size_t row = 0; row < kBlockRows; row += hn::Lanes(d)) {
    const V3 w = kDistant ? to : to - load(d, rows.p, row);
    const V at_ng = dot_unfused(load(d, rows.ng, row), w);
    const V at_n = kFlat ? at_ng : dot_unfused(load(d, rows.n, row), w);
    const Mask behind = hn::And(hn::And(hn::Lt(at_ng, zero), hn::Lt(at_n, zero)), mask_of(d, both_sides, row));
    Mask active = hn::Or(hn::And(hn::Gt(at_ng, zero), hn::Gt(at_n, zero)), behind);
    if constexpr (kSides != LitSides::all) {  // w points to the light, so its front sees it from the other way
      const V from_ng = dot_unfused(light_ng, w), from_n = kFlatLight ? from_ng : dot_unfused(light_n, w);
      Mask lit = hn::And(hn::Lt(from_ng, zero), hn::Lt(from_n, zero));
      if constexpr (kSides == LitSides::front_and_back)
        lit = hn::Or(lit, hn::And(hn::Gt(from_ng, zero), hn::Gt(from_n, zero)));
      active = hn::And(active, lit);
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, active, bits);
    word |= (std::uint64_t{bits[0]} | std::uint64_t{bits[1]} << 8) << row;
  }
  return word;
}

/// Blocks that are held against one light after the other: their 9 KiB stay in the first cache.
constexpr std::size_t kTile = 4;

struct Tile {
  std::span<const RowBlock> blocks;
  std::span<const std::uint64_t> both_sides;
  bool flat = false;
};

template <bool kDistant, LitSides kSides, bool kFlat, bool kFlatLight>
HWY_INLINE void active_tile(const Tile& tile, const ActivityLight& light, std::uint64_t* active) {
  for (std::size_t b = 0; b < tile.blocks.size(); ++b)
    active[b] = active_word<kDistant, kSides, kFlat, kFlatLight>(tile.blocks[b], tile.both_sides[b], light);
}

template <bool kDistant, LitSides kSides>
void active_of_light(const Tile& tile, const ActivityLight& light, std::uint64_t* active) {
  const bool flat_light = std::memcmp(light.n, light.ng, sizeof light.n) == 0;
  if (tile.flat)
    flat_light ? active_tile<kDistant, kSides, true, true>(tile, light, active)
               : active_tile<kDistant, kSides, true, false>(tile, light, active);
  else
    flat_light ? active_tile<kDistant, kSides, false, true>(tile, light, active)
               : active_tile<kDistant, kSides, false, false>(tile, light, active);
}

template <bool kDistant>
void active_any(const Tile& tile, const ActivityLight& light, std::uint64_t* active) {
  switch (light.sides) {
    case LitSides::all:
      return active_of_light<kDistant, LitSides::all>(tile, light, active);
    case LitSides::front:
      return active_of_light<kDistant, LitSides::front>(tile, light, active);
    case LitSides::front_and_back:
      return active_of_light<kDistant, LitSides::front_and_back>(tile, light, active);
  }
}

bool is_flat(std::span<const RowBlock> blocks) {
  return std::all_of(blocks.begin(), blocks.end(),
                     [](const RowBlock& b) { return std::memcmp(b.n, b.ng, sizeof b.n) == 0; });
}

void active(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides,
            std::span<const ActivityLight> lights, std::span<std::uint64_t> words) {
  for (std::size_t first = 0; first < blocks.size(); first += kTile) {
    const std::size_t n = std::min(kTile, blocks.size() - first);
    const std::span<const RowBlock> some = blocks.subspan(first, n);
    const Tile tile{some, both_sides.subspan(first, n), is_flat(some)};
    for (std::size_t j = 0; j < lights.size(); ++j) {
      std::uint64_t* const to = words.data() + j * blocks.size() + first;
      lights[j].distant ? active_any<true>(tile, lights[j], to) : active_any<false>(tile, lights[j], to);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace myrialux {

HWY_EXPORT(active);

void active_bits(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides,
                 std::span<const ActivityLight> lights, std::span<std::uint64_t> active) {
  MYRIALUX_ASSERT(both_sides.size() == blocks.size() && active.size() == lights.size() * blocks.size());
  HWY_DYNAMIC_DISPATCH(active)(blocks, both_sides, lights, active);
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
                       std::span<const ActivityLight> lights, std::span<std::uint64_t> active) {
  for (std::size_t j = 0; j < lights.size(); ++j)
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      std::uint64_t& word = active[j * blocks.size() + b] = 0;
      for (std::size_t row = 0; row < kBlockRows; ++row)
        if (is_active(blocks[b], row, both_sides[b] >> row & 1, lights[j])) word |= std::uint64_t{1} << row;
    }
}

}  // namespace myrialux
#endif
