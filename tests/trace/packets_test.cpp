// Packets of all widths give the bits of single rays: solid shapes, cut-outs, quadrics, instances.
#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "myrialux/trace/tracer.h"
#include "trace/trace_scenes.h"

namespace myrialux {
using test::random_direction;
using test::random_point;

namespace {

struct Ends {
  Vec3 from, to;
};

template <int N>
std::uint32_t trace_packets(const Tracer& tracer, const std::vector<Ends>& ends, std::size_t first, bool coherent,
                            bool to_direction) {
  std::uint32_t blocked = 0;
  for (int part = 0; part < 16 / N; ++part) {
    Segments<N> s;
    for (int k = 0; k < N; ++k) {
      const Ends& e = ends[first + static_cast<std::size_t>(part * N + k)];
      s.from_x[k] = e.from.x, s.from_y[k] = e.from.y, s.from_z[k] = e.from.z;
      s.to_x[k] = e.to.x, s.to_y[k] = e.to.y, s.to_z[k] = e.to.z;
    }
    const std::uint32_t all = (1u << N) - 1;
    blocked |=
        (to_direction ? tracer.occluded_packet_direction(s, all, coherent) : tracer.occluded_packet(s, all, coherent))
        << (part * N);
  }
  return blocked;
}

std::vector<Ends> random_ends(std::size_t n, bool to_direction, bool common_end) {
  Rng rng({13, 0}, Stage::test, to_direction + 2 * common_end);
  std::vector<Ends> ends(n);
  for (std::size_t i = 0; i < n; ++i) {
    ends[i].from = random_point(rng, 3);
    if (common_end && i % 16) ends[i].from = ends[i - 1].from + random_point(rng, 0.05f);
    ends[i].to = common_end && i % 16 ? ends[i - 1].to : to_direction ? random_direction(rng) : random_point(rng, 3);
  }
  return ends;
}

/// Number of segments on which some width disagrees with single rays; out: how many are blocked.
std::size_t count_disagreements(const Tracer& tracer, bool to_direction, bool common_end, std::size_t n,
                                std::size_t& n_blocked) {
  const std::vector<Ends> ends = random_ends(n, to_direction, common_end);
  std::size_t n_wrong = 0;
  for (std::size_t i = 0; i < n; i += 16) {
    std::uint32_t single = 0;
    for (std::size_t k = 0; k < 16; ++k) {
      const auto [from, to] = ends[i + k];
      if (to_direction ? tracer.occluded_direction(from, to) : tracer.occluded(from, to)) single |= 1u << k;
    }
    n_blocked += static_cast<std::size_t>(std::popcount(single));
    std::uint32_t wrong = 0;
    for (const bool coherent : {false, true}) {
      wrong |= single ^ trace_packets<4>(tracer, ends, i, coherent, to_direction);
      wrong |= single ^ trace_packets<8>(tracer, ends, i, coherent, to_direction);
      wrong |= single ^ trace_packets<16>(tracer, ends, i, coherent, to_direction);
    }
    n_wrong += static_cast<std::size_t>(std::popcount(wrong));
  }
  return n_wrong;
}

void expect_agreement(const Scene& scene, std::size_t n_segments) {
  const Tracer tracer(scene);
  for (const bool to_direction : {false, true})
    for (const bool common_end : {false, true}) {
      std::size_t n_blocked = 0;
      EXPECT_EQ(count_disagreements(tracer, to_direction, common_end, n_segments, n_blocked), 0u)
          << "direction " << to_direction << ", common end " << common_end;
      EXPECT_GT(n_blocked, n_segments / 100);
      EXPECT_LT(n_blocked, n_segments * 99 / 100);
    }
}

TEST(Packets, AllWidthsAgreeWithSingleRays) { expect_agreement(test::mixed_scene(), 128'000); }

TEST(Packets, AllWidthsAgreeOnMeshesAndInstances) {
  Scene scene = test::mixed_scene();
  std::erase_if(scene.placed,
                [&](ShapeId id) { return std::holds_alternative<Quadric>(scene.shapes[index(id)].geometry); });
  expect_agreement(scene, 128'000);
}

TEST(Packets, AllWidthsAgreeOnMeshesWithCutouts) {
  Scene scene = test::mixed_scene();
  scene.instances.clear();
  std::erase_if(scene.placed,
                [&](ShapeId id) { return std::holds_alternative<Quadric>(scene.shapes[index(id)].geometry); });
  expect_agreement(scene, 128'000);
}

TEST(Packets, LanesThatAreNotValidAreNeitherTracedNorReported) {
  test::SceneBuilder b;
  b.rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, b.diffuse(gray(1)));
  const Tracer tracer(b.scene);
  Segments<16> s;
  std::memset(&s, 0xff, sizeof s);  // not a number
  for (int k = 0; k < 16; k += 2) {
    s.from_x[k] = s.to_x[k] = 0.05f * static_cast<float>(k), s.from_y[k] = s.to_y[k] = 0;
    s.from_z[k] = 1, s.to_z[k] = k % 4 ? 0.5f : -1;
  }
  EXPECT_EQ(tracer.occluded_packet(s, 0x5555, true), 0x1111u);
  EXPECT_EQ(tracer.occluded_packet(s, 0x5555, false), 0x1111u);
  EXPECT_EQ(tracer.occluded_packet(s, 0x0110, true), 0x0110u);
  EXPECT_EQ(tracer.occluded_packet(s, 0x0004, true), 0u);
  EXPECT_EQ(tracer.occluded_packet(s, 0, true), 0u);
}

}  // namespace
}  // namespace myrialux
