// Signs of up to four cosines a row, packed into bits; plain twin below.
#include "myrialux/kernels/active_bits.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/targets.h"

#ifndef MYRIALUX_KERNELS_BLOCK_BOUNDS
#define MYRIALUX_KERNELS_BLOCK_BOUNDS
namespace myrialux {
namespace {

/// Of 16 blocks of rows, one a lane: what the cosines of all their rows have in common. Lanes of no rows are 0.
constexpr std::size_t kBoundBlocks = 16;
struct alignas(64) BlockBounds {
  float centre[3][kBoundBlocks], radius[kBoundBlocks];  ///< of a sphere around the positions
  float axis[3][kBoundBlocks], spread[kBoundBlocks];    ///< unit; normals differ from it by no more
  float depth[kBoundBlocks];                            ///< distance of positions along the axis from the centre
  float two_sided[kBoundBlocks];                        ///< 0: all rows see their front only
};

}  // namespace
}  // namespace myrialux
#endif
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
    Mask lit = hn::Eq(zero, zero);
    if constexpr (kSides != LitSides::all) {  // w points to the light, so its front sees it from the other way
      const V from_ng = dot_unfused(light_ng, w), from_n = kFlatLight ? from_ng : dot_unfused(light_n, w);
      lit = hn::And(hn::Lt(from_ng, zero), hn::Lt(from_n, zero));
      if constexpr (kSides == LitSides::front_and_back)
        lit = hn::Or(lit, hn::And(hn::Gt(from_ng, zero), hn::Gt(from_n, zero)));
      // Neighbouring rows mostly lie behind a light together: then their own normals need not be looked at.
      if (hn::AllFalse(d, lit)) continue;
    }
    const V at_ng = dot_unfused(load(d, rows.ng, row), w);
    const V at_n = kFlat ? at_ng : dot_unfused(load(d, rows.n, row), w);
    const Mask behind = hn::And(hn::And(hn::Lt(at_ng, zero), hn::Lt(at_n, zero)), mask_of(d, both_sides, row));
    const Mask active = hn::And(lit, hn::Or(hn::And(hn::Gt(at_ng, zero), hn::Gt(at_n, zero)), behind));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, active, bits);
    word |= (std::uint64_t{bits[0]} | std::uint64_t{bits[1]} << 8) << row;
  }
  return word;
}

/// Which of 16 blocks are active as a whole, or not at all; the others must be looked at row by row. By bounds of the
/// cosines, widened by more than rounding can do.
struct Decided {
  std::uint32_t all = 0, none = 0;
};

template <bool kDistant>
HWY_INLINE Decided decide(const BlockBounds& bounds, const ActivityLight& light) {
  constexpr float kRounding = 1e-5f;
  const D d;
  const V zero = hn::Zero(d);
  const V3 to = spread(d, light.to), light_n = spread(d, light.n), light_ng = spread(d, light.ng);
  const bool sided = light.sides != LitSides::all;
  const V size_n = hn::Sqrt(dot(light_n, light_n)), size_ng = hn::Sqrt(dot(light_ng, light_ng));
  Decided decided;
  for (std::size_t b = 0; b < kBoundBlocks; b += hn::Lanes(d)) {
    const auto at = [&](const float* a) { return hn::Load(d, a + b); };
    const V3 axis{at(bounds.axis[0]), at(bounds.axis[1]), at(bounds.axis[2])};
    const V3 centre{at(bounds.centre[0]), at(bounds.centre[1]), at(bounds.centre[2])};
    const V3 w = kDistant ? to : to - centre;
    const V length = hn::Sqrt(dot(w, w)), radius = kDistant ? zero : at(bounds.radius);
    const V far = hn::Add(length, radius), rounding = hn::Mul(far, hn::Set(d, kRounding));
    const V of_rows = hn::MulAdd(at(bounds.spread), far, kDistant ? rounding : hn::Add(at(bounds.depth), rounding));
    const V cos = dot(axis, w);
    Mask all = hn::Gt(cos, of_rows), none = hn::Lt(cos, hn::Neg(of_rows));
    none = hn::And(none, hn::Eq(at(bounds.two_sided), zero));
    if (sided) {
      const V off_n = hn::MulAdd(radius, size_n, rounding), off_ng = hn::MulAdd(radius, size_ng, rounding);
      const V from_n = dot(light_n, w), from_ng = dot(light_ng, w);
      all = hn::And(all, hn::And(hn::Lt(from_n, hn::Neg(off_n)), hn::Lt(from_ng, hn::Neg(off_ng))));
      if (light.sides == LitSides::front) none = hn::Or(none, hn::Or(hn::Gt(from_n, off_n), hn::Gt(from_ng, off_ng)));
    }
    std::uint8_t bits[16] = {};
    hn::StoreMaskBits(d, all, bits);
    hn::StoreMaskBits(d, none, bits + 8);
    const std::uint32_t lanes = hn::Lanes(d) < 16 ? (1u << hn::Lanes(d)) - 1 : 0xffff;
    decided.all |= ((bits[0] | std::uint32_t{bits[1]} << 8) & lanes) << b;
    decided.none |= ((bits[8] | std::uint32_t{bits[9]} << 8) & lanes) << b;
  }
  return decided;
}

