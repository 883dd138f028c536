// Virtual lights: energy by bounce, number, independence of threads.
#include <gtest/gtest.h>

#include <cstring>

#include "myrialux/base/parallel.h"
#include "myrialux/lights/virtual_lights.h"
#include "support/build_scene.h"
#include "support/statistics.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

using test::Sample;
using test::TestWorld;
using test::z_score;

LightResult trace(const World& world, std::uint64_t n_lights, bool direct, std::uint64_t seed) {
  Progress quiet;
  return trace_lights(world, {.n_lights = n_lights, .direct = direct, .key = {seed, 0}}, quiet);
}

/// Power that oriented lights of one bounce send out, pi times the intensity along the normal; mean of the channels, W.
double flux_w(const VirtualLights& lights, int bounce) {
  double sum = 0;
  for (std::size_t j = 0; j < lights.size(); ++j)
    if (lights.bounce[j] == bounce) sum += static_cast<double>(mean(lights.light[j]) * kPi);
  return sum;
}

TEST(VirtualLights, FurnaceKeepsAlbedoOfThePowerAtEachBounce) {
  const float albedo = 0.6f;
  TestWorld t(test::furnace_sphere(albedo), 8);
  Sample flux[7];
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const VirtualLights lights = trace(t.world, 500, true, seed).lights;
    for (int bounce = 0; bounce < 7; ++bounce) flux[bounce].add(flux_w(lights, bounce));
    EXPECT_EQ(flux_w(lights, 7), 0);  // one edge more to the receiver and one to the camera would be 9
  }
  const double power = 4 * M_PI * M_PI;  // radiance 1 over a unit sphere
  EXPECT_NEAR(flux[0].mean, power, 1e-4 * power);
  for (int bounce = 1; bounce < 7; ++bounce) {
    const double expected = power * std::pow(static_cast<double>(albedo), bounce);
    if (flux[bounce].variance_of_mean() < 1e-9 * power)
      EXPECT_NEAR(flux[bounce].mean, expected, 1e-4 * power);
    else
      EXPECT_LT(std::fabs(z_score(flux[bounce], expected)), 4) << "bounce " << bounce;
  }
}

/// Under a sun straight above, the power that a flat wall reflects is that which a wall with tilted normals would
/// receive: |wi . n| / |wi . ng| = cos(tilt) of it [veach97, eq. 5.19].
TEST(VirtualLights, TiltedNormalsTakeTheirCosine) {
  const auto lights_on_wall = [](Vec3 n) {
    test::SceneBuilder b;
    b.rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, b.diffuse(gray(0.5f)));
    b.scene.meshes.back().normals.assign(4, n);
    b.emitter("sun", DirectionalEmitter{{0, 0, -1}, gray(2)});
    TestWorld t(b.scene, 3);  // no light after the first bounce
    return trace(t.world, 500, false, 1).lights;
  };
  const VirtualLights flat = lights_on_wall({0, 0, 1}), tilted = lights_on_wall({0.6f, 0, 0.8f});
  ASSERT_GT(flat.size(), 100u);
  ASSERT_EQ(flat.size(), tilted.size());  // the same walks meet the same wall
  for (std::size_t j = 0; j < flat.size(); ++j) EXPECT_FLOAT_EQ(tilted.light[j].g, 0.8f * flat.light[j].g);
}

TEST(VirtualLights, EmissionAddsUpToThePowerOfAllEmittersAndFallsWithEachBounce) {
  test::SceneBuilder b = test::cornell_builder();
  b.area_emitter(b.sphere({0.5f, 0.3f, 0.3f}, 0.1f, b.diffuse(gray(0.2f))), {5, 9, 20});
  TestWorld t(b.scene);
  Sample flux[6];
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const VirtualLights lights = trace(t.world, 2000, true, seed).lights;
    for (int bounce = 0; bounce < 6; ++bounce) flux[bounce].add(flux_w(lights, bounce));
  }
  EXPECT_LT(std::fabs(z_score(flux[0], static_cast<double>(mean(t.emitters.power())))), 4);
  for (int bounce = 0; bounce + 1 < 6; ++bounce) EXPECT_LT(flux[bounce + 1].mean, flux[bounce].mean);
}

