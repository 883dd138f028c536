// Kernels of visibility against their plain twins: equal bits on every instruction set.
#include "myrialux/kernels/active_bits.h"

#include <gtest/gtest.h>

#include <algorithm>
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

TEST(ActiveBits, EqualTheirPlainTwinOnEveryInstructionSet) {
  Rng rng({1}, Stage::test, 0);
  std::vector<RowBlock> blocks;
  std::vector<std::uint64_t> both_sides;
  for (int b = 0; b < 17; ++b) {
    blocks.push_back(random_rows(rng));
    both_sides.push_back(b % 2 == 0 ? 0 : std::uint64_t{rng.next_uint()} << 32 | rng.next_uint());
  }
  for (const std::int64_t isa : available_isas()) {
    force_isa(isa);
    std::uint64_t any = 0, missing = 0;
    for (int round = 0; round < 60; ++round) {
      ActivityLight light{};
      for (int k = 0; k < 3; ++k) light.to[k] = coarse(rng), light.n[k] = coarse(rng), light.ng[k] = coarse(rng);
      light.distant = round % 2 == 1;
      light.sides = static_cast<LitSides>(round % 3);
      if (round % 5 == 0) std::copy_n(light.ng, 3, light.n);
      std::vector<std::uint64_t> got(blocks.size(), 7), expected(blocks.size(), 9);
      active_bits(blocks, both_sides, light, got);
      active_bits_plain(blocks, both_sides, light, expected);
      EXPECT_EQ(got, expected) << isa_name(isa) << " round " << round;
      for (const std::uint64_t word : got) any |= word, missing |= ~word;
    }
    EXPECT_EQ(any >> 60, 0u) << "rows that do not exist";
    EXPECT_EQ(any, (std::uint64_t{1} << 60) - 1);
    EXPECT_EQ(missing, ~std::uint64_t{0});
  }
  force_isa(0);
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
    }
  }
  force_isa(0);
}

}  // namespace
}  // namespace myrialux
