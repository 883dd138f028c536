// Multidimensional lightcuts against brute force on the same receivers and lights.
#include <gtest/gtest.h>

#include <cmath>

#include "myrialux/base/parallel.h"
#include "myrialux/methods/render.h"
#include "support/build_scene.h"
#include "support/statistics.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

/// Receivers and lights of a small frame, traced once.
struct SmallFrame {
  test::TestWorld world;
  int size, spp;
  Receivers receivers;
  VirtualLights lights;
  MethodParams params;

  SmallFrame(Scene scene, std::uint64_t n_lights, int size_, int spp_)
      : world(std::move(scene)), size(size_), spp(spp_) {
    Progress silent;
    receivers = trace_receivers(world.world, {.width = size, .height = size, .spp = spp, .key = {3}}, silent).receivers;
    lights = trace_lights(world.world, {.n_lights = n_lights, .direct = true, .key = {3}}, silent).lights;
    params.cut.clamp_distance = 0.05f;
    params.cut.n_clusters = 1u << 30;
    params.key = params.tree.key = {3};
  }
  std::vector<Rgb> radiance(const char* method, RenderStats& stats) const {
    Progress silent;
    const float radius = 0.5f * world.scene.bounds().diagonal();
    const FrameView view{world.world, receivers, lights, radius, spp};
    return find_method(method).render(view, params, silent, stats).radiance;
  }
  /// Means over the samples of each pixel, as a box filter has them.
  std::vector<Rgb> pixels(const char* method, RenderStats& stats) const {
    const std::vector<Rgb> of_receiver = radiance(method, stats);
    std::vector<Rgb> pixels(static_cast<std::size_t>(size * size));
    for (std::size_t i = 0; i < receivers.size(); ++i)
      pixels[receivers.sample[i] / static_cast<std::uint32_t>(spp)] +=
          receivers.beta[i] * of_receiver[i] * (1 / static_cast<float>(spp));
    return pixels;
  }
  std::vector<Rgb> pixels(const char* method) const {
    RenderStats stats;
    return pixels(method, stats);
  }
};

/// Root mean square difference over the mean of the reference, luminance.
double relative_rmse(const std::vector<Rgb>& reference, const std::vector<Rgb>& image) {
  double squares = 0, sum = 0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const double d = luminance(image[i]) - luminance(reference[i]);
    squares += d * d, sum += luminance(reference[i]);
  }
  const double n = static_cast<double>(reference.size());
  return std::sqrt(squares / n) / (sum / n);
}

TEST(Mdlc, WithoutThresholdEqualsBruteForceAtEveryReceiver) {
  for (const bool glossy : {false, true}) {
    SmallFrame f(glossy ? test::glossy_floor_box(0.3f) : test::cornell_box(), 120, 8, 4);
    f.params.mdlc_error = 0;
    RenderStats exact, all;
    const std::vector<Rgb> reference = f.radiance("brute-force", exact), radiance = f.radiance("mdlc", all);
    // Sums of 120 terms in another order.
    EXPECT_LT(relative_rmse(reference, radiance), 120 * 6e-8);
    EXPECT_EQ(all.rays.shadow, exact.rays.shadow);
  }
}

TEST(Mdlc, WithoutThresholdEqualsBruteForceWherePathsWeighDifferently) {
  // Varnish: receivers on the floor and behind it, with the chance of either in their weight.
  SmallFrame f(test::plastic_floor_box(), 120, 8, 4);
  bool differ = false;
  for (const Rgb& beta : f.receivers.beta) differ |= !(beta == f.receivers.beta[0]);
  ASSERT_TRUE(differ);
  f.params.mdlc_error = 0;
  EXPECT_LT(relative_rmse(f.pixels("brute-force"), f.pixels("mdlc")), 120 * 6e-8);
}

TEST(Mdlc, ErrorFallsAsTheThresholdTightens) {
  SmallFrame f(test::glossy_floor_box(0.3f), 3000, 12, 16);
  const std::vector<Rgb> truth = f.pixels("brute-force");
  double last = 1e9;
  for (const float threshold : {0.5f, 0.1f, 0.02f, 0.004f}) {
    f.params.mdlc_error = threshold;
    RenderStats stats;
    const double error = relative_rmse(truth, f.pixels("mdlc", stats));
    std::printf("threshold %g: error %.4f, %.1f pairs of %.0f a pixel\n", double(threshold), error, stats.clusters_mean,
                16.0 * double(f.lights.size()));
    EXPECT_LT(error, last) << threshold;
    last = error;
  }
  EXPECT_LT(last, 0.054);  // measured: 0.237, 0.131, 0.074, 0.035; half above the last
}

TEST(Mdlc, ErrorFallsAsCutsGrow) {
  SmallFrame f(test::cornell_box(), 3000, 12, 16);
  f.params.mdlc_error = 0;
  const std::vector<Rgb> truth = f.pixels("brute-force");
  double last = 1e9;
  for (const std::uint32_t n : {10u, 60u, 360u, 2160u}) {
    f.params.cut.n_clusters = n;
    RenderStats stats;
    const double error = relative_rmse(truth, f.pixels("mdlc", stats));
    std::printf("%u pairs: error %.4f\n", n, error);
    EXPECT_LT(error, last) << n;
    EXPECT_LE(stats.clusters_mean, n);
    EXPECT_LE(stats.rays.shadow, stats.visibility.entries);
    last = error;
  }
  EXPECT_LT(last, 0.028);  // measured: 0.461, 0.257, 0.079, 0.018; half above the last
}

