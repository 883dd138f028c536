// Which rows a light can reach by its and their normals: one bit a row, for 64 rows at a time.
#pragma once

#include <cstdint>
#include <span>

#include "myrialux/kernels/shade_block.h"

namespace myrialux {

/// Sides of a light's own surface from which light leaves.
enum class LitSides : std::uint8_t { all, front, front_and_back };

/// A column as activity sees it.
struct ActivityLight {
  float to[3] = {};   ///< position; distant lights: unit direction towards where the light comes from
  float n[3], ng[3];  ///< shading and geometric normal; not read for LitSides::all
  bool distant = false;
  LitSides sides = LitSides::all;
};

/// Sets bit k of active[j * n_blocks + b] when row k of blocks[b] and light j lie on the front side of each other's
/// normals, shading and geometric; rows in both_sides[b] may also have it behind both of theirs. Rows of zero normals
/// are not active. Same bits on every instruction set. Cost: about 20 operations an entry, fewer where normals are the
/// same; rows stay in the first cache while the lights pass by. @param active [lights x blocks], set
void active_bits(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides,
                 std::span<const ActivityLight> lights, std::span<std::uint64_t> active);
void active_bits_plain(std::span<const RowBlock> blocks, std::span<const std::uint64_t> both_sides,
                       std::span<const ActivityLight> lights, std::span<std::uint64_t> active);

}  // namespace myrialux
