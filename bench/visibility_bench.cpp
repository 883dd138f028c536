// Full visibility of slices against raw Embree on the same packets, in turn, in one process: what a ray costs beyond
// Embree. Raw rays are prepared beforehand, lie in the cache and are traced in place: nothing but rtcOccluded16.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <bit>
#include <span>
#include <vector>

#include "bench_frame.h"
#include "myrialux/base/clock.h"
#include "myrialux/completion/bamc.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/trace/embree.h"
#include "myrialux/visibility/shadow_light.h"
#include "myrialux/visibility/slice_visibility.h"

namespace myrialux {
namespace {

/// Slices of a frame that are measured, evenly strewn.
constexpr std::size_t kSlices = 6;
/// Columns whose packets are prepared at a time: 4 of 64 packets of 832 bytes stay in the second cache.
constexpr std::size_t kChunk = 4;
/// As SliceVisibility: blocks of fewer rows share packets.
constexpr int kLeastOwnRows = 8;

/// 16 rays of which some are traced, ready for Embree.
struct alignas(64) RawPacket {
  RTCRay16 rays;
  int valid[16];
};

/// Rows of a slice in its order.
struct alignas(64) BlockOfRows {
  PacketFloats p[3] = {}, ng[3] = {}, offset = {};
};

/// What SliceVisibility lays out, for packets of our own.
class PacketMaker {
 public:
  PacketMaker(const bench::Frame& frame, std::span<const ReceiverId> rows) : blocks_((rows.size() + 15) / 16) {
    for (std::size_t r = 0; r < rows.size(); ++r) set(blocks_[r / 16], r % 16, frame.rows(), index(rows[r]));
  }

  /// The packets of one column: own ones of blocks with enough rows, the others gathered.
  void add(const ShadowLight& light, Words wanted, bool from_light, std::vector<RawPacket>& packets) const {
    BlockOfRows gathered;
    std::size_t n = 0;
    for (std::size_t w = 0; w < wanted.size(); ++w)
      for (std::size_t q = 0; q < 4; ++q) {
        const std::uint32_t valid = wanted[w] >> 16 * q & 0xffff;
        if (std::popcount(valid) < kLeastOwnRows) {
          for (std::uint32_t left = valid; left != 0; left &= left - 1) {
            copy(blocks_[4 * w + q], static_cast<std::size_t>(std::countr_zero(left)), gathered, n++);
            if (n < 16) continue;
            packets.push_back(packet(gathered, light, 0xffff, from_light));
            n = 0;
          }
        } else {
          packets.push_back(packet(blocks_[4 * w + q], light, valid, from_light));
        }
      }
    if (n > 0) packets.push_back(packet(gathered, light, static_cast<std::uint32_t>(low_bits(n)), from_light));
  }

  static PacketRows rows_of(const BlockOfRows& b) {
    return {{b.p[0], b.p[1], b.p[2]}, {b.ng[0], b.ng[1], b.ng[2]}, b.offset};
  }
  const std::vector<BlockOfRows>& blocks() const { return blocks_; }

