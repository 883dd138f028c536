// Which triangles are remembered, and that shadow rays of slices come out the same with them.
#include "myrialux/visibility/occluder_cache.h"

#include <gtest/gtest.h>

#include <utility>

#include "myrialux/visibility/slice_visibility.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

struct alignas(64) Rows {
  BlockFloats p[3] = {};
};

/// Covers all rows near the origin from a light above.
constexpr std::array<Vec3, 3> kRoof{Vec3{-9, -9, 1}, Vec3{9, -9, 1}, Vec3{0, 9, 1}};
constexpr std::array<Vec3, 3> kElsewhere{Vec3{50, 50, 1}, Vec3{51, 50, 1}, Vec3{50, 51, 1}};

TEST(OccluderCache, ForgetsWhatSettledLeastOfLate) {
  const Rows rows;
  const float* const p[3] = {rows.p[0], rows.p[1], rows.p[2]};
  OccluderCache cache(Box3{{-1, -1, 0}, {1, 1, 0}});
  const KnownEnd above{{0, 0, 2}, false};
  cache.aim(above);
  EXPECT_TRUE(cache.is_clear());
  cache.add(kRoof);
  EXPECT_FALSE(cache.is_clear());
  for (std::size_t n = 0; n < 3 * kOccluders; ++n) {
    cache.aim(above);
    EXPECT_EQ(cache.blocked(p, 0xff00ff), 0xff00ffu) << "useful ones stay, " << n;
    cache.add(kElsewhere);
  }
  for (std::size_t n = 0; n < 20 + kOccluders; ++n) cache.aim(above), cache.add(kElsewhere);
  EXPECT_TRUE(cache.is_clear()) << "others do not";
}

TEST(OccluderCache, LightsBelowSeeNoShadow) {
  OccluderCache cache(Box3{{-0.3f, -0.3f, 0}, {0.3f, 0.3f, 0}});
  cache.aim({{0, 0, 2}, false});
  cache.add(kRoof);
  cache.aim({{0, 0, 0.5f}, false});
  EXPECT_TRUE(cache.is_clear());
  cache.aim({{0, 0, 1}, true});
  EXPECT_FALSE(cache.is_clear());
}

/// Boxes in a room; `solid` false: with holes.
Scene boxes(bool solid) {
  test::SceneBuilder b;
  Material m;
  m.name = "wall";
  m.kind = BsdfKind::diffuse;
  if (!solid) m.opacity = {gray(0.5f)};
  const MaterialId wall = b.add(m);
  b.box({-0.6f, -0.9f, -0.5f}, {-0.2f, 0.1f, -0.1f}, wall);
  b.box({0.3f, -0.3f, 0.2f}, {0.5f, 0.6f, 0.7f}, wall);
  b.rectangle({-0.5f, 0.6f, -0.5f}, {0.9f, 0, 0}, {0, 0, 0.6f}, wall);
  b.camera({0, 0, 3}, {0, 0, 0}, 40, 8, 8);
  return std::move(b.scene);
}

/// Traces all active entries; returns packets with and without remembered triangles.
std::pair<std::uint64_t, std::uint64_t> packets_of_both(bool solid) {
  const test::Room room({.n_receivers = 1024,
                         .n_lights = 96,
                         .kinds = {LightKind::oriented, LightKind::point, LightKind::directional},
                         .seed = 3});
  const Scene scene = boxes(solid);
  const Tracer tracer(scene);
  const World of_room = room.world();
  const World world{.scene = of_room.scene, .tracer = tracer, .emitters = of_room.emitters};
  std::vector<ReceiverId> rows;
  for (std::size_t i = 0; i < room.receivers.size(); ++i) rows.push_back(static_cast<ReceiverId>(i));
  std::vector<Column> columns;
  for (std::size_t j = 0; j < room.lights.size(); ++j) columns.push_back({.light = static_cast<LightId>(j)});
  SliceVisibility with(world, room.receivers, rows, room.lights, columns, true),
      without(world, room.receivers, rows, room.lights, columns, true);
  without.forget_occluders();
  BitMatrix visible(rows.size(), columns.size()), expected(rows.size(), columns.size());
  for (std::size_t j = 0; j < columns.size(); ++j) {
    with.trace(j, with.active(j), visible.column(j));
    without.trace(j, without.active(j), expected.column(j));
  }
  EXPECT_TRUE(visible == expected);
  EXPECT_EQ(with.rays(), without.rays());
  return {with.packets(), without.packets()};
}

TEST(OccluderCache, SlicesHaveTheSameBitsFromFewerPackets) {
  const auto [with, without] = packets_of_both(true);
  EXPECT_LT(static_cast<double>(with), 0.95 * static_cast<double>(without));
}

TEST(OccluderCache, TrianglesWithHolesAreNotRemembered) {
  const auto [with, without] = packets_of_both(false);
  EXPECT_EQ(with, without);
}

}  // namespace
}  // namespace myrialux