/// Cuts of a fixed size depend on bounds alone, so that representatives drawn anew average out.
TEST(Mdlc, CutsOfFixedSizeAreUnbiased) {
  SmallFrame f(test::plastic_floor_box(), 300, 4, 4);
  f.params.mdlc_error = 0;
  f.params.cut.n_clusters = 20;
  double expected = 0;
  for (const Rgb& c : f.pixels("brute-force")) expected += luminance(c);
  test::Sample sums;
  for (std::uint32_t pass = 0; pass < 400; ++pass) {
    f.params.key = f.params.tree.key = {11, pass};
    double sum = 0;
    for (const Rgb& c : f.pixels("mdlc")) sum += luminance(c);
    sums.add(sum);
  }
  EXPECT_LT(std::fabs(test::z_score(sums, expected)), 4);
}

TEST(Mdlc, SameBitsForAnyNumberOfThreads) {
  SmallFrame f(test::plastic_floor_box(), 500, 8, 4);
  f.params.cut.n_clusters = 100;
  std::vector<Rgb> first;
  for (const int n_threads : {1, 2, 7}) {
    const ThreadScope threads(n_threads);
    RenderStats stats;
    const std::vector<Rgb> radiance = f.radiance("mdlc", stats);
    if (first.empty()) first = radiance;
    EXPECT_EQ(radiance, first) << n_threads << " threads";
  }
}

TEST(Mdlc, PixelsWithoutReceiversAreBlackAndOthersUnaffected) {
  Scene scene = test::cornell_box();
  scene.camera.fov_x_deg = 80;  // beyond the box there is nothing
  SmallFrame f(std::move(scene), 100, 10, 3);
  f.params.mdlc_error = 0;
  ASSERT_LT(f.receivers.size(), 200u);
  ASSERT_GT(f.receivers.size(), 0u);
  const std::vector<Rgb> pixels = f.pixels("mdlc");
  EXPECT_TRUE(is_black(pixels[0]));
  EXPECT_LT(relative_rmse(f.pixels("brute-force"), pixels), 100 * 6e-8);
}

/// The Cornell box seen by a moving camera with a lens: a pixel's receivers are strewn and seen from many places.
Scene blurred(Scene scene) {
  Camera& camera = scene.camera;
  camera.aperture_radius = 0.4f, camera.focus_distance = 3.5f;
  camera.motion = {{0, camera.to_world},
                   {1, Transform::translate({0.4f, 0.1f, 0}) * camera.to_world * Transform::rotate({0, 1, 1}, 6)}};
  camera.shutter_close = 1;
  return scene;
}

TEST(Mdlc, WithoutThresholdEqualsBruteForceUnderDepthOfFieldAndMotion) {
  for (const bool glossy : {false, true}) {
    SmallFrame f(blurred(glossy ? test::glossy_floor_box(0.3f) : test::plastic_floor_box()), 60, 6, 16);
    f.params.mdlc_error = 0;
    EXPECT_LT(relative_rmse(f.pixels("brute-force"), f.pixels("mdlc")), 60 * 6e-8);
  }
}

TEST(Mdlc, ErrorFallsAsTheThresholdTightensUnderDepthOfFieldAndMotion) {
  SmallFrame f(blurred(test::glossy_floor_box(0.3f)), 1000, 8, 64);
  const std::vector<Rgb> truth = f.pixels("brute-force");
  double last = 1e9;
  for (const float threshold : {0.5f, 0.1f, 0.02f, 0.004f}) {
    f.params.mdlc_error = threshold;
    RenderStats stats;
    const double error = relative_rmse(truth, f.pixels("mdlc", stats));
    std::printf("threshold %g: error %.4f, %.1f pairs of %.0f a pixel\n", double(threshold), error, stats.clusters_mean,
                64.0 * double(f.lights.size()));
    EXPECT_LT(error, last) << threshold;
    last = error;
  }
  EXPECT_LT(last, 0.048);  // measured: 0.258, 0.121, 0.071, 0.032; half above the last
}

TEST(Mdlc, PixelsGivenInPartsHaveTheSameBits) {
  SmallFrame f(blurred(test::plastic_floor_box()), 300, 8, 16);
  RenderStats whole_stats, part_stats;
  const std::vector<Rgb> whole = f.radiance("mdlc", whole_stats);
  Progress silent;
  const float radius = 0.5f * f.world.scene.bounds().diagonal();
  const MethodInfo& method = find_method("mdlc");
  const Method of_part = method.prepare(f.world.world, f.lights, radius, f.params, silent, part_stats);
  std::vector<Rgb> parts;
  int last = 0;
  for (const int y : {1, 4, 8}) {
    const Receivers rows =
        trace_receiver_rows(f.world.world, {.width = 8, .height = 8, .spp = 16, .key = {3}}, last, y, silent).receivers;
    const auto part = of_part({f.world.world, rows, f.lights, radius, 16}, f.params, silent, part_stats).radiance;
    parts.insert(parts.end(), part.begin(), part.end());
    last = y;
  }
  EXPECT_EQ(parts, whole);
  EXPECT_EQ(part_stats.clusters_mean, whole_stats.clusters_mean);
}

TEST(Mdlc, NoLightsOrNoReceiversGiveNothing) {
  SmallFrame f(test::cornell_box(), 100, 4, 2);
  const VirtualLights lights = std::exchange(f.lights, {});
  for (const Rgb& c : f.pixels("mdlc")) EXPECT_TRUE(is_black(c));
  f.lights = lights;
  f.receivers = {};
  RenderStats stats;
  EXPECT_TRUE(f.radiance("mdlc", stats).empty());
}

}  // namespace
}  // namespace myrialux