/// Blocks that are held against one light after the other: their 9 KiB stay in the first cache.
constexpr std::size_t kTile = 4;
static_assert(kBoundBlocks % kTile == 0);

struct Tile {
  std::span<const RowBlock> blocks;
  std::span<const std::uint64_t> both_sides, existing;
  bool flat = false;
};

template <bool kDistant, LitSides kSides, bool kFlat, bool kFlatLight>
HWY_INLINE void active_tile(const Tile& tile, const ActivityLight& light, Decided decided, std::uint64_t* active) {
  for (std::size_t b = 0; b < tile.blocks.size(); ++b) {
    if (decided.all >> b & 1)
      active[b] = tile.existing[b];
    else if (decided.none >> b & 1)
      active[b] = 0;
    else
      active[b] = active_word<kDistant, kSides, kFlat, kFlatLight>(tile.blocks[b], tile.both_sides[b], light);
  }
}

template <bool kDistant, LitSides kSides>
void active_of_light(const Tile& tile, const ActivityLight& light, Decided decided, std::uint64_t* active) {
  const bool flat_light = std::equal(light.n, light.n + 3, light.ng);
  if (tile.flat)
    flat_light ? active_tile<kDistant, kSides, true, true>(tile, light, decided, active)
               : active_tile<kDistant, kSides, true, false>(tile, light, decided, active);
  else
    flat_light ? active_tile<kDistant, kSides, false, true>(tile, light, decided, active)
               : active_tile<kDistant, kSides, false, false>(tile, light, decided, active);
}

template <bool kDistant>
void active_any(const Tile& tile, const ActivityLight& light, Decided decided, std::uint64_t* active) {
  switch (light.sides) {
    case LitSides::all:
      return active_of_light<kDistant, LitSides::all>(tile, light, decided, active);
    case LitSides::front:
      return active_of_light<kDistant, LitSides::front>(tile, light, decided, active);
    case LitSides::front_and_back:
      return active_of_light<kDistant, LitSides::front_and_back>(tile, light, decided, active);
  }
}

bool is_flat(std::span<const RowBlock> blocks) {
  return std::all_of(blocks.begin(), blocks.end(), [](const RowBlock& b) {
    for (int k = 0; k < 3; ++k)
      if (!std::equal(b.n[k], b.n[k] + kBlockRows, b.ng[k])) return false;
    return true;
  });
}

