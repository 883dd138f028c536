// Energies of blocks are bounds of what any of their rows may receive, and tight for single diffuse rows.
#include "myrialux/visibility/block_energies.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

using test::Room;

constexpr float kClamp = 0.05f, kUnit = 0.7f;

class BlockEnergiesOf : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Gloss, BlockEnergiesOf, ::testing::Bool());

TEST_P(BlockEnergiesOf, BoundAllRows) {
  std::vector<float> ratios;  // of energies and weights of single diffuse rows
  for (const std::size_t n_rows : {1u, 15u, 40u, 300u}) {
    const Room room({.n_receivers = n_rows,
                     .n_lights = 200,
                     .kinds = {LightKind::oriented, LightKind::glossy, LightKind::point, LightKind::directional},
                     .glossy = GetParam(),
                     .seed = n_rows});
    const LightTree tree = build_light_tree(room.world(), room.lights, Room::kRadius, {});
    std::vector<ReceiverId> rows(n_rows);
    for (std::size_t k = 0; k < n_rows; ++k) rows[k] = static_cast<ReceiverId>(k);
    const std::vector<Column> columns =
        light_cut(room.world(), room.receivers, rows, room.lights, tree, {.n_clusters = 60, .clamp_distance = kClamp});
    const BlockEnergies of_blocks(room.world(), room.receivers, rows, room.lights, tree, columns, kClamp, kUnit);

    const std::size_t n_blocks = (n_rows + 15) / 16;
    std::vector<float> energies(n_blocks + 3, -1.0f);
    for (std::size_t j = 0; j < columns.size(); ++j) {
      of_blocks.of(j, energies);
      for (std::size_t k = 0; k < n_rows; ++k) {
        const Rgb t = transfer(room.world(), room.receivers, rows[k], room.lights, columns[j].light, kClamp);
        const float weight = columns[j].weight * luminance(room.receivers.beta[k] * t) / kUnit;
        ASSERT_GE(energies[k / 16], weight * (1 - 1e-4f)) << "column " << j << ", row " << k;
        if (n_rows == 1 && !GetParam() && weight > 0) ratios.push_back(energies[0] / weight);
      }
      for (std::size_t b = n_blocks; b < energies.size(); ++b) EXPECT_EQ(energies[b], 0.0f) << "beyond the rows";
    }
  }
  if (GetParam()) return;
  // Bounds, but not far off: measured 1.53, mostly for colours that miss each other.
  std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2), ratios.end());
  EXPECT_LT(ratios[ratios.size() / 2], 2.0f);
}

}  // namespace
}  // namespace myrialux
