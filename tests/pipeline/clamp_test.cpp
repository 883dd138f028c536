// The least distance of virtual lights, as a share of the scene's size or in its units.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "myrialux/base/parallel.h"
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

TEST(Clamp, SizeIsThatOfSortedCoordinates) {
  Rng rng({7}, Stage::test, 0);
  for (const std::size_t n : {1u, 2u, 49u, 50u, 51u, 40000u}) {
    std::vector<Vec3> points(n);
    for (Vec3& p : points) p = {rng.next() - 0.5f, rng.below(2) ? 1.5f : -1.5f, std::exp(20 * rng.next())};
    std::vector<float> x[3];
    for (int axis = 0; axis < 3; ++axis) {
      for (const Vec3 p : points) x[axis].push_back(p[axis]);
      std::sort(x[axis].begin(), x[axis].end());
    }
    const std::size_t low = n / 50, high = n - 1 - low;
    const Vec3 extent{x[0][high] - x[0][low], x[1][high] - x[1][low], x[2][high] - x[2][low]};
    for (const int threads : {1, 2, 7}) {
      const ThreadScope scope(threads);
      EXPECT_EQ(robust_radius(points), 0.5f * length(extent)) << n;
    }
  }
}

TEST(Clamp, SizeIsToldByTheFirstFourSamplesOfEachPixelHoweverTheyAreTraced) {
  const test::TestWorld t(test::plastic_floor_box());
  Progress silent;
  for (const int spp : {1, 4, 10}) {
    const ReceiverParams params{.width = 9, .height = 7, .spp = spp, .key = {5, 1}};
    PathCounters rays;
    const Array<Vec3> points = size_points(trace_receivers(t.world, params, silent).receivers, spp);
    const std::vector<Vec3> traced = trace_receiver_positions(t.world, params, kSizeSamples, rays);
    EXPECT_TRUE(std::equal(points.begin(), points.end(), traced.begin(), traced.end()));
    EXPECT_GT(points.size(), 63u * std::min(4u, static_cast<unsigned>(spp)) / 2);
    EXPECT_GE(rays.closest, points.size());
  }
}

}  // namespace
}  // namespace myrialux
