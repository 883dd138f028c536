// Frames, boxes and colours.
#include "myrialux/math/vec.h"

#include <gtest/gtest.h>

#include "myrialux/base/rng.h"
#include "myrialux/math/warp.h"

namespace myrialux {
namespace {

void expect_orthonormal(Vec3 n) {
  const Frame f(n);
  EXPECT_NEAR(length(f.s), 1, 1e-6f);
  EXPECT_NEAR(length(f.t), 1, 1e-6f);
  EXPECT_NEAR(dot(f.s, f.t), 0, 1e-6f);
  EXPECT_NEAR(dot(f.s, n), 0, 1e-6f);
  EXPECT_NEAR(dot(f.t, n), 0, 1e-6f);
  EXPECT_LT(length(cross(f.s, f.t) - n), 2e-6f) << n.x << ' ' << n.y << ' ' << n.z;  // right-handed
}

TEST(Frame, IsOrthonormalAndRightHandedEverywhere) {
  Rng rng({1, 0}, Stage::test, 0);
  for (int i = 0; i < 2000; ++i) {
    const float x = rng.next(), y = rng.next();
    expect_orthonormal(normalize(sample_sphere({x, y})));
  }
  for (const Vec3 n : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{1, 0, 0}, Vec3{0, -1, 0}, Vec3{1, 0, -0.0f}})
    expect_orthonormal(n);
  for (const float e : {1e-3f, 1e-5f, 1e-7f}) expect_orthonormal(normalize({e, -e, -1}));  // near the far pole
}

TEST(Frame, ToWorldUndoesToLocal) {
  const Frame f(normalize({0.3f, -0.5f, -0.8f}));
  const Vec3 v{1, 2, 3};
  EXPECT_LT(length(f.to_world(f.to_local(v)) - v), 1e-5f);
  EXPECT_LT(length(f.to_local(f.n) - Vec3{0, 0, 1}), 1e-6f);
}

TEST(Box, GrowsAndMeasures) {
  Box3 box;
  EXPECT_TRUE(box.is_empty());
  EXPECT_EQ(box.diagonal(), 0);
  box.add(Vec3{1, 2, 3});
  EXPECT_FALSE(box.is_empty());
  EXPECT_EQ(box.diagonal(), 0);
  box.add(Vec3{4, 6, 3});
  EXPECT_EQ(box.diagonal(), 5);
  EXPECT_EQ(box.centre(), (Vec3{2.5f, 4, 3}));
  EXPECT_EQ(distance_squared(box, {2, 3, 3}), 0);
  EXPECT_EQ(distance_squared(box, {0, 2, 5}), 5);
  EXPECT_EQ(distance_squared(box, {7, 10, 3}), 25);
  Box3 other;
  other.add(box);
  other.add(Box3{});  // empty boxes add nothing
  EXPECT_EQ(other.lower, box.lower);
  EXPECT_EQ(other.upper, box.upper);
}

TEST(Rgb, LuminanceWeightsAddUpToOne) {
  EXPECT_NEAR(luminance(gray(1)), 1, 1e-6f);
  EXPECT_NEAR(mean({1, 2, 6}), 3, 1e-6f);
  EXPECT_EQ(max_component({1, 7, 6}), 7);
}

}  // namespace
}  // namespace myrialux
