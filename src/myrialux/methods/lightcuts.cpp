// A light cut for every receiver, refined until each cluster's error bound is a small share of the receiver's total.
// [walter05] Deviations: docs/methods/lightcuts.md.
#include <algorithm>
#include <bit>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/clusters/receiver_cut.h"
#include "myrialux/methods/render.h"
#include "myrialux/shading/gather.h"
#include "myrialux/visibility/shadow_light.h"

namespace myrialux {
namespace {

/// One block in this many is timed: clocks around every packet of rays would cost a twentieth of it.
constexpr std::size_t kTimedStride = 16;

/// Counters of one block of receivers.
struct BlockReport {
  std::uint64_t rays = 0, sizes = 0;
  double trace_s = 0, shade_s = 0, all_s = 0;  ///< of timed blocks
};

/// 64 receivers laid out for the kernels; lights are evaluated at 16 of them at a time.
class Block final : public LightAtPacket {
 public:
  Block(const FrameView& frame, std::span<const ReceiverId> rows, float clamp_distance, bool timed);
  /// Chooses the 16 receivers that evaluate() is about.
  void select(std::size_t packet) { first_ = packet * kPacketRows; }
  void evaluate(LightId light, std::uint32_t rows, PacketLight& arriving) override;
  /// Rays so far; seconds of tracing and shading if timed.
  const BlockReport& report() const { return report_; }

 private:
  /// Unoccluded; @param rows bits of the block
  void shade(LightId light, std::uint64_t rows);
  std::uint32_t occluded(LightId light, std::uint32_t rows);

