// What the machine can do at most: memory, and Embree on rays prepared beforehand. The measure of all other figures.
#include <benchmark/benchmark.h>

#include <cstring>
#include <vector>

#include "bench_frame.h"
#include "myrialux/base/parallel.h"
#include "myrialux/math/warp.h"
#include "raw_packets.h"

namespace myrialux {
namespace {

/// Far more than the caches hold.
constexpr std::size_t kWords = std::size_t{1} << 24, kPart = kWords / 64;
/// 832 KiB of rays: the second cache holds them.
constexpr std::size_t kPackets = 1024;

struct Memory {
  std::vector<std::uint64_t> a = std::vector<std::uint64_t>(kWords, 1), b = std::vector<std::uint64_t>(kWords, 2);
};
Memory& memory() {
  static Memory made;
  return made;
}

/// Argument: threads. `bytes`: moved an iteration.
template <class Part>
void run_memory(benchmark::State& state, double bytes, const Part& part) {
  const ThreadScope scope(static_cast<int>(state.range(0)));
  for ([[maybe_unused]] auto _ : state) parallel_for(64, [&](std::size_t k) { part(k * kPart); });
  state.counters["GB/s"] = benchmark::Counter(bytes * 1e-9, benchmark::Counter::kIsIterationInvariantRate);
}

void memory_read(benchmark::State& state) {
  const Memory& m = memory();
  run_memory(state, kWords * 8.0, [&](std::size_t first) {
    std::uint64_t sum[4] = {};
    for (std::size_t i = first; i < first + kPart; i += 4)
      for (std::size_t k = 0; k < 4; ++k) sum[k] += m.a[i + k];
    benchmark::DoNotOptimize(sum);
  });
}
void memory_write(benchmark::State& state) {
  Memory& m = memory();
  run_memory(state, kWords * 8.0, [&](std::size_t first) {
    std::memset(m.a.data() + first, 3, kPart * 8);
    benchmark::ClobberMemory();
  });
}
/// Bytes read and bytes written both count.
void memory_copy(benchmark::State& state) {
  Memory& m = memory();
  run_memory(state, kWords * 16.0, [&](std::size_t first) {
    std::memcpy(m.b.data() + first, m.a.data() + first, kPart * 8);
    benchmark::ClobberMemory();
  });
}

/// Packets of a frame's first slices.
std::vector<bench::RawPacket> packets_of(const bench::Frame& f) {
  std::vector<bench::RawPacket> packets;
  Rng rng({1}, Stage::test, 0);
  while (packets.size() < kPackets) {
    const std::size_t s = rng.below(static_cast<std::uint32_t>(f.slices.size()));
    const std::vector<Column> columns = f.columns(s);
    const bench::PacketMaker maker(f, f.slices.rows(s).first(16));
    for (std::size_t j = 0; j < columns.size() && packets.size() < kPackets; j += 16) {
      const std::uint64_t all = 0xffff;
      maker.add(shadow_light(f.lights.lights, index(columns[j].light)), Words(&all, 1), false, packets);
    }
  }
  return packets;
}

template <int N>
RayPacket<N> part_of(const RTCRay16& r, int first) {
  RayPacket<N> part{};
  for (int k = 0; k < N; ++k) {
    part.org_x[k] = r.org_x[first + k], part.org_y[k] = r.org_y[first + k], part.org_z[k] = r.org_z[first + k];
    part.dir_x[k] = r.dir_x[first + k], part.dir_y[k] = r.dir_y[first + k], part.dir_z[k] = r.dir_z[first + k];
    part.tfar[k] = r.tfar[first + k], part.mask[k] = 0xffffffffu;
  }
  return part;
}

void report_rays(benchmark::State& state, std::size_t n) {
  state.counters["Mrays/s"] =
      benchmark::Counter(static_cast<double>(n) * 1e-6, benchmark::Counter::kIsIterationInvariantRate);
}

/// Rays as they are handed to each width, their t set anew each time. Argument: threads.
template <int N>
void occluded(benchmark::State& state, const bench::NamedScene& named) {
  const bench::Frame& f = bench::frame(named);
  std::vector<RayPacket<N>> rays;
  for (const bench::RawPacket& p : packets_of(f))
    for (int first = 0; first < 16; first += N) rays.push_back(part_of<N>(p.rays, first));
  const std::vector<RayPacket<N>> given = rays;
  alignas(64) const int valid[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
  const auto scene = static_cast<RTCScene>(f.tracer.native_scene());
  const ThreadScope scope(static_cast<int>(state.range(0)));
  for ([[maybe_unused]] auto _ : state)
    parallel_for(16, [&](std::size_t part) {
      EmbreeContext context;
      init_context(context);
      for (std::size_t i = part * rays.size() / 16; i < (part + 1) * rays.size() / 16; ++i) {
        std::memcpy(rays[i].tfar, given[i].tfar, sizeof rays[i].tfar);
        embree_occluded<N>(valid, scene, context, rays[i], true);
      }
    });
  report_rays(state, N * rays.size());
}
void occluded_single(benchmark::State& state, const bench::NamedScene& named) {
  const bench::Frame& f = bench::frame(named);
  std::vector<RTCRay> rays;
  for (const bench::RawPacket& p : packets_of(f))
    for (int k = 0; k < 16; ++k)
      rays.push_back({p.rays.org_x[k], p.rays.org_y[k], p.rays.org_z[k], 0, p.rays.dir_x[k], p.rays.dir_y[k],
                      p.rays.dir_z[k], 0, p.rays.tfar[k], 0xffffffffu, 0, 0});
  const auto scene = static_cast<RTCScene>(f.tracer.native_scene());
  for ([[maybe_unused]] auto _ : state) {
    EmbreeContext context;
    init_context(context);
    for (RTCRay ray : rays) {
      embree_occluded<1>(nullptr, scene, context, ray, true);
      benchmark::DoNotOptimize(ray.tfar);
    }
  }
  report_rays(state, rays.size());
}

/// Closest hits of camera rays, pixel after pixel, or of rays that leave the receivers anywhere.
void intersect(benchmark::State& state, const bench::NamedScene& named, bool scattered) {
  const bench::Frame& f = bench::frame(named);
  const std::vector<Ray> rays = scattered ? bench::scattered_rays(f, 1 << 14) : bench::camera_rays(f, 1 << 14);
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(bench::intersect_all(f, rays));
  report_rays(state, rays.size());
}

/// Rates of one thread are by its CPU time, which other programs disturb less; those of all threads by real time.
template <class Add>
void register_threads(const Add& add) {
  add()->ArgName("threads")->Arg(1)->Unit(benchmark::kMicrosecond);
  if (available_threads() > 1)
    add()->ArgName("threads")->Arg(available_threads())->Unit(benchmark::kMicrosecond)->UseRealTime();
}

const bool registered = [] {
  register_threads([] { return benchmark::RegisterBenchmark("memory_read", memory_read); });
  register_threads([] { return benchmark::RegisterBenchmark("memory_write", memory_write); });
  register_threads([] { return benchmark::RegisterBenchmark("memory_copy", memory_copy); });
  for (const bench::NamedScene& s : bench::scenes()) {
    const auto add = [&](const char* what, auto body, auto... more) {
      return benchmark::RegisterBenchmark((what + s.name).c_str(), body, s, more...);
    };
    register_threads([&] { return add("occluded16/", occluded<16>); });
    add("occluded8/", occluded<8>)->ArgName("threads")->Arg(1)->Unit(benchmark::kMicrosecond);
    add("occluded1/", occluded_single)->Unit(benchmark::kMicrosecond);
    add("intersect1_camera/", intersect, false)->Unit(benchmark::kMicrosecond);
    add("intersect1_scattered/", intersect, true)->Unit(benchmark::kMicrosecond);
  }
  return true;
}();

}  // namespace
}  // namespace myrialux
