// Cuts, traces, completes and shades one slice after another, and adds up what they report.
#include "myrialux/methods/slice_driver.h"

#include <algorithm>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/shading/shade.h"

namespace myrialux {
namespace {

/// What one slice leaves behind for the statistics.
struct SliceReport {
  CompletionStats completion;
  ShadeResult shade;
  std::uint64_t rays = 0, columns = 0, memory_bytes = 0;
  double cut_s = 0, visibility_s = 0, complete_s = 0, shade_s = 0;  ///< CPU seconds
};

void add_to_stats(const std::vector<SliceReport>& slices, double loop_wall_s, RenderStats& stats);

}  // namespace

MethodResult render_slices(const FrameView& frame, const MethodParams& params, bool cull, const CompleteSlice& complete,
                           Progress& progress, RenderStats& stats) {
  const Receivers& receivers = frame.receivers;
  Stopwatch wall;

  // Rows and columns are grouped first: both depend only on where things are, not on who sees whom.
  progress.stage("clusters", 0, "");
  const Slices slices = make_slices(receivers, frame.scene_radius, params.slices);
  const LightTree tree = build_light_tree(frame.world, frame.lights, frame.scene_radius, params.tree);
  stats.time_s["cluster"] += wall.lap();

  // Slices are independent, so each thread takes one whole and nothing of it outlives the loop's body.
  MethodResult result;
  result.radiance.resize(receivers.size());
  result.slice.resize(receivers.size());
  result.cut_size.resize(receivers.size());
  result.visibility_fraction.resize(receivers.size());
  std::vector<SliceReport> reports(slices.size());
  progress.stage("slices", slices.size(), "slices");
  parallel_for(slices.size(), [&](std::size_t s) {
    SliceReport& report = reports[s];
    const std::span<const ReceiverId> rows = slices.rows(s);
    ThreadStopwatch cpu;
    const std::vector<Column> columns = light_cut(frame.world, receivers, rows, frame.lights, tree, params.cut);
    report.cut_s = cpu.lap();

    SliceVisibility source(frame.world, receivers, rows, frame.lights, columns, cull);
    BitMatrix visible(rows.size(), columns.size());
    report.visibility_s = cpu.lap();
    Rng rng(params.key, Stage::visibility, s);
    report.completion = complete(source, rng, visible);
    const double completion_s = cpu.lap();
    report.visibility_s += source.trace_seconds();
    report.complete_s = std::max(0.0, completion_s - source.trace_seconds());

    std::vector<Rgb> radiance(rows.size());
    report.shade = shade_slice(frame.world, receivers, rows, frame.lights, columns, visible,
                               {.clamp_distance = params.cut.clamp_distance}, radiance);
    report.shade_s = cpu.lap();

    report.rays = source.rays();
    report.columns = columns.size();
    report.memory_bytes = source.memory_bytes() + visible.words_per_column() * visible.n_columns() * 8;
    const float fraction = report.completion.entries > 0 ? static_cast<float>(report.completion.traced) /
                                                               static_cast<float>(report.completion.entries)
                                                         : 0.0f;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const std::size_t i = index(rows[k]);
      result.radiance[i] = radiance[k];
      result.slice[i] = static_cast<std::uint32_t>(s);
      result.cut_size[i] = static_cast<float>(columns.size());
      result.visibility_fraction[i] = fraction;
    }
    progress.advance(1);
  });
  add_to_stats(reports, wall.lap(), stats);
  return result;
}

namespace {

/// Threads work on different stages at the same time: the loop's wall time is split in proportion to CPU time.
void add_to_stats(const std::vector<SliceReport>& slices, double loop_wall_s, RenderStats& stats) {
  SliceReport sum;
  double radiance = 0, clamped_away = 0;
  for (const SliceReport& s : slices) {
    sum.completion += s.completion;
    sum.rays += s.rays, sum.columns += s.columns;
    sum.memory_bytes = std::max(sum.memory_bytes, s.memory_bytes);
    sum.cut_s += s.cut_s, sum.visibility_s += s.visibility_s, sum.complete_s += s.complete_s, sum.shade_s += s.shade_s;
    radiance += s.shade.radiance_sum, clamped_away += s.shade.clamped_away_sum;
  }
  const double cpu_s = sum.cut_s + sum.visibility_s + sum.complete_s + sum.shade_s;
  const double scale = cpu_s > 0 ? loop_wall_s / cpu_s : 0;
  stats.time_s["cluster"] += scale * sum.cut_s;
  stats.time_s["visibility"] += scale * sum.visibility_s;
  stats.time_s["complete"] += scale * sum.complete_s;
  stats.time_s["shade"] += scale * sum.shade_s;
  stats.visibility.entries += sum.completion.entries;
  stats.visibility.traced += sum.completion.traced;
  stats.visibility.fully_sampled_columns += sum.completion.full_columns;
  stats.visibility.verified_columns += sum.completion.verified_columns;
  stats.rays.shadow += sum.rays;
  stats.slices += slices.size();
  stats.memory.slices_peak = std::max(stats.memory.slices_peak, sum.memory_bytes);
  // Means over passes: each pass adds its own share, the pipeline divides.
  if (!slices.empty()) stats.clusters_mean += static_cast<double>(sum.columns) / static_cast<double>(slices.size());
  stats.clamped_energy_fraction += radiance + clamped_away > 0 ? clamped_away / (radiance + clamped_away) : 0;
}

}  // namespace
}  // namespace myrialux
