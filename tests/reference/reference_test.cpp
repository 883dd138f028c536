// Brute force and path-traced frames: every entry counted, error bars that hold, independence of threads.
#include <gtest/gtest.h>

#include <cstring>

#include "myrialux/base/parallel.h"
#include "myrialux/reference/brute_force.h"
#include "myrialux/reference/path_tracer.h"
#include "support/build_scene.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

using test::TestWorld;

TEST(BruteForce, EqualsTheSumOverEntriesOneByOne) {
  TestWorld t(test::glossy_floor_box(0.3f));
  Progress quiet;
  const Receivers rows = trace_receivers(t.world, {.width = 7, .height = 5, .spp = 1, .key = {1, 0}}, quiet).receivers;
  const VirtualLights lights = trace_lights(t.world, {.n_lights = 150, .direct = true, .key = {1, 0}}, quiet).lights;
  ASSERT_NE(rows.size() % 16, 0u);
  std::vector<Rgb> radiance(rows.size());
  const BruteForceCounters counters = brute_force(t.world, rows, lights, 0.2f, radiance, quiet);
  EXPECT_EQ(counters.entries, rows.size() * lights.size());
  std::uint64_t traced = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < lights.size(); ++j) {
      const auto row = static_cast<ReceiverId>(i);
      const auto column = static_cast<LightId>(j);
      const Rgb entry = transfer(t.world, rows, row, lights, column, 0.2f);
      if (is_black(entry)) continue;
      ++traced;
      const Segment s = shadow_segment(rows, row, lights, column);
      if (s.distant ? t.tracer.occluded_direction(s.from, s.to) : t.tracer.occluded(s.from, s.to)) continue;
      sum += static_cast<double>(entry.g);
    }
    EXPECT_EQ(radiance[i].g, static_cast<float>(sum)) << i;
  }
  EXPECT_EQ(counters.traced, traced);
}

TEST(BruteForce, NoRowsAndNoColumnsAreFine) {
  TestWorld t(test::cornell_box());
  Progress quiet;
  std::vector<Rgb> none;
  EXPECT_EQ(brute_force(t.world, {}, {}, 0, none, quiet).entries, 0u);
  const Receivers rows = trace_receivers(t.world, {.width = 4, .height = 4, .spp = 1, .key = {1, 0}}, quiet).receivers;
  std::vector<Rgb> radiance(rows.size(), gray(7));
  brute_force(t.world, rows, {}, 0, radiance, quiet);
  for (const Rgb& r : radiance) EXPECT_EQ(r, Rgb{});
}

TEST(PathTracer, SameBitsForAnyNumberOfThreads) {
  TestWorld t(test::plastic_floor_box());
  Progress quiet;
  const PathTracerParams params{
      .width = 13, .height = 9, .spp = 8, .filter = {Filter::Kind::gaussian, 2}, .key = {4, 0}};
  const auto with_threads = [&](int n_threads) {
    const ThreadScope threads(n_threads);
    return render_paths(t.world, params, quiet);
  };
  const PathTracerResult one = with_threads(1);
  for (const int n : {2, 7}) {
    const PathTracerResult many = with_threads(n);
    EXPECT_EQ(one.sum_rgb, many.sum_rgb);
    EXPECT_EQ(one.variance, many.variance);
    EXPECT_EQ(one.rays.closest, many.rays.closest);
  }
}

TEST(PathTracer, VariancePredictsTheSpreadOfRenders) {
  TestWorld t(test::cornell_box(), 4);
  Progress quiet;
  const auto render = [&](std::uint64_t seed) {
    const PathTracerParams params{
        .width = 12, .height = 12, .spp = 32, .filter = {Filter::Kind::gaussian, 2}, .key = {seed, 0}};
    return render_paths(t.world, params, quiet);
  };
  // Ratio of squared differences of two renders to the variance both predict, over all pixels and four pairs.
  double squares = 0, predicted = 0;
  for (std::uint64_t pair = 0; pair < 4; ++pair) {
    const PathTracerResult a = render(2 * pair), b = render(2 * pair + 1);
    const Picture pa = to_picture(a), pb = to_picture(b);
    for (std::size_t i = 0; i < a.variance.size(); ++i) {
      const double difference = static_cast<double>(pa.find("")->pixels[i] - pb.find("")->pixels[i]);
      squares += difference * difference;
      predicted += static_cast<double>(a.variance[i] + b.variance[i]);
    }
  }
  EXPECT_NEAR(squares / predicted, 1, 0.35);  // 4 x 144 pixels, neighbours correlated: standard error near 0.1
}

TEST(PathTracer, FirstHitsFillTheAovs) {
  TestWorld t(test::cornell_box());
  Progress quiet;
  const PathSamples paths = trace_paths(t.world, {.width = 8, .height = 8, .spp = 1, .key = {1, 0}}, quiet);
  const ReceiverResult rows = trace_receivers(t.world, {.width = 8, .height = 8, .spp = 1, .key = {1, 0}}, quiet);
  for (std::size_t s = 0; s < paths.samples.size(); ++s) {
    EXPECT_EQ(paths.samples.depth[s], rows.samples.depth[s]);
    EXPECT_EQ(paths.samples.albedo[s], rows.samples.albedo[s]);
    EXPECT_EQ(paths.samples.normal[s], rows.samples.normal[s]);
  }
}

}  // namespace
}  // namespace myrialux