void active(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides,
            std::span<const BlockBounds> bounds, std::span<const std::uint64_t> existing,
            std::span<const ActivityLight> lights, std::span<std::uint64_t> words) {
  std::vector<Decided> decided(lights.size());
  for (std::size_t first = 0; first < blocks.size(); first += kTile) {
    const std::size_t n = std::min(kTile, blocks.size() - first), in_bounds = first % kBoundBlocks;
    if (in_bounds == 0)
      for (std::size_t j = 0; j < lights.size(); ++j)
        decided[j] = lights[j].distant ? decide<true>(bounds[first / kBoundBlocks], lights[j])
                                       : decide<false>(bounds[first / kBoundBlocks], lights[j]);
    const std::span<const RowBlock> some = blocks.subspan(first, n);
    const Tile tile{some, both_sides.subspan(first, n), existing.subspan(first, n), is_flat(some)};
    for (std::size_t j = 0; j < lights.size(); ++j) {
      const Decided here{decided[j].all >> in_bounds, decided[j].none >> in_bounds};
      std::uint64_t* const to = words.data() + j * blocks.size() + first;
      lights[j].distant ? active_any<true>(tile, lights[j], here, to) : active_any<false>(tile, lights[j], here, to);
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

namespace {

/// Bit r: row r exists, that is, has a normal.
std::uint64_t existing_rows(const RowBlock& rows);
void bound_block(const RowBlock& rows, std::uint64_t existing, bool two_sided, BlockBounds& bounds, std::size_t lane);

}  // namespace

void active_bits(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides,
                 std::span<const ActivityLight> lights, std::span<std::uint64_t> active) {
  MYRIALUX_ASSERT(both_sides.size() == blocks.size() && active.size() == lights.size() * blocks.size());
  std::vector<BlockBounds> bounds((blocks.size() + kBoundBlocks - 1) / kBoundBlocks);
  std::vector<std::uint64_t> existing(blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    existing[b] = existing_rows(blocks[b]);
    bound_block(blocks[b], existing[b], both_sides[b] != 0, bounds[b / kBoundBlocks], b % kBoundBlocks);
  }
  HWY_DYNAMIC_DISPATCH(active)(blocks, both_sides, bounds, existing, lights, active);
}

namespace {

std::uint64_t existing_rows(const RowBlock& rows) {
  std::uint64_t existing = 0;
  for (std::size_t row = 0; row < kBlockRows; ++row) {
    bool any = false;
    for (int k = 0; k < 3; ++k) any |= rows.n[k][row] != 0 || rows.ng[k][row] != 0;
    existing |= std::uint64_t{any} << row;
  }
  return existing;
}

/// Largest distance from the axis of the vectors in `rows`, squared.
float spread_squared(const BlockFloats* rows, const float* axis, std::uint64_t existing) {
  float most = 0;
  for (std::size_t row = 0; row < kBlockRows; ++row) {
    if ((existing >> row & 1) == 0) continue;
    const float x = rows[0][row] - axis[0], y = rows[1][row] - axis[1], z = rows[2][row] - axis[2];
    most = std::max(most, x * x + y * y + z * z);
  }
  return most;
}

/// A sphere around the positions, their distance from a plane through its centre, and a cone of both normals.
void bound_block(const RowBlock& rows, std::uint64_t existing, bool two_sided, BlockBounds& bounds, std::size_t lane) {
  constexpr float kWiden = 1.0001f, kLeast = 1e-6f;
  float centre[3], axis[3], squared = 0;
  const float share = 1 / static_cast<float>(std::max(std::popcount(existing), 1));
  for (int k = 0; k < 3; ++k) {
    float p = 0, n = 0;
    for (std::size_t row = 0; row < kBlockRows; ++row)
      if (existing >> row & 1) p += rows.p[k][row], n += rows.ng[k][row];
    centre[k] = p * share, axis[k] = n * share;
    squared += axis[k] * axis[k];
  }
  const float scale = squared > 0 ? 1 / std::sqrt(squared) : 0;
  float depth = 0;
  for (int k = 0; k < 3; ++k) axis[k] *= scale;
  for (std::size_t row = 0; row < kBlockRows; ++row) {
    if ((existing >> row & 1) == 0) continue;
    float along = 0;
    for (int k = 0; k < 3; ++k) along += axis[k] * (rows.p[k][row] - centre[k]);
    depth = std::max(depth, std::fabs(along));
  }
  const float spread = std::max(spread_squared(rows.n, axis, existing), spread_squared(rows.ng, axis, existing));
  const float radius = std::sqrt(spread_squared(rows.p, centre, existing)) * kWiden;
  for (int k = 0; k < 3; ++k) bounds.centre[k][lane] = centre[k], bounds.axis[k][lane] = axis[k];
  bounds.radius[lane] = radius;
  bounds.spread[lane] = std::sqrt(spread) * kWiden + kLeast;
  bounds.depth[lane] = depth * kWiden + kLeast * radius;
  bounds.two_sided[lane] = two_sided ? 1.0f : 0.0f;
}

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
