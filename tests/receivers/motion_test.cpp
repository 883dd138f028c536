// Moving cameras: when samples are taken, and how far what stands still is smeared.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "myrialux/receivers/receivers.h"
#include "support/build_scene.h"
#include "support/statistics.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

/// Looks along -z from z = 5, moves by `distance` to its right while the shutter is open, from time 2 to 3.
Camera moving_camera(float distance) {
  Camera camera;
  const auto placement = [](float x) { return Transform::look_at({x, 0, 5}, {x, 0, 0}, {0, 1, 0}); };
  camera.fov_x_deg = 40;
  camera.motion = {{1, placement(-distance)}, {2, placement(0)}, {3, placement(distance)}, {4, placement(9)}};
  camera.shutter_open = 2, camera.shutter_close = 3;
  camera.to_world = camera.at(2.5);
  return camera;
}

TEST(Motion, TimesAreUniformInTheShutterAndEveryPartHoldsOne) {
  const Camera camera = moving_camera(1);
  for (const int spp : {1, 5, 16}) {
    test::Sample of_first, squares, with_film;
    for (std::uint64_t pixel = 0; pixel < 4000; ++pixel) {
      std::vector<int> parts(static_cast<std::size_t>(spp));
      for (int k = 0; k < spp; ++k) {
        const CameraSample s = camera_sample(camera, 1, pixel, k, spp, {2, 7});
        ASSERT_TRUE(s.time >= 2 && s.time < 3);
        ++parts[static_cast<std::size_t>((s.time - 2) * spp)];
        if (k > 0) continue;
        of_first.add(s.time), squares.add((s.time - 2) * (s.time - 2));
        with_film.add((s.time - 2.5) * (static_cast<double>(s.film.x) - 0.5));
      }
      EXPECT_EQ(std::count(parts.begin(), parts.end(), 1), spp);
    }
    EXPECT_LT(std::fabs(test::z_score(of_first, 2.5)), 4);
    EXPECT_LT(std::fabs(test::z_score(squares, 1.0 / 3)), 4);
    EXPECT_LT(std::fabs(test::z_score(with_film, 0)), 4) << "when and where are independent";
  }
}

TEST(Motion, CamerasThatStandDrawNoTimeAndGiveTheSameRays) {
  Camera still = moving_camera(1), closed = still;
  still.motion.clear(), closed.shutter_close = closed.shutter_open;
  for (const Camera& camera : {still, closed})
    for (int k = 0; k < 4; ++k) {
      const CameraSample s = camera_sample(camera, 8, 21, k, 4, {2, 7});
      EXPECT_EQ(s.time, 0);
      const Ray ray = camera_ray(camera, 8, 8, s);
      EXPECT_EQ(lens_point(camera, s), camera.to_world.point({}));
      EXPECT_EQ(camera_sample(moving_camera(1), 8, 21, k, 4, {2, 7}).film.x, s.film.x) << "the film's numbers stay";
      EXPECT_GT(ray.t_max, 0);
    }
}

TEST(Motion, AnEdgeIsSmearedOverTheDistanceThatTheCameraMoves) {
  // A wall at distance 5 that glows where x > 0. A pixel's brightness is the share of the time that it shows x > 0: a
  // ramp as long as the camera's way, here 0.8 of the 2 * 5 tan 20 degrees that 100 pixels show.
  constexpr int kWidth = 100;
  constexpr float kWay = 0.8f;
  test::SceneBuilder b;
  b.area_emitter(b.rectangle({0, -9, 0}, {9, 0, 0}, {0, 18, 0}, b.diffuse(gray(0))), gray(1));
  b.camera({0, 0, 5}, {0, 0, 0}, 40, kWidth, 1);
  b.scene.camera = moving_camera(kWay);
  test::TestWorld t(b.scene, 1);
  Progress quiet;
  const ReceiverResult r = trace_receivers(t.world, {.width = kWidth, .height = 1, .spp = 256, .key = {1, 0}}, quiet);
  const float pixel_size = 2 * 5 * std::tan(20 * kPi / 180) / kWidth;
  double largest = 0;
  for (int x = 0; x < kWidth; ++x) {
    double mean = 0;
    for (std::size_t k = 0; k < 256; ++k)
      mean += static_cast<double>(r.samples.emission[static_cast<std::size_t>(x) * 256 + k].r) / 256;
    // Mean over the pixel's width of the share of camera positions in [0, way] to the right of -x.
    double expected = 0;
    for (int i = 0; i < 100; ++i) {
      const float at = (static_cast<float>(x) + (static_cast<float>(i) + 0.5f) / 100 - 0.5f * kWidth) * pixel_size;
      expected += static_cast<double>(std::clamp((kWay + at) / kWay, 0.0f, 1.0f)) / 100;
    }
    largest = std::max(largest, std::fabs(mean - expected));
  }
  // Stratified times: about one sample in 256 on the wrong side; positions in a pixel (1 / 11 of the ramp) add as
  // little.
  EXPECT_LT(largest, 0.03);
}

}  // namespace
}  // namespace myrialux
