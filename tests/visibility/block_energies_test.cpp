// Energies of blocks are what their middle rows may receive: never less, and just that for diffuse rows.
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

TEST_P(BlockEnergiesOf, MiddleRowsAreBounded) {
  std::vector<float> ratios;  // of energies and weights between diffuse rows and any lights
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
      for (std::size_t b = 0; b < n_blocks; ++b) {
        const ReceiverId i = rows[16 * b + std::min<std::size_t>(16, n_rows - 16 * b) / 2];
        const Rgb t = transfer(room.world(), room.receivers, i, room.lights, columns[j].light, kClamp);
        const float weight = columns[j].weight * luminance(room.receivers.beta[index(i)] * t) / kUnit;
        EXPECT_GE(energies[b], weight * (1 - 1e-5f)) << "column " << j << ", block " << b;
        if (!GetParam() && weight > 0) ratios.push_back(energies[b] / weight);
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
