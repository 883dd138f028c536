// Thin lens: where its samples fall, and where rays through it meet.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "myrialux/receivers/receivers.h"
#include "support/build_scene.h"
#include "support/chi_square.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

constexpr float kRadius = 0.3f, kFocus = 4, kFov = 50;
constexpr int kWidth = 40, kHeight = 30;
const double kLevel = testing::chi_square_level(6);

Camera lens_camera() {
  Camera camera;
  camera.to_world = Transform::look_at({1, 2, 3}, {-1, 0.5f, -2}, {0, 1, 0});
  camera.fov_x_deg = kFov;
  camera.aperture_radius = kRadius, camera.focus_distance = kFocus;
  return camera;
}

/// Where a ray is at a distance along the view, in camera space.
Vec3 at_depth(const Camera& camera, const Ray& ray, float depth) {
  const Transform to_camera = camera.to_world.inverse();
  const Vec3 o = to_camera.point(ray.origin), d = to_camera.vector(ray.direction);
  return o + d * ((depth - o.z) / d.z);
}

TEST(Lens, SamplesAreUniformOverTheDisc) {
  for (const int spp : {1, 7, 16}) {
    for (const int k : {0, spp - 1}) {
      constexpr std::size_t kCells = 16;
      constexpr std::uint64_t kPixels = 40000;
      std::vector<double> observed(kCells * kCells), expected(kCells * kCells, double{kPixels} / (kCells * kCells));
      for (std::uint64_t pixel = 0; pixel < kPixels; ++pixel) {
        const Vec2 p = camera_sample(lens_camera(), 100, pixel, k, spp, {4, 2}).lens;
        const auto cell = [](float t) {
          return std::min(kCells - 1, static_cast<std::size_t>(std::max(0.0f, t) * kCells));
        };
        const float angle = std::atan2(p.y, p.x) / (2 * kPi) + 0.5f;
        observed[cell(p.x * p.x + p.y * p.y) * kCells + cell(angle)] += 1;
      }
      const testing::ChiSquareResult fit = testing::chi_square_counts(observed, expected);
      EXPECT_GE(fit.p_value, kLevel) << spp << " samples, number " << k << ": " << fit.message;
    }
  }
}

std::size_t quadrant(Vec2 p) { return (p.x < 0 ? 0u : 1u) + (p.y < 0 ? 0u : 2u); }

/// The concentric map takes quarters of the square to quarters of the disc.
TEST(Lens, EveryQuarterHoldsOneOfFourSamplesWhateverTheQuarterOfThePixel) {
  constexpr std::uint64_t kPixels = 20000;
  std::vector<double> observed(16), expected(16, kPixels * 4.0 / 16);
  for (std::uint64_t pixel = 0; pixel < kPixels; ++pixel) {
    unsigned seen = 0;
    for (int k = 0; k < 4; ++k) {
      const CameraSample s = camera_sample(lens_camera(), 1, pixel, k, 4, {8, 0});
      seen |= 1u << quadrant(s.lens);
      const float y = static_cast<float>(pixel);
      observed[4 * quadrant(s.lens) + quadrant({s.film.x - 0.5f, s.film.y - y - 0.5f})] += 1;
    }
    ASSERT_EQ(seen, 15u) << pixel;
  }
  // The four samples of a pixel exclude each other: counts scatter less than independent ones, which the level is for.
  EXPECT_GE(testing::chi_square_counts(observed, expected).p_value, 1e-3);
}

TEST(Lens, PinholesDrawNoLensAndLensesLeaveTheFilmAlone) {
  Camera pinhole = lens_camera();
  pinhole.aperture_radius = 0;
  for (int k = 0; k < 9; ++k) {
    const CameraSample with = camera_sample(lens_camera(), 5, 13, k, 9, {3, 1}),
                       without = camera_sample(pinhole, 5, 13, k, 9, {3, 1});
    EXPECT_EQ(with.film.x, without.film.x);
    EXPECT_EQ(with.film.y, without.film.y);
    EXPECT_EQ(film_position(5, 13, k, 9, {3, 1}).x, without.film.x);
    EXPECT_EQ(without.lens.x, 0);
    EXPECT_EQ(without.lens.y, 0);
    EXPECT_EQ(lens_point(pinhole, without), pinhole.to_world.point({}));
  }
}

