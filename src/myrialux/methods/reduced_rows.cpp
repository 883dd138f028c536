// Joins one receiver a slice with every light: tiles of 64 rows and a few thousand lights, each traced and shaded
// whole.
#include "myrialux/methods/reduced_rows.h"

#include <algorithm>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/shading/shade_entries.h"
#include "myrialux/visibility/slice_visibility.h"

namespace myrialux {
namespace {

constexpr std::size_t kRows = 64, kColumns = 2048;  ///< of a tile

/// Items of Stage::cut for representatives; slices have theirs from 0 on.
constexpr std::uint64_t kRepresentativeItem = std::uint64_t{1} << 32;

struct TileReport {
  CompletionStats traced;
  std::uint64_t rays = 0;
  double visibility_s = 0, shade_s = 0;  ///< CPU seconds
};

std::vector<ReceiverId> draw_representatives(const Slices& slices, RandomKey key) {
  std::vector<ReceiverId> drawn(slices.size());
  for (std::size_t s = 0; s < slices.size(); ++s) {
    const std::span<const ReceiverId> rows = slices.rows(s);
    Rng rng(key, Stage::cut, kRepresentativeItem + s);
    drawn[s] = rows[rng.below(static_cast<std::uint32_t>(rows.size()))];
  }
  return drawn;
}

TileReport fill_tile(const FrameView& frame, float clamp_distance, std::span<const ReceiverId> rows,
                     std::size_t first_row, std::span<const LightId> lights, std::size_t first_column,
                     ReducedMatrix& matrix) {
  TileReport report;
  ThreadStopwatch cpu;
  std::vector<Column> columns(lights.size());
  for (std::size_t k = 0; k < lights.size(); ++k) columns[k].light = lights[k];
  SliceVisibility source(frame.world, frame.receivers, rows, frame.lights, columns, true);
  BitMatrix visible(rows.size(), columns.size());
  report.traced = trace_all(source, visible);
  report.rays = source.rays();
  report.visibility_s = cpu.lap();

  std::vector<float> entries(columns.size() * kRows), row(columns.size());
  shade_entries(frame.world, frame.receivers, rows, frame.lights, columns, visible, {.clamp_distance = clamp_distance},
                entries);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < columns.size(); ++k) row[k] = entries[k * kRows + i];
    matrix.set(first_row + i, first_column, row);
  }
  report.shade_s = cpu.lap();
  return report;
}

}  // namespace

ReducedRows trace_reduced_rows(const FrameView& frame, const MethodParams& params, const Slices& slices,
                               const LightTree& tree, Progress& progress, RenderStats& stats) {
  Stopwatch wall;
  ReducedRows reduced{ReducedMatrix(slices.size(), tree.n_lights()), draw_representatives(slices, params.key)};
  const std::size_t n_down = (slices.size() + kRows - 1) / kRows,
                    n_across = (tree.n_lights() + kColumns - 1) / kColumns;
  std::vector<TileReport> reports(n_down * n_across);
  progress.stage("reduced matrix", reports.size(), "tiles");
  parallel_for(reports.size(), [&](std::size_t t) {
    const std::size_t row = t / n_across * kRows, column = t % n_across * kColumns;
    const std::span<const ReceiverId> rows = std::span(reduced.representative).subspan(row);
    const std::span<const LightId> lights = std::span(tree.order).subspan(column);
    reports[t] = fill_tile(frame, params.cut.clamp_distance, rows.first(std::min(kRows, rows.size())), row,
                           lights.first(std::min(kColumns, lights.size())), column, reduced.matrix);
    progress.advance(1);
  });

  TileReport sum;
  for (const TileReport& r : reports)
    sum.traced += r.traced, sum.rays += r.rays, sum.visibility_s += r.visibility_s, sum.shade_s += r.shade_s;
  stats.visibility.entries += sum.traced.entries, stats.visibility.traced += sum.traced.traced;
  stats.rays.shadow += sum.rays;
  const double wall_s = wall.lap(), cpu_s = sum.visibility_s + sum.shade_s;
  const double visibility_s = cpu_s > 0 ? wall_s * sum.visibility_s / cpu_s : 0;
  stats.time_s["visibility"] += visibility_s;
  stats.time_s["cluster"] += wall_s - visibility_s;
  return reduced;
}

}  // namespace myrialux