 private:
  static void set(BlockOfRows& b, std::size_t lane, const Receivers& receivers, std::size_t i) {
    for (int k = 0; k < 3; ++k) b.p[k][lane] = receivers.p[i][k], b.ng[k][lane] = receivers.ng[i][k];
    b.offset[lane] = receivers.offset[i];
  }
  static void copy(const BlockOfRows& from, std::size_t a, BlockOfRows& to, std::size_t b) {
    for (int k = 0; k < 3; ++k) to.p[k][b] = from.p[k][a], to.ng[k][b] = from.ng[k][a];
    to.offset[b] = from.offset[a];
  }
  static RawPacket packet(const BlockOfRows& rows, const ShadowLight& light, std::uint32_t valid, bool from_light) {
    alignas(64) Segments<16> s;
    float* const from[3] = {s.from_x, s.from_y, s.from_z};
    float* const to[3] = {s.to_x, s.to_y, s.to_z};
    shadow_ends(rows_of(rows), light, from, to);
    RawPacket made{};
    RTCRay16& r = made.rays;
    const bool distant = light.end == SegmentEnd::direction;
    for (int k = 0; k < 16; ++k) {
      made.valid[k] = valid >> k & 1 ? -1 : 0;
      const float d[3] = {distant ? s.to_x[k] : s.to_x[k] - s.from_x[k], distant ? s.to_y[k] : s.to_y[k] - s.from_y[k],
                          distant ? s.to_z[k] : s.to_z[k] - s.from_z[k]};
      const bool turned = from_light && !distant;
      r.org_x[k] = turned ? s.to_x[k] : s.from_x[k], r.dir_x[k] = turned ? -d[0] : d[0];
      r.org_y[k] = turned ? s.to_y[k] : s.from_y[k], r.dir_y[k] = turned ? -d[1] : d[1];
      r.org_z[k] = turned ? s.to_z[k] : s.from_z[k], r.dir_z[k] = turned ? -d[2] : d[2];
      r.tfar[k] = distant ? kInfinity : 1 - 0x1p-20f;
      r.mask[k] = 0xffffffffu, r.id[k] = static_cast<unsigned>(k);
    }
    return made;
  }

  std::vector<BlockOfRows> blocks_;
};

/// Nothing but Embree; rays are spoilt.
void trace_raw(RTCScene scene, std::span<RawPacket> packets) {
  for (RawPacket& p : packets) {
    EmbreeContext context;
    init_context(context);
    embree_occluded<16>(p.valid, scene, context, p.rays, true);
  }
}

std::uint64_t count_visible(std::span<const RawPacket> packets) {
  std::uint64_t n = 0;
  for (const RawPacket& p : packets)
    for (int k = 0; k < 16; ++k) n += p.valid[k] != 0 && p.rays.tfar[k] >= 0;
  return n;
}

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
  BitMatrix visible(slice.rows.size(), slice.columns.size());
  benchmark::DoNotOptimize(trace_all(source, visible));
  sums.trace_s += watch.lap();
  sums.rays += source.rays(), sums.packets += source.packets(), sums.visible += visible.count();
}

/// The same packets by nothing but Embree, from the rows or turned round (from a common origin, the light).
void trace_slice_raw(const Slice& slice, bool from_light, Sums& sums) {
  const bench::Frame& f = slice.f;
  const SliceVisibility source(f.world, f.rows(), slice.rows, f.lights.lights, slice.columns, true);
  const PacketMaker maker(f, slice.rows);
  const auto scene = static_cast<RTCScene>(f.tracer.native_scene());
  std::vector<RawPacket> packets;
  for (std::size_t first = 0; first < slice.columns.size(); first += kChunk) {
    packets.clear();
    for (std::size_t j = first; j < std::min(first + kChunk, slice.columns.size()); ++j)
      maker.add(slice.lights[j], source.active(j), from_light, packets);
    ThreadStopwatch watch;
    trace_raw(scene, packets);
    (from_light ? sums.turned_s : sums.raw_s) += watch.lap();
    if (!from_light) sums.raw_packets += packets.size(), sums.raw_visible += count_visible(packets);
  }
}

/// The ends of as many segments alone.
void find_ends(const Slice& slice, std::uint64_t n_packets, Sums& sums) {
  const PacketMaker maker(slice.f, slice.rows);
  Segments<16> s;
  float* const from[3] = {s.from_x, s.from_y, s.from_z};
  float* const to[3] = {s.to_x, s.to_y, s.to_z};
  const std::size_t n_blocks = maker.blocks().size(), n_lights = slice.lights.size();
  ThreadStopwatch watch;
  for (std::size_t k = 0; k < n_packets; ++k) {
    shadow_ends(PacketMaker::rows_of(maker.blocks()[k % n_blocks]), slice.lights[k / n_blocks % n_lights], from, to);
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
