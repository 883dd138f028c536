// Active sets and traced bits of a slice against the scalar definitions, entry by entry and exactly.
#include "myrialux/visibility/slice_visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "myrialux/base/clock.h"
#include "myrialux/kernels/isa.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

/// Boxes, a ball, quads and half-transparent screens in the middle of the room.
Scene obstacles() {
  test::SceneBuilder b;
  const MaterialId white = b.diffuse({0.5f, 0.5f, 0.5f});
  Material screen;
  screen.name = "screen";
  screen.kind = BsdfKind::diffuse;
  screen.opacity = {gray(0.4f)};
  const MaterialId masked = b.add(screen);
  b.box({-0.6f, -0.9f, -0.5f}, {-0.2f, 0.1f, -0.1f}, white);
  b.box({0.3f, -0.3f, 0.2f}, {0.5f, 0.6f, 0.7f}, white);
  b.sphere({0.4f, 0.5f, -0.4f}, 0.25f, white);
  b.rectangle({-0.5f, 0.6f, -0.5f}, {0.9f, 0, 0}, {0, 0, 0.6f}, white);
  b.rectangle({-0.8f, -0.5f, 0.6f}, {0.9f, 0, 0}, {0, 0.9f, 0.1f}, masked);
  b.rectangle({-0.3f, 0.3f, -0.8f}, {0, 0, 0.9f}, {0.1f, 0.5f, 0}, masked);
  b.camera({0, 0, 3}, {0, 0, 0}, 40, 8, 8);
  return std::move(b.scene);
}

/// Rows and lights of a room, shadows of the obstacles.
struct Setting {
  explicit Setting(test::RoomOptions options) : room(options), tracer(scene) {
    rows.resize(room.receivers.size());
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<ReceiverId>(rows.size() - 1 - k);
    const Vec3 centre = slice_centre(room.receivers, rows);
    std::vector<std::uint32_t> order(room.lights.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t j) {
      return std::pair(room.lights.kind[j], octant(centre, room.lights, static_cast<LightId>(j)));
    };
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    for (const std::uint32_t j : order) columns.push_back({.light = static_cast<LightId>(j)});
  }
  World world() const {
    const World w = room.world();
    return {.scene = w.scene, .tracer = tracer, .emitters = w.emitters};
  }
  SliceVisibility slice(bool cull = true) const {
    return SliceVisibility(world(), room.receivers, rows, room.lights, columns, cull);
  }
  bool true_bit(std::size_t r, std::size_t j) const {
    const Segment s = shadow_segment(room.receivers, rows[r], room.lights, columns[j].light);
    return !(s.distant ? tracer.occluded_direction(s.from, s.to) : tracer.occluded(s.from, s.to));
  }

  test::Room room;
  Scene scene = obstacles();
  Tracer tracer;
  std::vector<ReceiverId> rows;
  std::vector<Column> columns;
};

test::RoomOptions options(std::size_t n_rows, std::size_t n_lights = 96, bool wild = true) {
  return {.n_receivers = n_rows,
          .n_lights = n_lights,
          .kinds = {LightKind::oriented, LightKind::glossy, LightKind::point, LightKind::directional},
          .glossy = wild,
          .glass = wild,
          .shading_tilt = wild ? 0.4f : 0.0f,
          .seed = n_rows};
}

class SliceVisibilitySizes : public ::testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Rows, SliceVisibilitySizes, ::testing::Values(1, 15, 63, 64, 65, 500));

TEST_P(SliceVisibilitySizes, ActiveSetsAreThoseOfTheTransferOnEveryInstructionSet) {
  const Setting s(options(GetParam()));
  for (const std::int64_t isa : available_isas()) {
    force_isa(isa);
    const SliceVisibility slice = s.slice();
    std::size_t n_wrong = 0, n_active = 0;
    for (std::size_t j = 0; j < slice.n_columns(); ++j)
      for (std::size_t r = 0; r < slice.n_rows(); ++r) {
        const bool active = is_active(s.world(), s.room.receivers, s.rows[r], s.room.lights, s.columns[j].light);
        n_wrong += active != test_bit(slice.active(j), r);
        n_active += active;
      }
    EXPECT_EQ(n_wrong, 0u) << isa_name(isa);
    EXPECT_EQ(slice.active_matrix().count(), n_active) << "spare bits are 0";
  }
  force_isa(0);
}

