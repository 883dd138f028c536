// Virtual lights by brute force plus residual equal the path tracer in the mean, in all four corners of the picture.
#include <gtest/gtest.h>

#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "myrialux/base/parallel.h"
#include "myrialux/reference/brute_force.h"
#include "myrialux/reference/path_tracer.h"
#include "support/build_scene.h"
#include "support/statistics.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

using test::Sample;
using test::TestWorld;
using test::z_score;

constexpr int kSize = 8;                 // pixels across
using Quarters = std::array<Sample, 5>;  // mean radiance of the whole picture and of its four quarters

void add_picture(Quarters& quarters, std::span<const Rgb> radiance, int spp) {
  std::array<double, 5> sums{};
  for (std::size_t s = 0; s < radiance.size(); ++s) {
    EXPECT_TRUE(is_finite(radiance[s]));
    const auto pixel = static_cast<int>(s) / spp;
    const int quarter = (pixel % kSize) / (kSize / 2) + 2 * (pixel / kSize / (kSize / 2));
    const auto value = static_cast<double>(mean(radiance[s]));
    sums[0] += value / static_cast<double>(radiance.size());
    sums[static_cast<std::size_t>(quarter) + 1] += 4 * value / static_cast<double>(radiance.size());
  }
  for (std::size_t k = 0; k < 5; ++k) quarters[k].add(sums[k]);
}

struct Join {
  float clamp_distance = 0;
  bool direct_by_sampling = false, residual = true;
};

Quarters by_virtual_lights(const World& world, const Join& join, int n_pictures, std::uint64_t n_lights) {
  Quarters quarters;
  Progress quiet;
  PathCounters counters;
  for (int k = 0; k < n_pictures; ++k) {
    const RandomKey key{21, static_cast<std::uint32_t>(k)};
    const ReceiverResult rows = trace_receivers(world, {.width = kSize, .height = kSize, .spp = 1, .key = key}, quiet);
    const LightResult columns =
        trace_lights(world, {.n_lights = n_lights, .direct = !join.direct_by_sampling, .key = key}, quiet);
    std::vector<Rgb> from_lights(rows.receivers.size());
    brute_force(world, rows.receivers, columns.lights, join.clamp_distance, from_lights, quiet);
    Array<Rgb> picture = rows.samples.emission;
    for (std::size_t i = 0; i < rows.receivers.size(); ++i) {
      const Vertex vertex = receiver_vertex(world, rows.receivers, i);
      Rng direct(key, Stage::direct, i), rest(key, Stage::residual, i);
      Rgb radiance = from_lights[i];
      if (join.direct_by_sampling) radiance += next_event(world, vertex, Lobes::wide, join.residual, direct, counters);
      const ResidualParams params{.clamp_distance = join.clamp_distance,
                                  .direct_by_sampling = join.direct_by_sampling,
                                  .depth = rows.receivers.depth[i]};
      if (join.residual) radiance += residual_radiance(world, vertex, params, rest, counters);
      picture[rows.receivers.sample[i]] += rows.receivers.beta[i] * radiance;
    }
    add_picture(quarters, picture, 1);
  }
  return quarters;
}

Quarters by_paths(const World& world, int n_pictures) {
  Quarters quarters;
  Progress quiet;
  for (int k = 0; k < n_pictures; ++k) {
    const ReceiverParams params{.width = kSize, .height = kSize, .spp = 16, .key = {22, static_cast<std::uint32_t>(k)}};
    add_picture(quarters, trace_paths(world, params, quiet).radiance, 16);
  }
  return quarters;
}

/// @param most_noise largest standard error relative to the mean with which equality still says something
void expect_equal(const Quarters& a, const Quarters& b, double most_noise, const std::string& what) {
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_LT(std::fabs(z_score(a[k], b[k])), 4) << what << ", part " << k << ": " << a[k].mean << " and " << b[k].mean;
    const double error = std::sqrt(a[k].variance_of_mean() + b[k].variance_of_mean());
    EXPECT_LT(error, most_noise * b[k].mean) << what << ", part " << k << ": too noisy to tell anything";
  }
}

/// Scenes with every kind of lobe and emitter.
struct Case {
  const char* name;
  Scene scene;
};
Scene rough_glass_ball() {
  test::SceneBuilder b = test::cornell_builder({.objects = false, .lamp = {18, 15, 10}, .floor = nullptr});
  Material glass;
  glass.kind = BsdfKind::rough_dielectric;
  glass.distribution = Microfacets::ggx;
  glass.eta = 1.5f;
  glass.alpha = glass.alpha_v = {gray(0.4f)};
  b.sphere({0, -0.3f, 0.2f}, 0.5f, b.add(glass));
  return std::move(b.scene);
}
Scene sky_sun_bulb_and_spot() {
  test::SceneBuilder b = test::cornell_builder({.objects = true, .lamp = {2, 2, 2}, .floor = nullptr});
  b.emitter("sky", ConstantEmitter{gray(0.5f)});
  b.emitter("sun", DirectionalEmitter{normalize({0.2f, -0.3f, -1}), gray(2)});
  b.emitter("bulb", PointEmitter{{0.2f, 0.3f, 0.4f}, gray(1)});
  SpotEmitter spot;
  spot.to_world = Transform::look_at({0.5f, 0.8f, 0.4f}, {-0.2f, -1, 0}, {1, 0, 0});
  spot.intensity = gray(3);
  spot.cutoff_deg = 35;
  b.emitter("spot", spot);
  return std::move(b.scene);
}
/// A coarse ball with smooth normals, seen and lighting its surroundings.
Scene smooth_ball(const Material& material) {
  test::SceneBuilder b = test::cornell_builder({.objects = false, .lamp = {18, 15, 10}, .floor = nullptr});
  b.smooth_ball({0, -0.4f, 0.2f}, 0.55f, 1, b.add(material));
  return std::move(b.scene);
}
Scene smooth_diffuse_ball() {
  Material paint;
  paint.reflectance = {gray(0.8f)};
  return smooth_ball(paint);
}
Scene smooth_metal_ball() {
  Material metal;
  metal.kind = BsdfKind::rough_conductor;
  metal.distribution = Microfacets::ggx;
  metal.alpha = metal.alpha_v = {gray(0.4f)};
  return smooth_ball(metal);
}
std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"CornellBox", test::cornell_box()});
  all.push_back({"GlassPane", test::glass_pane_box()});
  all.push_back({"RoughMetalFloor", test::glossy_floor_box(0.3f)});
  all.push_back({"NearMirrorFloor", test::glossy_floor_box(0.08f)});
  all.push_back({"VarnishedFloor", test::plastic_floor_box()});
  all.push_back({"BlinnPhongFloor", test::blinn_phong_floor_box(30)});
  all.push_back({"ShinyBlinnPhongFloor", test::blinn_phong_floor_box(1000)});
  all.push_back({"RoughGlassBall", rough_glass_ball()});
  all.push_back({"SmoothDiffuseBall", smooth_diffuse_ball()});
  all.push_back({"SmoothMetalBall", smooth_metal_ball()});
  all.push_back({"SkySunBulbSpot", sky_sun_bulb_and_spot()});
  return all;
}

