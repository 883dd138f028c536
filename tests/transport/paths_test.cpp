// The path tracer's parts: furnace, roulette, next-event estimation, hidden emitters, invisible surfaces.
#include <gtest/gtest.h>

#include "myrialux/transport/paths.h"
#include "support/build_scene.h"
#include "support/statistics.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

using test::Sample;
using test::TestWorld;
using test::z_score;

/// Mean path radiance over random directions from the camera's place, in batches of 256.
Sample mean_radiance(const World& world, std::uint64_t seed, int n_batches) {
  const Vec3 origin = world.scene.camera.to_world.point({});
  const Vec3 forward = normalize(world.scene.camera.to_world.vector({0, 0, 1}));
  Sample result;
  PathCounters counters;
  for (int batch = 0; batch < n_batches; ++batch) {
    Rng rng({seed, 0}, Stage::test, static_cast<std::uint64_t>(batch));
    double sum = 0;
    for (int k = 0; k < 256; ++k) {
      const Vec3 local{0.5f * rng.next() - 0.25f, 0.5f * rng.next() - 0.25f, 1};
      const Ray ray{origin, normalize(Frame(forward).to_world(local)), kInfinity};
      const Rgb radiance = path_radiance(world, ray, 0, rng, counters);
      EXPECT_TRUE(is_finite(radiance));
      EXPECT_GE(std::min({radiance.r, radiance.g, radiance.b}), 0);
      sum += static_cast<double>(mean(radiance));
    }
    result.add(sum / 256);
  }
  return result;
}

TEST(Paths, FurnaceInsideSphereGivesTheGeometricSeries) {
  const float albedo = 0.6f;
  for (const int max_depth : {1, 2, 3, 6}) {
    TestWorld t(test::furnace_sphere(albedo), max_depth);
    t.world.rr_depth = 3;
    double expected = 0;
    for (int k = 0; k < max_depth; ++k) expected += std::pow(static_cast<double>(albedo), k);
    const Sample measured = mean_radiance(t.world, 1, 60);
    if (max_depth <= t.world.rr_depth)  // no roulette yet: every sample is exact but for rounding
      EXPECT_NEAR(measured.mean, expected, 1e-5);
    else
      EXPECT_LT(std::fabs(z_score(measured, expected)), 4) << "depth " << max_depth << ": " << measured.mean;
  }
}

TEST(Paths, UnlimitedFurnaceReachesTheLimit) {
  TestWorld t(test::furnace_sphere(0.5f));
  const Sample measured = mean_radiance(t.world, 2, 60);
  EXPECT_LT(std::fabs(z_score(measured, 2)), 4) << measured.mean;
}

TEST(Paths, RouletteKeepsTheMean) {
  TestWorld t(test::cornell_box(), 8);
  t.world.rr_depth = 1;
  const Sample with = mean_radiance(t.world, 3, 80);
  t.world.rr_depth = 100;
  const Sample without = mean_radiance(t.world, 4, 80);
  EXPECT_LT(std::fabs(z_score(with, without)), 4) << with.mean << " and " << without.mean;
}

/// Direct light at the vertices that camera rays meet, by emitter samples alone or with MIS.
Sample direct_light(const TestWorld& t, bool mis, std::uint64_t seed, int n_batches) {
  const Vec3 origin = t.scene.camera.to_world.point({});
  Sample result;
  PathCounters counters;
  for (int batch = 0; batch < n_batches; ++batch) {
    Rng rng({seed, 0}, Stage::test, static_cast<std::uint64_t>(batch));
    double sum = 0;
    for (int k = 0; k < 256; ++k) {
      const Vec3 at{rng.next() - 0.5f, rng.next() - 0.5f, 0};
      const Vec3 direction = normalize(at - origin);
      const auto hit = t.tracer.closest({origin, direction, kInfinity});
      if (!hit) continue;
      const Vertex vertex = make_vertex(t.world, *hit, -direction);
      sum += static_cast<double>(mean(mis ? reflected_radiance(t.world, vertex, Lobes::all, 1, rng, counters)
                                          : next_event(t.world, vertex, Lobes::all, false, rng, counters)));
    }
    result.add(sum / 256);
  }
  return result;
}

TEST(Paths, MisAndEmitterSamplesAloneAgreeOnDirectLight) {
  TestWorld rough(test::glossy_floor_box(0.3f), 2);
  const Sample with = direct_light(rough, true, 5, 150), without = direct_light(rough, false, 6, 150);
  EXPECT_LT(std::fabs(z_score(with, without)), 4) << with.mean << " and " << without.mean;
}

TEST(Paths, NothingIsNanOnAnyMaterial) {
  for (Scene scene : {test::glass_pane_box(), test::glossy_floor_box(0.05f), test::plastic_floor_box()}) {
    TestWorld t(std::move(scene));
    EXPECT_GT(mean_radiance(t.world, 7, 8).mean, 0);
  }
}

