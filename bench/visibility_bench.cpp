// Full visibility of slices against raw Embree on the same packets, in turn, in one process: what a ray costs beyond
// Embree. Raw rays are prepared beforehand, lie in the cache and are traced in place: nothing but rtcOccluded16.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <span>
#include <vector>

#include "bench_frame.h"
#include "myrialux/base/clock.h"
#include "myrialux/completion/bamc.h"
#include "myrialux/visibility/slice_visibility.h"
#include "raw_packets.h"

namespace myrialux {
namespace {

/// Slices of a frame that are measured, evenly strewn.
constexpr std::size_t kSlices = 6;
/// Thread CPU seconds and counts, over slices and rounds.
struct Sums {
  double active_s = 0, trace_s = 0, raw_s = 0, ends_s = 0, turned_s = 0;
  std::uint64_t rays = 0, packets = 0, visible = 0, raw_packets = 0, raw_visible = 0;
};

/// One slice of a frame.
struct Slice {
  Slice(const bench::Frame& frame, std::size_t s) : f(frame), rows(f.slices.rows(s)), columns(f.columns(s)) {
    for (const Column& c : columns) lights.push_back(shadow_light(f.lights.lights, index(c.light)));
  }
  const bench::Frame& f;
  std::span<const ReceiverId> rows;
  std::vector<Column> columns;
  std::vector<ShadowLight> lights;
};

/// Rows laid out, active sets found, all active entries traced.
void trace_slice(const Slice& slice, Sums& sums) {
  const bench::Frame& f = slice.f;
  ThreadStopwatch watch;
  SliceVisibility source(f.world, f.rows(), slice.rows, f.lights.lights, slice.columns, true);
  sums.active_s += watch.lap();
  source.forget_occluders();  // each ray by Embree: how near to Embree alone this comes
  BitMatrix visible(slice.rows.size(), slice.columns.size());
  benchmark::DoNotOptimize(trace_all(source, visible));
  sums.trace_s += watch.lap();
  sums.rays += source.rays(), sums.packets += source.packets(), sums.visible += visible.count();
}

/// The same packets by nothing but Embree, from the rows or turned round (from a common origin, the light).
void trace_slice_raw(const Slice& slice, bool from_light, Sums& sums) {
  const bench::Frame& f = slice.f;
  const SliceVisibility source(f.world, f.rows(), slice.rows, f.lights.lights, slice.columns, true);
  const bench::PacketMaker maker(f, slice.rows);
  const auto scene = static_cast<RTCScene>(f.tracer.native_scene());
  std::vector<bench::RawPacket> packets;
  for (std::size_t first = 0; first < slice.columns.size(); first += bench::kChunk) {
    packets.clear();
    for (std::size_t j = first; j < std::min(first + bench::kChunk, slice.columns.size()); ++j)
      maker.add(slice.lights[j], source.active(j), from_light, packets);
    ThreadStopwatch watch;
    bench::trace_raw(scene, packets);
    (from_light ? sums.turned_s : sums.raw_s) += watch.lap() - bench::clock_seconds();
    if (!from_light) sums.raw_packets += packets.size(), sums.raw_visible += bench::count_visible(packets);
  }
}

/// The ends of as many segments alone.
void find_ends(const Slice& slice, std::uint64_t n_packets, Sums& sums) {
  const bench::PacketMaker maker(slice.f, slice.rows);
  Segments<16> s;
  float* const from[3] = {s.from_x, s.from_y, s.from_z};
  float* const to[3] = {s.to_x, s.to_y, s.to_z};
  const std::size_t n_blocks = maker.blocks().size(), n_lights = slice.lights.size();
  ThreadStopwatch watch;
  for (std::size_t k = 0; k < n_packets; ++k) {
    shadow_ends(bench::PacketMaker::rows_of(maker.blocks()[k % n_blocks]), slice.lights[k / n_blocks % n_lights], from,
                to);
    benchmark::DoNotOptimize(s);
  }
  sums.ends_s += watch.lap();
}

/// All ways, in turn: who comes first finds memory colder, so the order changes from round to round.
void measure_slice(const bench::Frame& f, std::size_t s, bool raw_first, Sums& sums) {
  const Slice slice(f, s);
  const std::uint64_t before = sums.packets;
  if (raw_first) trace_slice_raw(slice, false, sums);
  trace_slice(slice, sums);
  if (!raw_first) trace_slice_raw(slice, false, sums);
  trace_slice_raw(slice, true, sums);
  find_ends(slice, sums.packets - before, sums);
}

/// Everything of full visibility (laying out rows, active sets, rays) against the rays alone.
void slices(benchmark::State& state, const bench::NamedScene& named) {
  const bench::Frame& f = bench::frame(named);
  const std::size_t n = std::min(kSlices, f.slices.size() - 1);
  Sums sum;
  std::size_t turn = 0;
  for ([[maybe_unused]] auto _ : state)
    for (std::size_t k = 0; k < n; ++k) measure_slice(f, k * (f.slices.size() - 1) / n, turn++ % 2 == 1, sum);
  if (sum.packets != sum.raw_packets) state.SkipWithError("raw packets are not those of SliceVisibility");
  if (sum.visible != sum.raw_visible) state.SkipWithError("raw Embree sees other bits");
  const double own_s = sum.active_s + sum.trace_s, rounds = static_cast<double>(state.iterations());
  const double rays = static_cast<double>(sum.rays);
  state.counters["ratio_to_embree16"] = sum.raw_s / own_s;
  state.counters["ratio_of_trace_alone"] = sum.raw_s / sum.trace_s;
  state.counters["share_active"] = sum.active_s / own_s;
  state.counters["share_ends"] = sum.ends_s / own_s;
  state.counters["share_rest"] = (sum.trace_s - sum.raw_s - sum.ends_s) / own_s;
  state.counters["raw_from_light"] = sum.raw_s / sum.turned_s;
  state.counters["Mrays/s"] = 1e-6 * rays / own_s;
  state.counters["embree16_Mrays/s"] = 1e-6 * rays / sum.raw_s;
  state.counters["rays/packet"] = rays / static_cast<double>(sum.packets);
  state.counters["n_rays"] = rays / rounds;
  state.counters["n_packets"] = static_cast<double>(sum.packets) / rounds;
  state.counters["n_visible"] = static_cast<double>(sum.visible) / rounds;
}

const bool registered = [] {
  for (const bench::NamedScene& s : bench::scenes())
    benchmark::RegisterBenchmark(("slices/" + s.name).c_str(), slices, s)->Unit(benchmark::kMillisecond);
  return true;
}();

}  // namespace
}  // namespace myrialux