TEST(VirtualLights, AsManyAsAskedForOnAverage) {
  TestWorld t(test::cornell_box());
  for (const bool direct : {true, false}) {
    const LightResult r = trace(t.world, 20000, direct, 3);
    EXPECT_NEAR(static_cast<double>(r.lights.size()), 20000, 2000);  // the pilot's spread is below 4 %
    for (const std::uint8_t bounce : r.lights.bounce) EXPECT_GE(bounce, direct ? 0 : 1);
  }
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

TEST(VirtualLights, SameBitsForAnyNumberOfThreads) {
  TestWorld t(test::glossy_floor_box(0.3f));
  const auto with_threads = [&](int n_threads) {
    const ThreadScope threads(n_threads);
    return trace(t.world, 5000, true, 11);
  };
  const LightResult one = with_threads(1);
  EXPECT_FALSE(one.lights.glossy.empty());
  for (const int n : {2, 7}) {
    const LightResult many = with_threads(n);
    EXPECT_TRUE(same_bits(one.lights.p, many.lights.p));
    EXPECT_TRUE(same_bits(one.lights.light, many.lights.light));
    EXPECT_TRUE(same_bits(one.lights.extra, many.lights.extra));
    EXPECT_EQ(one.light_rays, many.light_rays);
  }
  EXPECT_FALSE(same_bits(one.lights.p, trace(t.world, 5000, true, 12).lights.p));
}

TEST(VirtualLights, AreFiniteOnTheLitSideAndWorthSomething) {
  for (Scene scene : {test::glass_pane_box(), test::glossy_floor_box(0.3f), test::plastic_floor_box()}) {
    TestWorld t(std::move(scene));
    const VirtualLights lights = trace(t.world, 3000, true, 4).lights;
    for (std::size_t j = 0; j < lights.size(); ++j) {
      ASSERT_TRUE(is_finite(lights.light[j]) && is_finite(lights.p[j]));
      EXPECT_GE(std::min({lights.light[j].r, lights.light[j].g, lights.light[j].b}), 0);
      EXPECT_NEAR(length(lights.n[j]), 1, 1e-5f);
      EXPECT_GT(dot(lights.n[j], lights.ng[j]), 0);
      const float importance = lights.importance(t.world, static_cast<LightId>(j));
      EXPECT_TRUE(std::isfinite(importance) && importance > 0) << j;
      if (lights.kind[j] == LightKind::glossy) {
        EXPECT_GT(dot(lights.glossy[lights.extra[j]].wi, lights.n[j]), 0);
      }
    }
  }
}

TEST(VirtualLights, NoneWhereMaxDepthLeavesNoEdge) {
  EXPECT_EQ(trace(TestWorld(test::cornell_box(), 1).world, 100, true, 1).lights.size(), 0u);
  TestWorld two(test::cornell_box(), 2);
  const VirtualLights lights = trace(two.world, 100, true, 1).lights;
  EXPECT_EQ(lights.size(), 100u);  // bounce 0 alone: one a walk
  for (const std::uint8_t bounce : lights.bounce) EXPECT_EQ(bounce, 0);
}

TEST(VirtualLights, PointsSpotsAndSkyBecomeTheirKinds) {
  test::SceneBuilder b;
  b.rectangle({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, b.diffuse(gray(0.5f)));
  b.emitter("bulb", PointEmitter{{0, 1, 0}, gray(1)});
  b.emitter("spot",
            SpotEmitter{.to_world = Transform::look_at({0, 2, 0}, {0, 0, 0}, {1, 0, 0}), .intensity = gray(20)});
  b.emitter("sky", ConstantEmitter{gray(1)});
  TestWorld t(b.scene);
  const VirtualLights lights = trace(t.world, 2000, true, 5).lights;
  int points = 0, spots = 0, distant = 0;
  for (std::size_t j = 0; j < lights.size(); ++j) {
    if (lights.kind[j] == LightKind::point) {
      const bool spot = lights.extra[j] != 0xffffffffu;
      (spot ? spots : points)++;
      EXPECT_NEAR(lights.p[j].y, spot ? 2 : 1, 1e-6f);
      if (spot) {
        EXPECT_NEAR(lights.n[j].y, -1, 1e-6f);
      }
    }
    distant += lights.kind[j] == LightKind::directional;
  }
  EXPECT_GT(points, 0);
  EXPECT_GT(spots, 0);
  EXPECT_GT(distant, 0);
}

}  // namespace
}  // namespace myrialux
