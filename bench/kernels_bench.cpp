// Kernels of visibility and cuts on every instruction set, each against its plain twin in the same process.
// Shading kernels have a program of their own.
#include <benchmark/benchmark.h>

#include <vector>

#include "myrialux/base/clock.h"
#include "myrialux/base/rng.h"
#include "myrialux/kernels/active_bits.h"
#include "myrialux/kernels/cut_bounds.h"
#include "myrialux/kernels/isa.h"
#include "myrialux/kernels/nearest_bits.h"
#include "myrialux/kernels/shadow_ends.h"

namespace myrialux {
namespace {

constexpr std::size_t kBlocks = 16, kLights = 256;
/// Short kernels run so often between two looks at the clock.
constexpr std::size_t kRepeats = 64;

/// Runs kernel and plain twin in turn. @param n items an iteration
template <class Kernel, class Plain>
void compare(benchmark::State& state, std::int64_t isa, std::size_t n, const Kernel& kernel, const Plain& plain) {
  force_isa(isa);
  double own_s = 0, plain_s = 0;
  for ([[maybe_unused]] auto _ : state) {
    ThreadStopwatch watch;
    kernel();
    benchmark::ClobberMemory();
    own_s += watch.lap();
    plain();
    benchmark::ClobberMemory();
    plain_s += watch.lap();
  }
  state.counters["ratio_to_plain"] = plain_s / own_s;
  state.counters["ns/item"] = 1e9 * own_s / (static_cast<double>(state.iterations()) * static_cast<double>(n));
  force_isa(0);
}

/// Rows on small patches of the walls of a box; `roughness` tilts their normals.
std::vector<RowBlock> patches(float roughness) {
  Rng rng({1}, Stage::test, 0);
  std::vector<RowBlock> blocks(kBlocks);
  for (RowBlock& block : blocks) {
    const std::size_t axis = rng.below(3);
    const float side = rng.below(2) ? 1.0f : -1.0f;
    float p[3] = {rng.next(), rng.next(), rng.next()};
    p[axis] = side;
    for (std::size_t row = 0; row < kBlockRows; ++row)
      for (std::size_t k = 0; k < 3; ++k) {
        block.p[k][row] = p[k] + (k == axis ? 0 : 0.1f * rng.next());
        block.ng[k][row] = block.n[k][row] = (k == axis ? -side : 0) + roughness * (rng.next() - 0.5f);
      }
  }
  return blocks;
}

/// Items are entries. Rough rows are looked at one by one, others mostly as blocks.
void active(benchmark::State& state, std::int64_t isa, float roughness) {
  const std::vector<RowBlock> blocks = patches(roughness);
  const std::vector<std::uint64_t> both_sides(kBlocks);
  Rng rng({2}, Stage::test, 0);
  std::vector<ActivityLight> lights(kLights);
  for (ActivityLight& light : lights) {
    for (int k = 0; k < 3; ++k) light.to[k] = 2 * rng.next() - 1, light.n[k] = light.ng[k] = rng.next() - 0.5f;
    light.sides = LitSides::front;
  }
  std::vector<std::uint64_t> words(kBlocks * kLights);
  compare(
      state, isa, kBlocks * kBlockRows * kLights, [&] { active_bits(blocks, both_sides, lights, words); },
      [&] { active_bits_plain(blocks, both_sides, lights, words); });
}

/// Items are packets of 16 rays.
void rays(benchmark::State& state, std::int64_t isa) {
  const std::vector<RowBlock> blocks = patches(0.1f);
  alignas(64) static PacketFloats made[7], offset;
  const PacketRays to{{made[0], made[1], made[2]}, {made[3], made[4], made[5]}, made[6]};
  const ShadowLight light{{0.1f, 0.2f, 0.3f}, {0, 0, 1}, 1e-4f, SegmentEnd::surface};
  const auto each = [&](const auto& make) {
    for (std::size_t k = 0; k < kRepeats; ++k)
      for (const RowBlock& b : blocks) {
        make(PacketRows{{b.p[0], b.p[1], b.p[2]}, {b.ng[0], b.ng[1], b.ng[2]}, offset}, light, 0.5f, to);
        benchmark::ClobberMemory();
      }
  };
  compare(
      state, isa, kBlocks * kRepeats, [&] { each(shadow_rays); }, [&] { each(shadow_rays_plain); });
}

/// Items are columns of 16 words that are compared.
void nearest(benchmark::State& state, std::int64_t isa) {
  constexpr std::size_t kWords = 16, kColumns = 64;
  Rng rng({3}, Stage::test, 0);
  std::vector<std::uint64_t> visible(kWords * kColumns), known(visible.size()), samples(kWords), omega(kWords);
  for (auto* words : {&visible, &known, &samples, &omega})
    for (std::uint64_t& w : *words) w = std::uint64_t{rng.next_uint()} << 32 | rng.next_uint();
  const BitColumns columns{visible, known, kWords};
  const auto often = [&](const auto& find) {
    for (std::size_t k = 0; k < kRepeats; ++k) benchmark::DoNotOptimize(find(columns, k, samples, omega));
  };
  compare(
      state, isa, kColumns * kRepeats, [&] { often(nearest_column); }, [&] { often(nearest_column_plain); });
}

/// Items are bounds of one cluster at 16 receivers.
void bounds(benchmark::State& state, std::int64_t isa, bool gloss) {
  Rng rng({4}, Stage::test, 0);
  CutPoints points;
  points.groups.resize(1);
  points.any_gloss = gloss;
  points.least_distance_squared = 1e-4f;
  CutPoints::Group& g = points.groups[0];
  for (std::size_t k = 0; k < kCutLanes; ++k) {
    for (auto& p : g.p) p[k] = rng.next();
    g.normal[2][k] = g.normal[3][k] = g.normal[7][k] = 1;
    g.mirror[2][k] = g.mirror[3][k] = g.mirror[7][k] = 1;
    g.diffuse[k] = 0.3f, g.gloss[k] = gloss ? 1 : 0, g.inverse_alpha2[k] = 25, g.c1[k] = 1, g.c2[k] = 0.5f;
  }
  std::vector<CutCluster> clusters(kLights);
  for (CutCluster& c : clusters) {
    c = {};
    for (int k = 0; k < 3; ++k) c.lower[k] = 2 * rng.next(), c.upper[k] = c.lower[k] + 0.2f * rng.next();
    c.back.axis[2] = c.back.s[0] = c.back.t[1] = 1;
    c.mirror_back = c.back;
    c.cone_cos = 0.8f, c.cone_sin = 0.6f, c.mirror_cos = 0.8f, c.mirror_sin = 0.6f, c.diffuse = 1, c.has_cone = true;
  }
  std::vector<float> found(kLights);
  compare(
      state, isa, kLights, [&] { bound_clusters(points, clusters, found); },
      [&] { bound_clusters_plain(points, clusters, found); });
}

const bool registered = [] {
  for (const std::int64_t isa : available_isas()) {
    const auto add = [&](const char* what, auto body, auto... more) {
      benchmark::RegisterBenchmark((what + isa_name(isa)).c_str(), body, isa, more...)->Unit(benchmark::kMicrosecond);
    };
    add("active_bits/flat/", active, 0.0f);
    add("active_bits/rough/", active, 2.0f);
    add("shadow_rays/", rays);
    add("nearest_column/", nearest);
    add("bound_clusters/diffuse/", bounds, false);
    add("bound_clusters/gloss/", bounds, true);
  }
  return true;
}();

}  // namespace
}  // namespace myrialux
