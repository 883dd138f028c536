// Entries that must not be guessed: none above the limit is missed, and not much else is marked.
#include "myrialux/visibility/heavy_entries.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

using test::Room;
using test::RoomOptions;

constexpr float kClamp = 0.05f;

struct HeavyCase {
  const char* name;
  RoomOptions options;
  double marked_over_needed;  ///< recorded, with a quarter of margin
};
std::ostream& operator<<(std::ostream& out, const HeavyCase& c) { return out << c.name; }

/// A slice of the first rows of a room (not compact: harder than a true slice) and its cut.
struct Slice {
  explicit Slice(const Room& room)
      : tree(build_light_tree(room.world(), room.lights, Room::kRadius, {})), rows(room.receivers.size()) {
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<ReceiverId>(k);
    columns =
        light_cut(room.world(), room.receivers, rows, room.lights, tree, {.n_clusters = 300, .clamp_distance = kClamp});
    active = BitMatrix(rows.size(), columns.size());
    weight.resize(rows.size() * columns.size());
    for (std::size_t j = 0; j < columns.size(); ++j)
      for (std::size_t k = 0; k < rows.size(); ++k) {
        if (!is_active(room.world(), room.receivers, rows[k], room.lights, columns[j].light)) continue;
        active.set(k, j);
        const Rgb t = transfer(room.world(), room.receivers, rows[k], room.lights, columns[j].light, kClamp);
        weight[j * rows.size() + k] = columns[j].weight * luminance(room.receivers.beta[k] * t);
      }
  }
  float quantile(double share) const {
    std::vector<float> sorted = weight;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  }
  LightTree tree;
  std::vector<ReceiverId> rows;
  std::vector<Column> columns;
  BitMatrix active;
  std::vector<float> weight;  ///< W T beta, [columns x rows]
};

class HeavyEntries : public ::testing::TestWithParam<HeavyCase> {};

TEST_P(HeavyEntries, NoneAboveTheLimitIsMissed) {
  const Room room(GetParam().options);
  const Slice s(room);
  double marked = 0, needed = 0;
  for (const double share : {0.5, 0.9, 0.99, 0.999}) {
    const float limit = s.quantile(share);
    if (limit <= 0) continue;
    const BitMatrix heavy =
        heavy_entries(room.world(), room.receivers, s.rows, room.lights, s.tree, s.columns, s.active, kClamp, limit);
    for (std::size_t j = 0; j < s.columns.size(); ++j)
      for (std::size_t first = 0; first < s.rows.size(); first += 16) {
        std::size_t n_marked = 0, n_active = 0, n_above = 0;
        for (std::size_t k = first; k < std::min(first + 16, s.rows.size()); ++k) {
          const bool is_marked = heavy.test(k, j), is_active = s.active.test(k, j);
          const bool is_above = s.weight[j * s.rows.size() + k] > limit * 1.0001f;  // bounds round, too
          ASSERT_TRUE(is_marked || !is_above) << "row " << k << " column " << j << " limit " << limit;
          ASSERT_TRUE(is_active || !is_marked) << "row " << k << " column " << j;
          n_marked += is_marked, n_active += is_active, n_above += is_above;
        }
        EXPECT_TRUE(n_marked == 0 || n_marked == n_active) << "packets are marked whole";
        marked += static_cast<double>(n_marked);
        needed += n_above > 0 ? static_cast<double>(n_active) : 0;
      }
  }
  EXPECT_LT(marked, GetParam().marked_over_needed * needed) << marked / needed;
}

INSTANTIATE_TEST_SUITE_P(
    Rooms, HeavyEntries,
    ::testing::Values(
        HeavyCase{"diffuse", {.n_lights = 3000}, 1.55},
        HeavyCase{"tilted", {.n_lights = 3000, .shading_tilt = 0.3f}, 1.56},
        HeavyCase{"points", {.n_lights = 3000, .kinds = {LightKind::point}}, 1.7},
        HeavyCase{"directional", {.n_lights = 3000, .kinds = {LightKind::directional}, .glossy = true}, 1.9},
        HeavyCase{"glossy_receivers", {.n_lights = 3000, .glossy = true, .shading_tilt = 0.1f}, 1.43},
        HeavyCase{"glossy_lights", {.n_lights = 3000, .kinds = {LightKind::glossy}, .shading_tilt = 0.1f}, 2.6},
        HeavyCase{"glass", {.n_lights = 3000, .kinds = {LightKind::glossy}, .glossy = true, .glass = true}, 2.65}),
    [](const auto& c) { return std::string(c.param.name); });

TEST(HeavyEntries, HighLimitsMarkNothingAndLowOnesEverything) {
  const Room room({.n_lights = 500});
  const Slice s(room);
  const auto heavy = [&](float limit) {
    return heavy_entries(room.world(), room.receivers, s.rows, room.lights, s.tree, s.columns, s.active, kClamp, limit);
  };
  EXPECT_EQ(heavy(1e30f).count(), 0u);
  EXPECT_EQ(heavy(1e-30f), s.active);
}

}  // namespace
}  // namespace myrialux
