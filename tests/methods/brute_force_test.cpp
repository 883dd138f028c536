// brute-force against its plain twin: kernels and packets over chunks of lights give the sum of single entries.
#include "myrialux/reference/brute_force.h"

#include <gtest/gtest.h>

#include "myrialux/base/parallel.h"
#include "myrialux/methods/slice_driver.h"
#include "support/method_frame.h"

namespace myrialux {
namespace {

using Fixture = test::MethodFrame;
using test::relative_rmse;

/// Single entries, summed in double precision in the order of the lights.
std::vector<Rgb> plain_sum(const Fixture& f, BruteForceCounters& counters) {
  Progress silent;
  std::vector<Rgb> radiance(f.receivers.size());
  counters = brute_force(f.world, f.receivers, f.lights, f.params.cut.clamp_distance, radiance, silent);
  return radiance;
}

/// Lamp, sky, sun, point light and spot: every kind of virtual light but glossy ones.
Scene box_under_all_emitters() {
  test::SceneBuilder b = test::cornell_builder();
  b.emitter("sky", ConstantEmitter{gray(0.5f)});
  b.emitter("sun", DirectionalEmitter{normalize({0.2f, -0.3f, -1}), {2, 1.8f, 1.5f}});
  b.emitter("bulb", PointEmitter{{0.3f, 0.4f, 0.6f}, gray(0.5f)});
  SpotEmitter spot;
  spot.to_world = Transform::look_at({-0.5f, 0.8f, 0.7f}, {0, -1, 0}, {0, 0, 1});
  spot.intensity = gray(3);
  b.emitter("spot", spot);
  return std::move(b.scene);
}

TEST(BruteForce, ManyChunksEqualThePlainSum) {
  const Fixture f(test::cornell_box(), 3 * kBruteForceColumns, 24);
  ASSERT_GT(f.lights.size(), 2 * kBruteForceColumns);
  BruteForceCounters counters;
  RenderStats stats;
  const std::vector<Rgb> plain = plain_sum(f, counters), fast = f.run("brute-force", stats).radiance;
  // A chunk's sum in single precision is off by at most one ulp a term; chunks are added in double precision.
  EXPECT_LT(relative_rmse(plain, fast), kBruteForceColumns * 6e-8);
  EXPECT_EQ(stats.visibility.traced, stats.visibility.entries);
  // Active entries face each other; those that the clamp, a black wall or distance reduce to 0 are among them.
  EXPECT_GE(stats.visibility.entries, counters.traced);
  EXPECT_LT(stats.visibility.entries, counters.entries);
  EXPECT_EQ(stats.rays.shadow, stats.visibility.traced);
}

TEST(BruteForce, EqualsThePlainSumUnderEveryEmitterAndOnGloss) {
  BruteForceCounters counters;
  const Fixture diffuse(box_under_all_emitters(), 2000, 24);
  for (const LightKind kind : {LightKind::oriented, LightKind::point, LightKind::directional})
    ASSERT_NE(std::count(diffuse.lights.kind.begin(), diffuse.lights.kind.end(), kind), 0) << static_cast<int>(kind);
  EXPECT_LT(relative_rmse(plain_sum(diffuse, counters), diffuse.run("brute-force").radiance),
            kBruteForceColumns * 6e-8);
  const Fixture gloss(test::glossy_floor_box(0.3f), 2000, 24);
  ASSERT_FALSE(gloss.lights.glossy.empty());
  // The kernels' rational approximations of lobes add to rounding; their own bound is tested in tests/shading.
  EXPECT_LT(relative_rmse(plain_sum(gloss, counters), gloss.run("brute-force").radiance), 1e-4);
}

TEST(BruteForce, DoesNotDependOnThreads) {
  const Fixture f(test::glossy_floor_box(0.3f), 3000, 40);
  std::vector<std::vector<Rgb>> pictures;
  for (const int n : {1, 2, 7}) {
    const ThreadScope threads(n);
    pictures.push_back(f.run("brute-force").radiance);
  }
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_EQ(pictures[0], pictures[2]);
}

TEST(BruteForce, NoLightsMeanDarkness) {
  Fixture f(test::cornell_box(), 100, 8);
  f.lights = {};
  for (const Rgb& c : f.run("brute-force").radiance) EXPECT_EQ(c, Rgb{});
}

}  // namespace
}  // namespace myrialux