TEST(Lens, RaysOfAFilmPositionMeetInTheFocusPlaneWhereThePinholeSeesIt) {
  const Camera camera = lens_camera();
  Camera pinhole = camera;
  pinhole.aperture_radius = 0;
  for (const Vec2 film : {Vec2{20, 15}, Vec2{0.5f, 29}, Vec2{39, 3}}) {
    const Vec3 seen = at_depth(pinhole, camera_ray(pinhole, kWidth, kHeight, {film}), kFocus);
    for (const Vec2 lens : {Vec2{1, 0}, Vec2{-0.3f, 0.8f}, Vec2{0, -1}, Vec2{}}) {
      const Ray ray = camera_ray(camera, kWidth, kHeight, {film, lens});
      EXPECT_LT(length(at_depth(camera, ray, kFocus) - seen), 2e-5f);  // a few roundings at distance 4
      const Vec3 start = at_depth(camera, ray, 0);
      EXPECT_LT(length(start - Vec3{kRadius * lens.x, kRadius * lens.y, 0}), 2e-6f);
      EXPECT_NEAR(length(ray.direction), 1, 1e-6f);
      EXPECT_NEAR(at_depth(camera, ray, camera.near_clip).z, camera.near_clip, 1e-6f);
    }
  }
}

/// Film position, pixels, at which a point of the axis shows through one point of the lens.
float film_x_of(const Camera& camera, float depth, Vec2 lens) {
  float low = -kWidth, high = 2 * kWidth;  // +x of the camera is the picture's left: x at the depth falls
  for (int i = 0; i < 40; ++i) {
    const float middle = 0.5f * (low + high);
    const Ray ray = camera_ray(camera, kWidth, kHeight, {{middle, 0.5f * kHeight}, lens});
    (at_depth(camera, ray, depth).x > 0 ? low : high) = middle;
  }
  return 0.5f * (low + high);
}

TEST(Lens, BlurOfAPointIsThatOfTheThinLens) {
  const Camera camera = lens_camera();
  const float half = std::tan(kFov * kPi / 360);
  for (const float depth : {1.0f, 2.0f, 3.9f, 4.0f, 6.0f, 20.0f}) {
    const float diameter = std::fabs(film_x_of(camera, depth, {1, 0}) - film_x_of(camera, depth, {-1, 0}));
    // The cone from lens to point cuts the focus plane in a disc of diameter 2 r |d - f| / d; the film shows
    // 2 f tan(fov / 2) of that plane on its width.
    const float expected = 2 * kRadius * std::fabs(depth - kFocus) / depth * kWidth / (2 * kFocus * half);
    EXPECT_NEAR(diameter, expected, 2e-4f) << "at depth " << depth;
  }
}

TEST(Lens, DepthIsMeasuredFromThePointOfTheLens) {
  test::SceneBuilder b;
  b.rectangle({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, b.diffuse(gray(0.5f)));
  b.emitter("sky", ConstantEmitter{gray(1)});
  b.camera({0, 0, 5}, {0, 0, 0}, 30, 8, 8);
  b.scene.camera.aperture_radius = 0.5f, b.scene.camera.focus_distance = 2;
  test::TestWorld t(b.scene);
  Progress quiet;
  const ReceiverResult r = trace_receivers(t.world, {.width = 8, .height = 8, .spp = 4, .key = {1, 0}}, quiet);
  ASSERT_EQ(r.receivers.size(), 256u);
  for (std::size_t i = 0; i < r.receivers.size(); ++i) {
    const CameraSample s = camera_sample(t.scene.camera, 8, i / 4, static_cast<int>(i % 4), 4, {1, 0});
    EXPECT_NEAR(r.samples.depth[i], length(r.receivers.p[i] - lens_point(t.scene.camera, s)), 1e-5f);
  }
}

}  // namespace
}  // namespace myrialux
