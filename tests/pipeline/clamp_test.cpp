// The least distance of virtual lights, as a share of the scene's size or in its units.
#include <gtest/gtest.h>

#include <algorithm>

#include "myrialux/pipeline/clamp.h"
#include "support/build_scene.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

TEST(Clamp, LengthIsAShareOfTheRobustRadiusOrGivenInSceneUnits) {
  std::vector<Vec3> points(101);
  for (std::size_t i = 0; i < 101; ++i) points[i] = {static_cast<float>(i), 0, 0};
  EXPECT_EQ(robust_radius(points), 48);  // the outer 2 % on either side do not count
  EXPECT_EQ(clamp_length(0.25f, -1, points), 12);
  EXPECT_EQ(clamp_length(0.25f, 3, points), 3);
  EXPECT_EQ(clamp_length(0.25f, 0, points), 0);
}

TEST(Clamp, SizeIsToldByTheFirstFourSamplesOfEachPixelHoweverTheyAreTraced) {
  const test::TestWorld t(test::plastic_floor_box());
  Progress silent;
  for (const int spp : {1, 4, 10}) {
    const ReceiverParams params{.width = 9, .height = 7, .spp = spp, .key = {5, 1}};
    PathCounters rays;
    const std::vector<Vec3> points = size_points(trace_receivers(t.world, params, silent).receivers, spp);
    EXPECT_EQ(points, trace_receiver_positions(t.world, params, kSizeSamples, rays));
    EXPECT_GT(points.size(), 63u * std::min(4u, static_cast<unsigned>(spp)) / 2);
    EXPECT_GE(rays.closest, points.size());
  }
}

}  // namespace
}  // namespace myrialux
