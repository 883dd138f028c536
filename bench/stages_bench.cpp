// Stages of a frame, one thread, each against what bounds it in the same process: closest hits of raw Embree, a copy of
// the memory concerned, or raw Embree's shadow rays of the same slice.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "bench_frame.h"
#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/completion/bamc.h"
#include "myrialux/shading/shade.h"
#include "myrialux/visibility/block_energies.h"
#include "myrialux/visibility/slice_visibility.h"
#include "raw_packets.h"

namespace myrialux {
namespace {

using benchmark::State;

/// Seconds of this thread that `work` takes.
template <class Work>
double seconds(const Work& work) {
  const ThreadStopwatch watch;
  work();
  return watch.elapsed();
}

/// Time of copying so many bytes, read and written once.
double copy_seconds(std::size_t bytes) {
  static std::vector<std::uint64_t> from, to;
  const std::size_t n = bytes / 8;
  if (from.size() < n) from.assign(n, 1), to.assign(n, 2);
  return seconds([&] {
    std::copy_n(from.data(), n, to.data());
    benchmark::ClobberMemory();
  });
}

/// Rays of the stage against as many closest hits of raw Embree on rays of the same kind.
template <class Stage>
void run_rays(State& state, const bench::Frame& f, const std::vector<Ray>& raw, const Stage& stage) {
  const ThreadScope one(1);
  double own_s = 0, raw_s = 0;
  std::uint64_t n = 0;
  for ([[maybe_unused]] auto _ : state) {
    own_s += seconds([&] { n += stage(); });
    raw_s += seconds([&] { benchmark::DoNotOptimize(bench::intersect_all(f, raw)); });
  }
  const double rounds = static_cast<double>(state.iterations());
  const double own_rate = static_cast<double>(n) / own_s;
  const double raw_rate = static_cast<double>(raw.size()) * rounds / raw_s;
  state.counters["Mrays/s"] = 1e-6 * own_rate;
  state.counters["embree_Mrays/s"] = 1e-6 * raw_rate;
  state.counters["ratio_to_embree"] = own_rate / raw_rate;
  state.counters["n_rays"] = static_cast<double>(n) / rounds;
}

void receivers(State& state, const bench::NamedScene& named) {
  const bench::Frame& f = bench::frame(named);
  Progress silent;
  std::size_t n_receivers = 0;
  run_rays(state, f, bench::camera_rays(f, 1 << 16), [&] {
    const ReceiverResult made =
        trace_receivers(f.world, {.width = bench::kWidth, .height = bench::kHeight, .spp = 2, .key = f.key}, silent);
    n_receivers = made.receivers.size();
    return made.camera_rays;
  });
  state.counters["n_receivers"] = static_cast<double>(n_receivers);
}

void light_walks(State& state, const bench::NamedScene& named) {
  const bench::Frame& f = bench::frame(named);
  Progress silent;
  std::size_t n_lights = 0;
  run_rays(state, f, bench::scattered_rays(f, 1 << 16), [&] {
    const LightResult made = trace_lights(f.world, {.n_lights = 50'000, .key = f.key}, silent);
    n_lights = made.lights.size();
    return made.light_rays;
  });
  state.counters["n_lights"] = static_cast<double>(n_lights);
}

/// Time of the stage over the time of copying `bytes`.
template <class Stage>
void run_memory(State& state, std::size_t bytes, const Stage& stage) {
  const ThreadScope one(1);
  double own_s = 0, copy_s = 0;
  for ([[maybe_unused]] auto _ : state) {
    own_s += seconds(stage);
    copy_s += copy_seconds(bytes);
  }
  state.counters["copies"] = own_s / copy_s;
  state.counters["bytes"] = static_cast<double>(bytes);
}

void slices(State& state, const bench::NamedScene& named) {
  const bench::Frame& f = bench::frame(named);
  run_memory(state, f.rows().size() * 2 * sizeof(Vec3),
             [&] { benchmark::DoNotOptimize(make_slices(f.rows(), f.radius, {})); });
  state.counters["n_slices"] = static_cast<double>(f.slices.size());
}

void light_tree(State& state, const bench::NamedScene& named) {
  const bench::Frame& f = bench::frame(named);
  run_memory(state, f.tree.memory_bytes(),
             [&] { benchmark::DoNotOptimize(build_light_tree(f.world, f.lights.lights, f.radius, {.key = f.key})); });
  state.counters["n_nodes"] = static_cast<double>(f.tree.size());
}

/// Seconds of the stages of slices, and counts.
struct SliceSums {
  double cut_s = 0, active_s = 0, energies_s = 0, trace_s = 0, shade_s = 0, raw_s = 0;
  std::uint64_t columns = 0, entries = 0, active = 0, visible = 0;
};

double raw_seconds(const bench::Frame& f, std::span<const ReceiverId> rows, std::span<const Column> columns,
                   const SliceVisibility& source) {
  const bench::PacketMaker maker(f, rows);
  std::vector<bench::RawPacket> packets;
  double raw_s = 0;
  for (std::size_t first = 0; first < columns.size(); first += bench::kChunk) {
    packets.clear();
    for (std::size_t j = first; j < std::min(first + bench::kChunk, columns.size()); ++j)
      maker.add(shadow_light(f.lights.lights, index(columns[j].light)), source.active(j), false, packets);
    raw_s += seconds([&] { bench::trace_raw(static_cast<RTCScene>(f.tracer.native_scene()), packets); }) -
             bench::clock_seconds();
  }
  return raw_s;
}

void run_slice(const bench::Frame& f, std::size_t s, SliceSums& sums) {
  const std::span<const ReceiverId> rows = f.slices.rows(s);
  const VirtualLights& lights = f.lights.lights;
  ThreadStopwatch watch;
  const std::vector<Column> columns = f.columns(s);
  sums.cut_s += watch.lap();
  SliceVisibility source(f.world, f.rows(), rows, lights, columns, true);
  sums.active_s += watch.lap();
  const BlockEnergies energies(f.world, f.rows(), rows, lights, f.tree, columns, f.cut.clamp_distance, 1);
  benchmark::DoNotOptimize(energies.memory_bytes());
  sums.energies_s += watch.lap();
  BitMatrix visible(rows.size(), columns.size());
  sums.active += trace_all(source, visible).entries;
  sums.trace_s += watch.lap();
  std::vector<Rgb> radiance(rows.size());
  benchmark::DoNotOptimize(shade_slice(f.world, f.rows(), rows, lights, columns, visible,
                                       {.clamp_distance = f.cut.clamp_distance}, radiance));
  sums.shade_s += watch.lap();
  sums.raw_s += raw_seconds(f, rows, columns, source);
  sums.columns += columns.size(), sums.entries += rows.size() * columns.size(), sums.visible += visible.count();
}

/// Six slices of a frame, stage by stage; `x_over_raw`: time over that of raw Embree on the slices' active entries.
void slice_stages(State& state, const bench::NamedScene& named) {
  const bench::Frame& f = bench::frame(named);
  const std::size_t n = std::min<std::size_t>(6, f.slices.size() - 1);
  SliceSums sums;
  for ([[maybe_unused]] auto _ : state)
    for (std::size_t k = 0; k < n; ++k) run_slice(f, k * (f.slices.size() - 1) / n, sums);
  const double rounds = static_cast<double>(state.iterations());
  state.counters["cut_over_raw"] = sums.cut_s / sums.raw_s;
  state.counters["active_over_raw"] = sums.active_s / sums.raw_s;
  state.counters["energies_over_raw"] = sums.energies_s / sums.raw_s;
  state.counters["trace_over_raw"] = sums.trace_s / sums.raw_s;
  state.counters["shade_over_raw"] = sums.shade_s / sums.raw_s;
  state.counters["cut_us/slice"] = 1e6 * sums.cut_s / (rounds * static_cast<double>(n));
  state.counters["active_Gentries/s"] = 1e-9 * static_cast<double>(sums.entries) / sums.active_s;
  state.counters["shade_Gvisible/s"] = 1e-9 * static_cast<double>(sums.visible) / sums.shade_s;
  state.counters["n_columns"] = static_cast<double>(sums.columns) / rounds;
  state.counters["n_active"] = static_cast<double>(sums.active) / rounds;
  state.counters["n_visible"] = static_cast<double>(sums.visible) / rounds;
}

const bool registered = [] {
  for (const bench::NamedScene& s : bench::scenes()) {
    const auto add = [&](const char* what, auto body) {
      benchmark::RegisterBenchmark((what + s.name).c_str(), body, s)->Unit(benchmark::kMillisecond);
    };
    add("receivers/", receivers);
    add("light_walks/", light_walks);
    add("slices/", slices);
    add("light_tree/", light_tree);
    add("slice_stages/", slice_stages);
  }
  return true;
}();

}  // namespace
}  // namespace myrialux