TEST(Paths, NullSurfaceChangesNothing) {
  TestWorld plain(test::cornell_box());
  test::SceneBuilder b = test::cornell_builder();
  Material nothing;
  nothing.kind = BsdfKind::null;
  b.box({-0.9f, 0.4f, -0.9f}, {0.9f, 0.6f, 0.9f}, b.add(nothing));
  TestWorld with(std::move(b.scene));
  const Sample a = mean_radiance(plain.world, 8, 120), c = mean_radiance(with.world, 9, 120);
  EXPECT_LT(std::fabs(z_score(a, c)), 4) << a.mean << " and " << c.mean;
}

TEST(Paths, HiddenEmittersLetCameraRaysThroughButStillShine) {
  test::SceneBuilder b;
  b.rectangle({-9, -9, -1}, {18, 0, 0}, {0, 18, 0}, b.diffuse(gray(0.5f)));
  b.area_emitter(b.rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, b.diffuse(gray(0.5f))), gray(3));
  b.camera({0, 0, 5}, {0, 0, 0}, 10, 4, 4);
  b.scene.hide_emitters = true;
  TestWorld hidden(b.scene, 1);
  EXPECT_EQ(mean_radiance(hidden.world, 10, 2).mean, 0);
  b.scene.hide_emitters = false;
  TestWorld shown(b.scene, 1);
  EXPECT_NEAR(mean_radiance(shown.world, 10, 2).mean, 3, 1);  // most rays meet the lamp
  test::SceneBuilder turned = b;  // the lamp faces the wall: hidden, the wall behind it is seen lit
  turned.scene.hide_emitters = true;
  turned.scene.shapes.back().flip_normals = true;
  TestWorld lit(turned.scene, 2);
  EXPECT_GT(mean_radiance(lit.world, 11, 2).mean, 0.1);
}

TEST(Residual, IsZeroWhereVirtualLightsCarryEverything) {
  TestWorld t(test::cornell_box(), 6);
  const Vec3 origin = t.scene.camera.to_world.point({});
  PathCounters counters;
  Rng rng({12, 0}, Stage::test, 0);
  for (int k = 0; k < 200; ++k) {
    const Vec3 direction = normalize(Vec3{rng.next() - 0.5f, rng.next() - 0.5f, 0} - origin);
    const auto hit = t.tracer.closest({origin, direction, kInfinity});
    ASSERT_TRUE(hit);
    const Vertex vertex = make_vertex(t.world, *hit, -direction);
    const ResidualParams params{.clamp_distance = 0, .direct_by_sampling = false, .depth = 1};
    EXPECT_EQ(residual_radiance(t.world, vertex, params, rng, counters), Rgb{});
  }
}

TEST(Residual, WeighsItsPathAgainstAllEmitterSamples) {
  // Walls that glow evenly: emitter samples and the residual's path find the light about equally often, and together
  // bring the albedo.
  const float albedo = 0.7f;
  TestWorld t(test::furnace_sphere(albedo), 2);
  PathCounters counters;
  for (const int n_samples : {1, 2, 8}) {
    Sample sum;
    for (int k = 0; k < 20'000; ++k) {
      Rng rng({14, 0}, Stage::test, static_cast<std::uint64_t>(k));
      const Vec3 direction = normalize(Vec3{rng.next() - 0.5f, rng.next() - 0.5f, rng.next() - 0.5f});
      const auto hit = t.tracer.closest({{}, direction, kInfinity});
      ASSERT_TRUE(hit);
      const Vertex vertex = make_vertex(t.world, *hit, -direction);
      const ResidualParams params{
          .clamp_distance = 0, .direct_by_sampling = true, .direct_samples = n_samples, .depth = 1};
      sum.add(
          static_cast<double>(mean(next_event(t.world, vertex, Lobes::wide, /*mis=*/true, rng, counters, n_samples) +
                                   residual_radiance(t.world, vertex, params, rng, counters))));
    }
    EXPECT_LT(std::fabs(z_score(sum, static_cast<double>(albedo))), 4) << n_samples << " samples: " << sum.mean;
  }
}

TEST(Residual, ClampedBeyondTheSceneIsNearlyAllOfTheLight) {
  TestWorld t(test::cornell_box(), 5);
  const Vec3 origin = t.scene.camera.to_world.point({});
  PathCounters counters;
  Sample residual, whole;
  for (int batch = 0; batch < 100; ++batch) {
    Rng rng({13, 0}, Stage::test, static_cast<std::uint64_t>(batch));
    double a = 0, b = 0;
    for (int k = 0; k < 128; ++k) {
      const Vec3 direction = normalize(Vec3{rng.next() - 0.5f, rng.next() - 0.5f, 0} - origin);
      const auto hit = t.tracer.closest({origin, direction, kInfinity});
      const Vertex vertex = make_vertex(t.world, *hit, -direction);
      const ResidualParams params{.clamp_distance = 1e4f, .direct_by_sampling = false, .depth = 1};
      a += static_cast<double>(mean(residual_radiance(t.world, vertex, params, rng, counters)));
      b += static_cast<double>(mean(reflected_radiance(t.world, vertex, Lobes::wide, 1, rng, counters)));
    }
    residual.add(a / 128), whole.add(b / 128);
  }
  EXPECT_LT(std::fabs(z_score(residual, whole)), 4) << residual.mean << " and " << whole.mean;
}

}  // namespace
}  // namespace myrialux
