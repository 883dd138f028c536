// Adaptive sampling of a pair of clusters: exact where all receivers are traced, few rays where all agree.
#include "myrialux/visibility/pair_sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

/// A row of n receivers on the floor along x, a light above, and a wall that shades those beyond x = edge.
struct Row {
  Scene scene;
  Tracer tracer;
  Emitters emitters;
  World world{.scene = scene, .tracer = tracer, .emitters = emitters};
  Receivers receivers;
  VirtualLights lights;
  std::vector<ReceiverId> order;

  static Scene make_scene(float edge) {
    test::SceneBuilder b;
    const MaterialId white = b.diffuse({0.5f, 0.5f, 0.5f}, true);
    b.rectangle({-2, -2, -0.1f}, {4, 0, 0}, {0, 4, 0}, white);
    b.rectangle({edge, -1, 0.5f}, {3, 0, 0}, {0, 2, 0}, white);
    b.scene.emitters.push_back({"sky", {}, ConstantEmitter{gray(1)}});
    b.camera({0, 0, 3}, {0, 0, 0}, 40, 8, 8);
    return std::move(b.scene);
  }
  Row(std::size_t n, float edge) : scene(make_scene(edge)), tracer(scene), emitters(scene, tracer.bounds()) {
    receivers.resize(n);
    order.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      receivers.p[i] = {(static_cast<float>(i) + 0.5f) / static_cast<float>(n), 0, 0};
      receivers.n[i] = receivers.ng[i] = receivers.wo[i] = {0, 0, 1};
      receivers.offset[i] = 1e-4f;
      receivers.bsdf[i].material = static_cast<MaterialId>(0);
      receivers.bsdf[i].reflectance = gray(0.5f);
      order[i] = static_cast<ReceiverId>(i);
    }
    lights.p = {{0.5f, 0, 1e4f}};  // shadows fall straight down
    lights.n = lights.ng = {{0, 0, -1}};
    lights.offset = {1e-4f}, lights.light = {gray(1)}, lights.kind = {LightKind::oriented}, lights.bounce = {0};
    lights.extra = {0xffffffffu};
  }
  PairSampler sampler(SamplingParams params = {}) const { return {world, receivers, lights, order, params}; }
};

std::vector<bool> bits_of(const std::vector<VisibleRun>& runs, std::size_t n) {
  std::vector<bool> bits(n);
  for (const VisibleRun& run : runs)
    for (std::uint32_t k = run.first; k < run.end; ++k) bits[k] = true;
  return bits;
}

TEST(PairSampler, TakesThePublishedNumberOfRaysWhereAllAgree) {
  for (const bool visible : {true, false}) {
    const Row row(1000, visible ? 1.5f : -0.5f);
    for (const auto& [count, rays] : {std::pair{7u, 7u}, {8u, 8u}, {32u, 8u}, {33u, 16u}, {1000u, 16u}}) {
      PairSampler sampler = row.sampler();
      std::vector<VisibleRun> runs;
      sampler.sample(0, count, LightId{0}, runs);
      EXPECT_EQ(sampler.rays(), rays) << count;
      const std::vector<bool> bits = bits_of(runs, 1000);
      EXPECT_EQ(std::count(bits.begin(), bits.end(), true), visible ? count : 0);
    }
  }
}

TEST(PairSampler, FindsOneShadowEdgeWithFewRays) {
  for (const std::uint32_t n : {40u, 100u, 1000u, 100000u})
    for (const float edge : {0.3f, 0.51234f, 0.77f}) {
      const Row row(n, edge);
      PairSampler sampler = row.sampler();
      std::vector<VisibleRun> runs;
      sampler.sample(0, n, LightId{0}, runs);
      const std::vector<bool> bits = bits_of(runs, n);
      std::uint32_t wrong = 0;
      for (std::uint32_t i = 0; i < n; ++i) wrong += bits[i] != (row.receivers.p[i].x < edge);
      // One edge crosses one part or the gap between two samples, so errors stay below two parts of a sixteenth.
      EXPECT_LE(wrong, n / 8) << n << " receivers, edge " << edge;
      // Each level samples the parts on either side of the edge, all 16 of them at most.
      EXPECT_LT(sampler.rays(), n >= 1000 ? n / 3 : n + 1);
    }
}

TEST(PairSampler, TracesEveryReceiverOnceWhereClustersAreSmall) {
  // Of fewer receivers than `least` times `few_samples`, all are traced once the samples differ; samples are kept.
  const Row row(60, 0.5f);
  PairSampler sampler = row.sampler({.samples = 8, .few_samples = 8, .large = 1000, .least = 8});
  std::vector<VisibleRun> runs;
  sampler.sample(3, 55, LightId{0}, runs);
  EXPECT_EQ(sampler.rays(), 55u);
  const std::vector<bool> bits = bits_of(runs, 60);
  for (std::size_t i = 3; i < 58; ++i) EXPECT_EQ(bits[i], row.receivers.p[i].x < 0.5f) << i;
}

TEST(PairSampler, ReceiversThatFaceAwayAreNotTracedAndDoNotMatter) {
  Row row(320, -0.5f);
  for (std::size_t i = 0; i < 320; i += 3) row.receivers.n[i] = row.receivers.ng[i] = {0, 0, -1};
  PairSampler sampler = row.sampler();
  std::vector<VisibleRun> runs;
  sampler.sample(0, 320, LightId{0}, runs);
  EXPECT_TRUE(runs.empty());
  EXPECT_LE(sampler.rays(), 16u);
}

}  // namespace
}  // namespace myrialux
