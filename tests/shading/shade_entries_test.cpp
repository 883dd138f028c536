// Single entries against the sums of one column each.
#include "myrialux/shading/shade_entries.h"

#include <gtest/gtest.h>

#include "myrialux/kernels/shade_block.h"
#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

constexpr float kClamp = 0.2f;

/// Every light of a room with every kind of row and light, joined with its rows; some entries hidden.
void expect_entries_equal_sums(std::size_t n_rows) {
  const test::Room room({.n_receivers = n_rows,
                         .n_lights = 200,
                         .kinds = {LightKind::oriented, LightKind::glossy, LightKind::point, LightKind::directional},
                         .glossy = true,
                         .glass = true,
                         .shading_tilt = 0.2f});
  std::vector<ReceiverId> rows;
  for (std::size_t i = 0; i < n_rows; ++i) rows.push_back(static_cast<ReceiverId>(i));
  std::vector<Column> columns;
  for (std::size_t j = 0; j < room.lights.size(); ++j)
    columns.push_back({.light = static_cast<LightId>(j), .weight = 3});
  BitMatrix visible(n_rows, columns.size());
  Rng rng({4}, Stage::test, 0);
  for (std::size_t j = 0; j < columns.size(); ++j)
    for (std::size_t i = 0; i < n_rows; ++i)
      if (rng.next() < 0.8f && is_active(room.world(), room.receivers, rows[i], room.lights, columns[j].light))
        visible.set(i, j);

  std::vector<float> entries(columns.size() * kBlockRows, -1);
  shade_entries(room.world(), room.receivers, rows, room.lights, columns, visible, {kClamp}, entries);
  std::size_t n_lit = 0;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    Column alone = columns[j];
    alone.weight = 1;
    BitMatrix bits(n_rows, 1);
    for (std::size_t i = 0; i < n_rows; ++i)
      if (visible.test(i, j)) bits.set(i, 0);
    std::vector<Rgb> sum(n_rows);
    shade_slice(room.world(), room.receivers, rows, room.lights, std::span(&alone, 1), bits, {kClamp}, sum);
    for (std::size_t i = 0; i < kBlockRows; ++i) {
      const float expected = i < n_rows ? luminance(sum[i]) : 0;
      EXPECT_EQ(entries[j * kBlockRows + i], expected) << "row " << i << ", column " << j;
      n_lit += expected > 0;
    }
  }
  EXPECT_GT(n_lit, n_rows * columns.size() / 10);
}

TEST(ShadeEntries, EqualTheSumsOfOneColumnEach) {
  expect_entries_equal_sums(64);
  expect_entries_equal_sums(17);
}

}  // namespace
}  // namespace myrialux
