// The least distance of virtual lights, as a share of the scene's size or in its units.
#include <gtest/gtest.h>

#include "myrialux/pipeline/pipeline.h"

namespace myrialux {
namespace {

TEST(Clamp, LengthIsAShareOfTheRobustRadiusOrGivenInSceneUnits) {
  Receivers receivers;
  receivers.resize(101);
  for (std::size_t i = 0; i < 101; ++i) receivers.p[i] = {static_cast<float>(i), 0, 0};
  EXPECT_EQ(robust_radius(receivers), 48);  // the outer 2 % on either side do not count
  EXPECT_EQ(clamp_length(0.25f, -1, receivers), 12);
  EXPECT_EQ(clamp_length(0.25f, 3, receivers), 3);
  EXPECT_EQ(clamp_length(0.25f, 0, receivers), 0);
}

}  // namespace
}  // namespace myrialux
