// Walks told apart by bounces: where they begin and end, how many there are.
#include "myrialux/lights/walks.h"

#include <gtest/gtest.h>

#include "support/build_scene.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

VirtualLights with_bounces(const std::vector<std::uint8_t>& bounces) {
  VirtualLights lights;
  lights.bounce = bounces;
  lights.p.resize(bounces.size());
  return lights;
}

TEST(Walks, ABounceThatDoesNotRiseBeginsOne) {
  const VirtualLights lights = with_bounces({0, 1, 3, 0, 0, 2, 2, 1});
  const std::vector<std::pair<std::size_t, std::size_t>> expected = {{0, 3}, {0, 3}, {0, 3}, {3, 4},
                                                                     {4, 6}, {4, 6}, {6, 7}, {7, 8}};
  for (std::size_t j = 0; j < lights.size(); ++j) EXPECT_EQ(walk_of(lights, static_cast<LightId>(j)), expected[j]) << j;
  EXPECT_EQ(count_walks(lights), 5);
  EXPECT_EQ(count_walks(VirtualLights{}), 0);
}

TEST(Walks, OfTracedLightsAreAsManyAsWereMade) {
  const test::TestWorld box(test::cornell_box());
  Progress silent;
  const LightResult traced = trace_lights(box.world, {.n_lights = 2000, .direct = true, .key = {3}}, silent);
  VirtualLights lights = traced.lights;
  EXPECT_EQ(count_walks(lights), static_cast<double>(traced.n_walks));
  lights.n_walks = 0;  // as if read from a file; each walk has left a light on the lamp
  EXPECT_EQ(count_walks(lights), static_cast<double>(traced.n_walks));
}

}  // namespace
}  // namespace myrialux
