// Whole frames: many-light pictures against the path tracer, determinism, limits, keys.
#include "myrialux/pipeline/pipeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "myrialux/pipeline/frame_state.h"
#include "support/build_scene.h"

namespace myrialux {
namespace {

RenderParams small(const char* method) {
  RenderParams p;
  p.method = method;
  p.width = p.height = 16;
  p.spp = 4;
  p.n_lights = 2000;
  p.n_clusters = 300;
  p.max_depth = 6;
  p.threads = 2;
  return p;
}

std::vector<float> beauty(const Scene& scene, const RenderParams& params) {
  Progress silent;
  return render(scene, params, silent).picture.find("")->pixels;
}

struct Moments {
  double mean = 0, standard_error = 0;
};
/// Mean over pixels and channels, with its standard error from runs of different seeds.
Moments picture_mean(const Scene& scene, RenderParams params, int n_runs) {
  double sum = 0, squares = 0;
  for (int run = 0; run < n_runs; ++run) {
    params.seed = 100 + static_cast<std::uint64_t>(run);
    double mean = 0;
    const std::vector<float> pixels = beauty(scene, params);
    for (const float v : pixels) mean += v;
    mean /= static_cast<double>(pixels.size());
    sum += mean, squares += mean * mean;
  }
  const double mean = sum / n_runs, variance = (squares / n_runs - mean * mean) * n_runs / (n_runs - 1);
  return {mean, std::sqrt(std::max(0.0, variance) / n_runs)};
}

void expect_equal_means(const Scene& scene, const RenderParams& a, const RenderParams& b, int n_runs) {
  const Moments x = picture_mean(scene, a, n_runs), y = picture_mean(scene, b, n_runs);
  const double z = (x.mean - y.mean) / std::hypot(x.standard_error, y.standard_error);
  // Two-sided 1e-4 level of Student's t with about 2 * n_runs - 2 = 30 degrees of freedom.
  EXPECT_LT(std::fabs(z), 4.48) << a.method << " " << x.mean << " +- " << x.standard_error << ", " << b.method << " "
                                << y.mean << " +- " << y.standard_error;
}

class ManyLightsAgreeWithPath : public testing::TestWithParam<std::tuple<const char*, RenderParams::Direct, float>> {};

TEST_P(ManyLightsAgreeWithPath, InTheMeanOnCornellGlassAndGloss) {
  const auto [method, direct, clamp] = GetParam();
  for (const Scene& scene : {test::cornell_box(), test::glass_pane_box(), test::glossy_floor_box(0.2f)}) {
    RenderParams params = small(method);
    params.direct = direct, params.clamp = clamp;
    RenderParams reference = small("path");
    reference.spp = 64;
    expect_equal_means(scene, params, reference, 16);
  }
}

INSTANTIATE_TEST_SUITE_P(Pipeline, ManyLightsAgreeWithPath,
                         testing::Combine(testing::Values("brute-force", "slice-lightcuts"),
                                          testing::Values(RenderParams::Direct::vpl, RenderParams::Direct::sampled),
                                          testing::Values(0.02f, 0.1f)));

TEST(Pipeline, SameBitsForAnyNumberOfThreads) {
  const Scene scene = test::glass_pane_box();
  for (const char* method : {"bamc", "path"}) {
    RenderParams p = small(method);
    p.threads = 1;
    const std::vector<float> one = beauty(scene, p);
    for (const int n : {2, 7}) {
      p.threads = n;
      EXPECT_EQ(beauty(scene, p), one) << method << " with " << n << " threads";
    }
    p.seed = 1;
    EXPECT_NE(beauty(scene, p), one) << "another seed must give another picture";
  }
}

TEST(Pipeline, DoubledEmissionDoublesThePicture) {
  test::CornellOptions bright;
  bright.lamp = {36, 30, 20};
  const std::vector<float> once = beauty(test::cornell_box(), small("bamc"));
  const std::vector<float> twice = beauty(test::cornell_builder(bright).scene, small("bamc"));
  ASSERT_EQ(once.size(), twice.size());
  for (std::size_t i = 0; i < once.size(); ++i) EXPECT_FLOAT_EQ(2 * once[i], twice[i]);
}

TEST(Pipeline, PassesAverage) {
  RenderParams p = small("slice-lightcuts");
  p.passes = 3;
  Progress silent;
  const RenderOutput out = render(test::cornell_box(), p, silent);
  EXPECT_EQ(out.stats.passes, 3u);
  for (const float v : out.picture.find("")->pixels) EXPECT_TRUE(std::isfinite(v));
  // The picture of one pass, but for rounding, if all passes drew the same numbers.
  p.passes = 1;
  const std::vector<float> first = beauty(test::cornell_box(), p), &mean = out.picture.find("")->pixels;
  std::size_t n_differ = 0;
  for (std::size_t i = 0; i < first.size(); ++i) n_differ += std::fabs(first[i] - mean[i]) > 0.001f * mean[i];
  EXPECT_GT(n_differ, first.size() / 2);
}

TEST(Pipeline, SampledDirectLightCountsOnceWithAndWithoutResidual) {
  // Inside a glowing sphere emitter samples and the residual's paths find the light about equally often: 1 is seen, and
  // one bounce adds the albedo.
  RenderParams p = small("brute-force");
  p.direct = RenderParams::Direct::sampled, p.max_depth = 2;
  for (const bool residual : {false, true}) {
    p.residual = residual;
    const Moments m = picture_mean(test::furnace_sphere(0.6f), p, 8);
    EXPECT_NEAR(m.mean, 1.6, 6 * m.standard_error + 1e-6) << "residual " << residual;  // t of 7: level 5e-4; rounding
    EXPECT_LT(m.standard_error, 0.01);
  }
}

TEST(Pipeline, LayersAreThere) {
  Progress silent;
  const RenderOutput out = render(test::cornell_box(), small("bamc"), silent);
  for (const char* layer : {"", "albedo", "normal", "depth", "slice", "cut", "visibility"})
    EXPECT_NE(out.picture.find(layer), nullptr) << layer;
  RenderParams few = small("bamc");
  few.aovs = {"albedo"};
  EXPECT_EQ(render(test::cornell_box(), few, silent).picture.layers.size(), 2u);
}

TEST(Pipeline, ErrorLayerIsThereWhereItIsMeasured) {
  Progress silent;
  RenderParams p = small("lbamc");
  p.width = p.height = 48, p.spp = 2, p.extra["slices.rows"] = "256";  // 18 slices
  p.visibility_error = 0.02f;
  const RenderOutput out = render(test::cornell_box(), p, silent);
  const Picture::Layer* error = out.picture.find("error");
  ASSERT_NE(error, nullptr);
  EXPECT_EQ(out.picture.n_channels(), FrameState::n_channels({}, true, true));
  EXPECT_GE(*std::min_element(error->pixels.begin(), error->pixels.end()), 0);
  // The meter's mean square is that over receivers, of which the layer shows the roots: their mean is no larger. Pixels
  // at the edge of the box have one receiver in place of two, but count as much.
  double mean = 0;
  for (const float e : error->pixels) mean += static_cast<double>(e) / static_cast<double>(error->pixels.size());
  const double root = std::sqrt(out.stats.visibility.meter.error_square);
  EXPECT_LT(mean, 1.05 * root);
  EXPECT_GT(mean, 0.3 * root);

  p.visibility_error = 0;
  EXPECT_EQ(render(test::cornell_box(), p, silent).picture.find("error"), nullptr);
  EXPECT_EQ(FrameState::n_channels({"error"}, true, false), 3u);
  EXPECT_EQ(FrameState::n_channels({"error"}, true, true), 4u);
}

TEST(Pipeline, ErrorOfVisibilityIsRefusedByMethodsThatDoNotKeepToIt) {
  RenderParams p = small("bamc");
  p.visibility_error = 0.01f;
  Progress silent;
  EXPECT_THROW(render(test::cornell_box(), p, silent), Error);
}

TEST(Pipeline, MemoryLimitIsRefusedBeforeTheWorkWithARemedy) {
  RenderParams p = small("bamc");
  p.width = p.height = 2048;
  p.memory_limit = 2u << 30;
  Progress silent;
  try {
    render(test::cornell_box(), p, silent);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::limit);
    for (const char* part : {"--spp 2 --passes 2", "--size 1", "allows 2048 MiB"})
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << part << "\n" << e.what();
  }
}

TEST(Pipeline, UnknownKeyNamesTheNearest) {
  RenderParams p = small("bamc");
  p.extra["bamc.alhpa"] = "0.1";
  Progress silent;
  try {
    render(test::cornell_box(), p, silent);
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "-D bamc.alhpa: no such key; did you mean bamc.alpha?");
  }
}

TEST(Pipeline, BadValueNamesWhatIsAllowed) {
  RenderParams p = small("bamc");
  p.extra["bamc.alpha"] = "nan";
  Progress silent;
  EXPECT_THROW(render(test::cornell_box(), p, silent), Error);
}

TEST(Pipeline, CameraInsideAnObjectWarns) {
  test::SceneBuilder b = test::cornell_builder();
  b.box({-0.1f, -0.1f, 3.7f}, {0.1f, 0.1f, 3.9f}, MaterialId{0});
  Progress silent;
  const RenderOutput out = render(b.scene, small("bamc"), silent);
  ASSERT_FALSE(out.stats.warnings.empty());
  EXPECT_NE(out.stats.warnings.back().find("inside a wall"), std::string::npos);
}

}  // namespace
}  // namespace myrialux