  const FrameView& frame_;
  float clamp_distance_;
  bool timed_;
  Stopwatch watch_;
  std::size_t first_ = 0;
  BlockReport report_;
  GatheredRows rows_;
  CoatTables tables_;
  GatheredColumns column_;
  alignas(64) BlockFloats offset_{};
  BlockSums diffuse_{}, others_{};
};

LightTree build_tree(const FrameView& frame, const MethodParams& params);
void cut_block(const FrameView& frame, const MethodParams& params, const LightTree& tree, std::size_t first_row,
               std::span<const ReceiverId> rows, bool timed, MethodResult& result, BlockReport& report);
void add_to_stats(std::span<const BlockReport> reports, std::size_t n_receivers, double wall_s, RenderStats& stats);

}  // namespace

MethodResult render_lightcuts(const FrameView& frame, const MethodParams& params, Progress& progress,
                              RenderStats& stats) {
  // Neighbours share packets: the order of slices, without their borders.
  Stopwatch wall;
  progress.stage("clusters", 0, "");
  const Slices slices = make_slices(frame.receivers, frame.scene_radius, params.slices);
  const LightTree tree = build_tree(frame, params);
  stats.time_s["cluster"] += wall.lap();

  const std::size_t n = frame.receivers.size(), n_blocks = (n + kBlockRows - 1) / kBlockRows;
  MethodResult result;
  result.radiance.resize(n);
  result.slice.resize(n);
  result.cut_size.resize(n);
  result.visibility_fraction.assign(n, 1);
  std::vector<BlockReport> reports(n_blocks);
  progress.stage("receivers", n, "receivers");
  parallel_for(n_blocks, [&](std::size_t b) {
    const std::size_t first = b * kBlockRows, count = std::min(kBlockRows, n - first);
    cut_block(frame, params, tree, first, std::span(slices.order).subspan(first, count), b % kTimedStride == 0, result,
              reports[b]);
    progress.advance(count);
  });
  add_to_stats(reports, n, wall.lap(), stats);
  return result;
}

namespace {

LightTree build_tree(const FrameView& frame, const MethodParams& params) {
  if (params.lightcuts.tree == TreeKind::divisive)
    return build_light_tree(frame.world, frame.lights, frame.scene_radius, params.tree);
  return build_agglomerative_tree(frame.world, frame.lights, frame.scene_radius, {.key = params.tree.key});
}

void cut_block(const FrameView& frame, const MethodParams& params, const LightTree& tree, std::size_t first_row,
               std::span<const ReceiverId> rows, bool timed, MethodResult& result, BlockReport& report) {
  Stopwatch wall;
  const float clamp = params.cut.clamp_distance;
  const CutPoints points = make_cut_points(frame.world, frame.receivers, rows, clamp);
  const ReceiverCutParams cut_params{params.lightcuts.error, params.cut.n_clusters};
  Block block(frame, rows, clamp, timed);
  std::uint64_t sizes = 0;
  for (std::size_t g = 0; g < points.groups.size(); ++g) {
    block.select(g);
    const std::size_t first = g * kCutLanes, count = std::min(kCutLanes, rows.size() - first);
    const std::size_t step = params.lightcuts.together ? count : 1;
    for (std::size_t k = 0; k < count; k += step) {
      const PacketCut cut = cut_packet(tree, points, g, ((1u << step) - 1) << k, cut_params, block);
      for (std::size_t lane = k; lane < k + step; ++lane) {
        const std::size_t i = index(rows[first + lane]);
        result.radiance[i] = cut.radiance[lane];
        result.slice[i] = static_cast<std::uint32_t>(first_row / kCutLanes + g);
        result.cut_size[i] = static_cast<float>(cut.size[lane]);
        sizes += cut.size[lane];
      }
    }
  }
  report = block.report();
  report.sizes = sizes;
  if (timed) report.all_s = wall.elapsed();
}

/// The loop's time is split as the timed blocks' is.
void add_to_stats(std::span<const BlockReport> reports, std::size_t n_receivers, double wall_s, RenderStats& stats) {
  BlockReport sum;
  for (const BlockReport& r : reports) {
    sum.rays += r.rays, sum.sizes += r.sizes;
    sum.trace_s += r.trace_s, sum.shade_s += r.shade_s, sum.all_s += r.all_s;
  }
  const double scale = sum.all_s > 0 ? wall_s / sum.all_s : 0;
  stats.time_s["cluster"] += scale * (sum.all_s - sum.trace_s - sum.shade_s);
  stats.time_s["visibility"] += scale * sum.trace_s;
  stats.time_s["shade"] += scale * sum.shade_s;
  stats.visibility.entries += sum.rays;
  stats.visibility.traced += sum.rays;
  stats.rays.shadow += sum.rays;
  if (n_receivers > 0) stats.clusters_mean += static_cast<double>(sum.sizes) / static_cast<double>(n_receivers);
}

Block::Block(const FrameView& frame, std::span<const ReceiverId> rows, float clamp_distance, bool timed)
    : frame_(frame), clamp_distance_(clamp_distance), timed_(timed) {
  gather_rows(frame.world, frame.receivers, rows, tables_, rows_);
  for (std::size_t k = 0; k < rows.size(); ++k) offset_[k] = frame.receivers.offset[index(rows[k])];
}

void Block::evaluate(LightId light, std::uint32_t rows, PacketLight& arriving) {
  if (timed_) watch_.lap();
  shade(light, std::uint64_t{rows} << first_);
  std::uint32_t lit = 0;
  for (std::size_t k = 0; k < kPacketRows; ++k) {
    const std::size_t row = first_ + k;
    float sum = 0;
    const float albedo[3] = {rows_.albedo[row].r, rows_.albedo[row].g, rows_.albedo[row].b};
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = albedo[c] * diffuse_.rgb[c][row] + others_.rgb[c][row];
      arriving.rgb[c][k] = value;
      sum += value;
    }
    if (sum > 0) lit |= 1u << k;
  }
  lit &= rows;
  if (timed_) report_.shade_s += watch_.lap();
  if (lit == 0) return;
  report_.rays += static_cast<std::uint64_t>(std::popcount(lit));
  const std::uint32_t blocked = occluded(light, lit);
  for (std::size_t k = 0; k < kPacketRows; ++k)
    if (blocked >> k & 1)
      for (auto& channel : arriving.rgb) channel[k] = 0;
  if (timed_) report_.trace_s += watch_.lap();
}

void Block::shade(LightId light, std::uint64_t rows) {
  for (std::size_t c = 0; c < 3; ++c) {
    std::fill_n(diffuse_.rgb[c] + first_, kPacketRows, 0.0f);
    std::fill_n(others_.rgb[c] + first_, kPacketRows, 0.0f);
  }
  const Column column{light};
  gather_columns(frame_.world, frame_.lights, std::span(&column, 1), tables_, column_);
  bool fast = false;
  for (std::size_t kind = 0; kind < column_.diffuse.size(); ++kind) {
    const DiffuseColumns& run = column_.diffuse[kind];
    const std::uint64_t bits = rows & rows_.diffuse;
    if (run.lights.empty()) continue;
    fast = true;
    if (bits == 0) continue;
    shade_diffuse(rows_.block,
                  {.kind = static_cast<DiffuseLight>(kind),
                   .lights = run.lights,
                   .visible = std::span(&bits, 1),
                   .bumpy = run.bumpy || rows_.bumpy,
                   .clamp_distance = clamp_distance_,
                   .tracked = 0},
                  diffuse_);
  }
  const std::uint64_t bits = rows & (fast ? rows_.others : rows_.others | rows_.diffuse);
  if (bits == 0 || column_.general.empty()) return;
  shade_general(rows_.block, rows_.lobes,
                {.lights = column_.general,
                 .visible = std::span(&bits, 1),
                 .spots = column_.spots,
                 .lobes = column_.lobes,
                 .tables = tables_.values(),
                 .clamp_distance = clamp_distance_,
                 .tracked = 0},
                others_);
}

std::uint32_t Block::occluded(LightId light, std::uint32_t rows) {
  const ShadowLight end = shadow_light(frame_.lights, index(light));
  const RowBlock& b = rows_.block;
  const PacketRows packet{{b.p[0] + first_, b.p[1] + first_, b.p[2] + first_},
                          {b.ng[0] + first_, b.ng[1] + first_, b.ng[2] + first_},
                          offset_ + first_};
  Segments<16> s;
  float* const from[3] = {s.from_x, s.from_y, s.from_z};
  float* const to[3] = {s.to_x, s.to_y, s.to_z};
  shadow_ends(packet, end, from, to);
  const Tracer& tracer = frame_.world.tracer;
  const bool distant = end.end == SegmentEnd::direction;
  if (std::popcount(rows) > 1)
    return distant ? tracer.occluded_packet_direction<16>(s, rows, true) : tracer.occluded_packet<16>(s, rows, true);
  const auto k = static_cast<std::size_t>(std::countr_zero(rows));
  const Vec3 a{s.from_x[k], s.from_y[k], s.from_z[k]}, t{s.to_x[k], s.to_y[k], s.to_z[k]};
  return (distant ? tracer.occluded_direction(a, t) : tracer.occluded(a, t)) ? rows : 0;
}

}  // namespace
}  // namespace myrialux