TEST_P(SliceVisibilitySizes, TracedBitsAreThoseOfSingleRaysForAnyWantedRows) {
  const Setting s(options(GetParam()));
  Rng rng({1}, Stage::test, GetParam());
  for (const bool cull : {true, false}) {
    SliceVisibility slice = s.slice(cull);
    std::size_t n_rays = 0, n_wrong = 0, n_visible = 0, n_touched = 0;
    for (std::size_t j = 0; j < slice.n_columns(); ++j) {
      // From single scattered rows to whole columns.
      const float density = j % 4 == 0 ? 1.0f : j % 4 == 1 ? 0.03f : rng.next();
      BitMatrix wanted(slice.n_rows(), 1), visible(slice.n_rows(), 1);
      for (std::size_t r = 0; r < slice.n_rows(); ++r) {
        if (test_bit(slice.active(j), r) && rng.next() < density) wanted.set(r, 0);
        if (rng.below(2)) visible.set(r, 0);
      }
      const BitMatrix before = visible;
      slice.trace(j, std::as_const(wanted).column(0), visible.column(0));
      n_rays += wanted.count();
      for (std::size_t r = 0; r < slice.n_rows(); ++r) {
        if (wanted.test(r, 0)) {
          n_wrong += visible.test(r, 0) != s.true_bit(r, j);
          n_visible += visible.test(r, 0);
        } else {
          n_touched += visible.test(r, 0) != before.test(r, 0);
        }
      }
    }
    EXPECT_EQ(n_wrong, 0u) << "of " << n_rays;
    EXPECT_EQ(n_touched, 0u) << "rows not wanted stay as they are";
    EXPECT_EQ(slice.rays(), n_rays);
    if (GetParam() >= 63) {
      EXPECT_GT(n_visible, n_rays / 10);
      EXPECT_LT(n_visible, n_rays - n_rays / 10) << "the obstacles are in the way";
    }
  }
}

TEST(SliceVisibility, WithoutCullingAllRowsCount) {
  const Setting s(options(100));
  const SliceVisibility slice = s.slice(false);
  EXPECT_EQ(slice.active_matrix().count(), 100 * s.columns.size());
}

TEST(SliceVisibility, GroupsAreRunsOfOneKindAndOctant) {
  const Setting s(options(64, 400));
  const SliceVisibility slice = s.slice();
  const Vec3 centre = slice_centre(s.room.receivers, s.rows);
  std::size_t begin = 0;
  EXPECT_GT(slice.n_groups(), 20u);
  EXPECT_LE(slice.n_groups(), 32u);
  for (std::size_t g = 0; g < slice.n_groups(); ++g) {
    const std::size_t end = slice.group_end(g);
    ASSERT_LT(begin, end);
    const LightId first = s.columns[begin].light;
    for (std::size_t j = begin; j < end; ++j) {
      const LightId light = s.columns[j].light;
      EXPECT_EQ(s.room.lights.kind[index(light)], s.room.lights.kind[index(first)]);
      EXPECT_EQ(octant(centre, s.room.lights, light), octant(centre, s.room.lights, first));
    }
    begin = end;
  }
  EXPECT_EQ(begin, s.columns.size());
}

TEST(SliceVisibility, KindsStayApartWhereTheirOctantsMeet) {
  Setting s(options(64, 400));
  const Vec3 centre = slice_centre(s.room.receivers, s.rows);
  std::erase_if(s.columns, [&](const Column& c) { return octant(centre, s.room.lights, c.light) != 3; });
  EXPECT_EQ(s.slice().n_groups(), 4u);
}

TEST(SliceVisibility, AdjacentRowsShareAPacketAndScatteredOnesArePackedTogether) {
  const Setting s(options(1024, 4));
  SliceVisibility slice = s.slice(false);
  BitMatrix all(1024, 1), sparse(1024, 1), visible(1024, 1);
  fill_rows(all.column(0), 1024);
  slice.trace(0, std::as_const(all).column(0), visible.column(0));
  EXPECT_EQ(slice.packets(), 64u);
  for (std::size_t r = 0; r < 32; ++r) sparse.set(r * 32 + 5, 0);
  slice.trace(0, std::as_const(sparse).column(0), visible.column(0));
  EXPECT_EQ(slice.packets(), 64u + 2u);
  EXPECT_EQ(slice.rays(), 1024u + 32u);
}

TEST(SliceVisibility, TraceTimeIsPartOfTheThreadsTime) {
  const Setting s(options(1024, 200));
  ThreadStopwatch cpu;
  SliceVisibility slice = s.slice();
  BitMatrix visible(1024, slice.n_columns());
  EXPECT_EQ(slice.trace_seconds(), 0);
  for (std::size_t j = 0; j < slice.n_columns(); ++j) slice.trace(j, slice.active(j), visible.column(j));
  EXPECT_GT(slice.trace_seconds(), 0);
  EXPECT_LE(slice.trace_seconds(), cpu.elapsed() * 1.01);
}

TEST(SliceVisibility, SlicesWithoutColumnsAreFine) {
  Setting s(options(10, 4));
  s.columns.clear();
  const SliceVisibility slice = s.slice();
  EXPECT_EQ(slice.n_columns(), 0u);
  EXPECT_EQ(slice.n_groups(), 0u);
}

}  // namespace
}  // namespace myrialux
