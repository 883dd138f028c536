// Kernels of visibility against their plain twins: equal bits on every instruction set.
#include "myrialux/kernels/active_bits.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/kernels/isa.h"
#include "myrialux/kernels/shadow_ends.h"

namespace myrialux {
namespace {

/// A coarse grid makes cosines of exactly 0 common.
float coarse(Rng& rng) { return (static_cast<float>(rng.below(9)) - 4) / 4; }

RowBlock random_rows(Rng& rng) {
  RowBlock rows{};
  for (std::size_t row = 0; row < 60; ++row)  // the last four do not exist
    for (int k = 0; k < 3; ++k)
      rows.p[k][row] = coarse(rng), rows.n[k][row] = coarse(rng), rows.ng[k][row] = coarse(rng);
  return rows;
}

/// 60 neighbours on a plane, or nearly so: decided by their bounds, most of the time.
RowBlock neighbours(Rng& rng, float roughness) {
  RowBlock rows{};
  float p[3], n[3] = {0, 0, 0};
  n[rng.below(3)] = rng.below(2) ? 1.0f : -1.0f;
  for (float& x : p) x = coarse(rng);
  for (std::size_t row = 0; row < 60; ++row)
    for (int k = 0; k < 3; ++k) {
      rows.p[k][row] = p[k] + (n[k] != 0 ? roughness : 0.25f) * (rng.next() - 0.5f);
      rows.ng[k][row] = n[k] + roughness * (rng.next() - 0.5f);
      rows.n[k][row] = rows.ng[k][row] + roughness * (rng.next() - 0.5f);
    }
  return rows;
}

TEST(ActiveBits, EqualTheirPlainTwinOnEveryInstructionSet) {
  Rng rng({1}, Stage::test, 0);
  std::vector<RowBlock> blocks;
  std::vector<std::uint64_t> both_sides;
  for (int b = 0; b < 17; ++b) {
    blocks.push_back(b < 12 ? random_rows(rng) : neighbours(rng, b % 2 == 0 ? 0.0f : 0.02f));
    if (b >= 8 && b < 12) std::memcpy(blocks.back().ng, blocks.back().n, sizeof blocks.back().n);
    both_sides.push_back(b % 2 == 0 ? 0 : std::uint64_t{rng.next_uint()} << 32 | rng.next_uint());
  }
  for (const std::int64_t isa : available_isas()) {
    force_isa(isa);
    std::uint64_t any = 0, missing = 0;
    for (int round = 0; round < 20; ++round) {
      std::vector<ActivityLight> lights(12);
      for (std::size_t j = 0; j < lights.size(); ++j) {
        ActivityLight& light = lights[j];
        for (int k = 0; k < 3; ++k) light.to[k] = coarse(rng), light.n[k] = coarse(rng), light.ng[k] = coarse(rng);
        if (j % 4 < 2) std::copy_n(light.n, 3, light.ng);
        light.distant = j % 2 == 1;
        light.sides = static_cast<LitSides>(j % 3);
      }
      std::vector<std::uint64_t> got(lights.size() * blocks.size(), 7), expected(got.size(), 9);
      active_bits(blocks, both_sides, lights, got);
      active_bits_plain(blocks, both_sides, lights, expected);
      EXPECT_EQ(got, expected) << isa_name(isa) << " round " << round;
      for (const std::uint64_t word : got) any |= word, missing |= ~word;
    }
    EXPECT_EQ(any >> 60, 0u) << "rows that do not exist";
    EXPECT_EQ(any, (std::uint64_t{1} << 60) - 1);
    EXPECT_EQ(missing, ~std::uint64_t{0});
  }
  force_isa(0);
}

PacketRays as_rays(PacketFloats* a) { return {{a[0], a[1], a[2]}, {a[3], a[4], a[5]}, a[6]}; }

/// Rays of the kernel against its plain twin, and those to a fixed end against the general ones.
void expect_same_rays(const PacketRows& rows, const ShadowLight& light) {
  constexpr float kFar = 0.75f;
  alignas(64) PacketFloats got[7], expected[7], ends[6];
  shadow_rays(rows, light, kFar, as_rays(got));
  shadow_rays_plain(rows, light, kFar, as_rays(expected));
  EXPECT_EQ(std::memcmp(got, expected, sizeof got), 0) << isa_name();

  shadow_ends_plain(rows, light, std::array<float*, 3>{ends[0], ends[1], ends[2]}.data(),
                    std::array<float*, 3>{ends[3], ends[4], ends[5]}.data());
  for (std::size_t row = 0; row < kPacketRows; ++row) {
    KnownEnd end{{ends[3][row], ends[4][row], ends[5][row]}, light.end == SegmentEnd::direction};
    shadow_rays_to(std::array<const float*, 3>{ends[0], ends[1], ends[2]}.data(), 1, end, kFar, as_rays(got));
    for (int k = 0; k < 7; ++k) EXPECT_EQ(got[k][row], expected[k][row]) << isa_name() << " row " << row;
  }
}

TEST(ShadowEnds, EqualTheirPlainTwinOnEveryInstructionSet) {
  Rng rng({2}, Stage::test, 0);
  for (const std::int64_t isa : available_isas()) {
    force_isa(isa);
    for (int round = 0; round < 300; ++round) {
      const RowBlock block = random_rows(rng);
      alignas(64) PacketFloats offset, got[6], expected[6];
      for (float& x : offset) x = 1e-5f * rng.next();
      const std::size_t first = 16 * rng.below(3);
      const PacketRows rows{{block.p[0] + first, block.p[1] + first, block.p[2] + first},
                            {block.ng[0] + first, block.ng[1] + first, block.ng[2] + first},
                            offset};
      ShadowLight light{};
      for (int k = 0; k < 3; ++k) light.p[k] = coarse(rng), light.ng[k] = coarse(rng);
      light.offset = 1e-4f * rng.next();
      light.end = static_cast<SegmentEnd>(round % 3);
      shadow_ends(rows, light, std::array<float*, 3>{got[0], got[1], got[2]}.data(),
                  std::array<float*, 3>{got[3], got[4], got[5]}.data());
      shadow_ends_plain(rows, light, std::array<float*, 3>{expected[0], expected[1], expected[2]}.data(),
                        std::array<float*, 3>{expected[3], expected[4], expected[5]}.data());
      EXPECT_EQ(std::memcmp(got, expected, sizeof got), 0) << isa_name(isa) << " round " << round;
      expect_same_rays(rows, light);
    }
  }
  force_isa(0);
}

}  // namespace
}  // namespace myrialux