/// Both ways to carry direct light, clamped a little and nearly everywhere (the scene is 2 across).
void expect_virtual_lights_equal_paths(Case c, int n_pictures, double most_noise) {
  TestWorld t(std::move(c.scene), 8);  // long enough that the excess of deep receivers is below the noise
  const Quarters paths = by_paths(t.world, n_pictures);
  for (const bool sampled : {false, true})
    for (const float clamp : {0.3f, 1.5f}) {
      const Join join{.clamp_distance = clamp, .direct_by_sampling = sampled};
      expect_equal(by_virtual_lights(t.world, join, n_pictures, 100), paths, most_noise,
                   std::string(c.name) + (sampled ? ", sampled" : ", vpl") + ", clamp " + std::to_string(clamp));
    }
}

class VirtualLightsEqualPathsOn : public testing::TestWithParam<std::size_t> {};
TEST_P(VirtualLightsEqualPathsOn, InTheMean) {
  expect_virtual_lights_equal_paths(std::move(cases()[GetParam()]), 80, 0.2);
}
TEST_P(VirtualLightsEqualPathsOn, SlowInTheMean) {
  expect_virtual_lights_equal_paths(std::move(cases()[GetParam()]), 1000, 0.05);
}
INSTANTIATE_TEST_SUITE_P(AllCases, VirtualLightsEqualPathsOn, testing::Range<std::size_t>(0, cases().size()),
                         [](const auto& one) { return std::string(cases()[one.param].name); });

// Inside a sphere 1 / d^2 stays bounded from below for the receiver's cosines: G = 1 / (4 R^2), so nothing need be
// clamped.
TEST(VirtualLightsEqualPaths, UnclampedFurnaceGivesTheGeometricSeries) {
  const float albedo = 0.5f;
  for (const int max_depth : {2, 3, 6}) {
    TestWorld t(test::furnace_sphere(albedo), max_depth);
    double expected = 0;
    for (int k = 0; k < max_depth; ++k) expected += std::pow(static_cast<double>(albedo), k);
    for (const bool residual : {false, true}) {
      const Quarters lights = by_virtual_lights(t.world, {.residual = residual}, 60, 50);
      for (const Sample& s : lights) {
        if (max_depth == 2)
          EXPECT_NEAR(s.mean, expected, 1e-3);  // every light of bounce 0 gives the same; some near pairs lose digits
        else
          EXPECT_LT(std::fabs(z_score(s, expected)), 4) << "depth " << max_depth << ": " << s.mean;
      }
    }
  }
}

TEST(VirtualLightsEqualPaths, UnclampedSphereWithAMirrorAndAGlassBall) {
  for (const BsdfKind kind : {BsdfKind::conductor, BsdfKind::dielectric}) {
    test::SceneBuilder b;
    b.area_emitter(b.sphere({0, 0, 0}, 1, b.diffuse({0.3f, 0.5f, 0.7f}), true), gray(1));
    Material ball;
    ball.kind = kind;
    ball.specular = {gray(kind == BsdfKind::conductor ? 0.5f : 1)};
    b.sphere({0, 0, -0.3f}, 0.4f, b.add(ball));
    b.camera({0, 0, 0.8f}, {0, 0.1f, -1}, 80, kSize, kSize);
    TestWorld t(b.scene, 9);
    const Quarters paths = by_paths(t.world, 60);
    for (const bool sampled : {false, true})
      expect_equal(by_virtual_lights(t.world, {.direct_by_sampling = sampled}, 120, 60), paths, 0.1,
                   std::string(kind == BsdfKind::conductor ? "mirror" : "glass") + (sampled ? ", sampled" : ", vpl"));
  }
}

TEST(VirtualLightsEqualPaths, LeavingOutTheResidualIsCaught) {
  TestWorld t(test::glass_pane_box(), 8);
  const Quarters paths = by_paths(t.world, 100);
  const Quarters without = by_virtual_lights(t.world, {.clamp_distance = 0.3f, .residual = false}, 100, 100);
  EXPECT_LT(z_score(without[0], paths[0]), -4);
}

}  // namespace
}  // namespace myrialux
