// Cuts of single receivers: exact at the limit, never above their size, errors within the threshold's meaning, the same
// light whoever shares the packet when nothing limits the cut, unbiased at a fixed size.
#include "myrialux/clusters/receiver_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "myrialux/clusters/agglomerative_tree.h"
#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

using test::Room;

constexpr float kClamp = 0.2f;
const std::vector<LightKind> kAllKinds = {LightKind::oriented, LightKind::glossy, LightKind::point,
                                          LightKind::directional};

/// Light without shadows by transfer(); every fourth light is dark when `shadows`, as if hidden.
class Plain final : public LightAtPacket {
 public:
  Plain(const Room& room, std::span<const ReceiverId> rows, bool shadows)
      : room_(room), rows_(rows.begin(), rows.end()), shadows_(shadows) {}
  void evaluate(LightId light, std::uint32_t rows, PacketLight& arriving) override {
    for (std::size_t k = 0; k < rows_.size(); ++k)
      if (rows >> k & 1) {
        const Rgb c = light_of(rows_[k], light);
        arriving.rgb[0][k] = c.r, arriving.rgb[1][k] = c.g, arriving.rgb[2][k] = c.b;
        ++evaluations;
      }
  }
  Rgb light_of(ReceiverId i, LightId j) const {
    if (shadows_ && index(j) % 4 == 0) return {};
    return transfer(room_.world(), room_.receivers, i, room_.lights, j, kClamp);
  }
  double light_of_all(ReceiverId i) const {
    double sum = 0;
    for (std::size_t j = 0; j < room_.lights.size(); ++j) sum += luminance(light_of(i, static_cast<LightId>(j)));
    return sum;
  }
  std::size_t evaluations = 0;

 private:
  const Room& room_;
  std::vector<ReceiverId> rows_;
  bool shadows_;
};

std::vector<ReceiverId> first_rows(std::size_t n) {
  std::vector<ReceiverId> rows;
  for (std::size_t i = 0; i < n; ++i) rows.push_back(static_cast<ReceiverId>(i));
  return rows;
}

struct Packet {
  std::vector<ReceiverId> rows;
  Plain lights;
  CutPoints points;
  Packet(const Room& room, std::size_t n, bool shadows = false)
      : rows(first_rows(n)),
        lights(room, rows, shadows),
        points(make_cut_points(room.world(), room.receivers, rows, kClamp)) {}
  PacketCut cut(const LightTree& tree, const ReceiverCutParams& params, std::uint32_t lanes = 0xffff) {
    return cut_packet(tree, points, 0, lanes & ((1u << rows.size()) - 1), params, lights);
  }
};

LightTree build(const Room& room, RandomKey key = {}) {
  return build_agglomerative_tree(room.world(), room.lights, Room::kRadius, {.n_competing = 32, .key = key});
}

TEST(ReceiverCut, DownToTheLeavesIsExact) {
  const Room room({.n_receivers = 16, .n_lights = 900, .kinds = kAllKinds, .glossy = true, .glass = true});
  for (const std::size_t n : {1, 7, 15, 16}) {
    Packet packet(room, n, true);
    const PacketCut cut = packet.cut(build(room), {.error = 0, .max_size = 1000});
    for (std::size_t k = 0; k < 16; ++k) {
      if (k >= n) {
        EXPECT_EQ(cut.size[k], 0u);
        continue;
      }
      const double all = packet.lights.light_of_all(packet.rows[k]);
      EXPECT_NEAR(luminance(cut.radiance[k]), all, 1e-5 * all);
      EXPECT_LE(cut.size[k], 900u);
    }
  }
}

TEST(ReceiverCut, HasAtMostTheSizeAskedForAndAtLeastOneNodeAKind) {
  const Room room({.n_receivers = 16, .n_lights = 900, .kinds = kAllKinds, .glossy = true});
  for (const std::uint32_t size : {1u, 4u, 5u, 63u, 200u}) {
    Packet packet(room, 16);
    const PacketCut cut = packet.cut(build(room), {.error = 0, .max_size = size});
    for (const std::uint32_t n : cut.size) {
      EXPECT_LE(n, std::max(size, 4u));
      EXPECT_GE(n, std::min(std::max(size, 4u), 60u));  // clusters of bound 0 stay whole
    }
  }
}

TEST(ReceiverCut, OfNoLightsIsBlack) {
  const Room room({.n_receivers = 2, .n_lights = 0});
  Packet packet(room, 2);
  const PacketCut cut = packet.cut(build(room), {});
  EXPECT_TRUE(is_black(cut.radiance[0]));
  EXPECT_EQ(cut.size[0], 0u);
}

TEST(ReceiverCut, ErrsLessAndGrowsAsTheThresholdFalls) {
  // A quarter of the lights is dark without any order, which no bound knows of: the worst case for representatives.
  const Room room({.n_receivers = 16, .n_lights = 4000, .kinds = kAllKinds, .glossy = true});
  double last_size = 0, last_error = 1;
  for (const float threshold : {0.2f, 0.02f, 0.002f}) {
    double squares = 0, size = 0;
    for (std::uint32_t pass = 0; pass < 4; ++pass) {
      const LightTree tree = build(room, {.pass = pass});
      Packet packet(room, 16, true);
      const PacketCut cut = packet.cut(tree, {.error = threshold, .max_size = 100000});
      for (std::size_t k = 0; k < 16; ++k) {
        squares += std::pow(luminance(cut.radiance[k]) / packet.lights.light_of_all(packet.rows[k]) - 1, 2) / 64;
        size += cut.size[k] / 64.0;
      }
    }
    const double error = std::sqrt(squares);
    std::printf("threshold %g: %.0f nodes, error %.4f\n", static_cast<double>(threshold), size, error);
    EXPECT_GT(size, last_size);
    EXPECT_LT(error, 0.6 * last_error);
    last_size = size, last_error = error;
  }
}

TEST(ReceiverCut, AloneNeedsNoMoreNodesThanTogether) {
  const Room room({.n_receivers = 16, .n_lights = 3000});
  const LightTree tree = build(room);
  Packet packet(room, 16, true);
  const PacketCut together = packet.cut(tree, {.error = 0.02f, .max_size = 100000});
  double alone_size = 0, together_size = 0;
  for (std::size_t k = 0; k < 16; ++k) {
    const PacketCut alone = packet.cut(tree, {.error = 0.02f, .max_size = 100000}, 1u << k);
    EXPECT_GT(alone.size[k], 0u);
    alone_size += alone.size[k], together_size += together.size[k];
  }
  // Refinement in another order passes through other totals, so sizes differ a little.
  EXPECT_NEAR(together_size, alone_size, 0.05 * alone_size);
}

TEST(ReceiverCut, InheritsLightFromParents) {
  // A cut of s nodes from r roots has s - r splits, each of which evaluates one light a receiver.
  const Room room({.n_receivers = 16, .n_lights = 3000});
  Packet packet(room, 16);
  const PacketCut cut = packet.cut(build(room), {.error = 0.02f, .max_size = 300});
  std::size_t sizes = 0;
  for (const std::uint32_t s : cut.size) sizes += s;
  EXPECT_EQ(packet.lights.evaluations, sizes);
}

TEST(ReceiverCut, OfFixedSizeIsUnbiasedOverPasses) {
  // With error 0 the cut depends on bounds alone, not on the estimate: z-test, 4.5 sigma.
  const Room room({.n_receivers = 16, .n_lights = 1200, .kinds = kAllKinds, .glossy = true, .glass = true});
  Packet packet(room, 16, true);
  double truth = 0;
  for (const ReceiverId i : packet.rows) truth += packet.lights.light_of_all(i);
  constexpr int kPasses = 300;
  double sum = 0, sum2 = 0;
  for (int pass = 0; pass < kPasses; ++pass) {
    const LightTree tree = build(room, {.seed = 2, .pass = static_cast<std::uint32_t>(pass)});
    const PacketCut cut = packet.cut(tree, {.error = 0, .max_size = 80});
    double estimate = 0;
    for (const Rgb& c : cut.radiance) estimate += luminance(c);
    sum += estimate, sum2 += estimate * estimate;
  }
  const double mean = sum / kPasses, variance = (sum2 / kPasses - mean * mean) / (kPasses - 1);
  EXPECT_LT(std::fabs(mean - truth), 4.5 * std::sqrt(variance)) << mean << " against " << truth;
  EXPECT_LT(std::sqrt(variance), 0.02 * truth);  // the test would see a bias of a tenth
}

}  // namespace
}  // namespace myrialux
