// Every receiver, every virtual light, every ray: what all other methods approximate for the same lights. The stages of
// the slice methods with all lights as columns, some at a time; its plain twin is reference/brute_force.h.
#include <algorithm>
#include <tuple>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/methods/slice_driver.h"
#include "myrialux/shading/shade.h"

namespace myrialux {
namespace {

struct SliceSums {
  std::uint64_t entries = 0, rays = 0, memory_bytes = 0;
  double radiance = 0, clamped_away = 0;  ///< luminance
  double visibility_s = 0, shade_s = 0;   ///< CPU seconds
};

/// Adds kBruteForceColumns lights at a time in double precision, in the order of the tree.
SliceSums gather_all(const FrameView& frame, const MethodParams& params, std::span<const ReceiverId> rows,
                     std::span<const LightId> lights, std::span<Rgb> radiance);
std::vector<Column> all_columns(const VirtualLights& lights, std::span<const LightId> chosen, Vec3 centre);

}  // namespace

MethodResult render_brute_force(const FrameView& frame, const MethodParams& params, Progress& progress,
                                RenderStats& stats) {
  // Groups only bring together what packets and caches like; the sums are over everything.
  Stopwatch wall;
  progress.stage("clusters", 0, "");
  const Slices slices = make_slices(frame.receivers, frame.scene_radius, params.slices);
  const LightTree tree = build_light_tree(frame.world, frame.lights, frame.scene_radius, params.tree);
  stats.time_s["cluster"] += wall.lap();

  MethodResult result;
  result.radiance.resize(frame.receivers.size());
  std::vector<SliceSums> reports(slices.size());
  progress.stage("brute force", frame.receivers.size(), "receivers");
  parallel_for(slices.size(), [&](std::size_t s) {
    const std::span<const ReceiverId> rows = slices.rows(s);
    std::vector<Rgb> radiance(rows.size());
    reports[s] = gather_all(frame, params, rows, tree.order, radiance);
    for (std::size_t r = 0; r < rows.size(); ++r) result.radiance[index(rows[r])] = radiance[r];
    progress.advance(rows.size());
  });

  SliceSums sum;
  for (const SliceSums& s : reports) {
    sum.entries += s.entries, sum.rays += s.rays, sum.memory_bytes = std::max(sum.memory_bytes, s.memory_bytes);
    sum.radiance += s.radiance, sum.clamped_away += s.clamped_away;
    sum.visibility_s += s.visibility_s, sum.shade_s += s.shade_s;
  }
  const double cpu_s = sum.visibility_s + sum.shade_s, scale = cpu_s > 0 ? wall.lap() / cpu_s : 0;
  stats.time_s["visibility"] += scale * sum.visibility_s;
  stats.time_s["shade"] += scale * sum.shade_s;
  stats.visibility.entries += sum.entries, stats.visibility.traced += sum.entries;
  stats.rays.shadow += sum.rays;
  stats.memory.slices_peak = std::max(stats.memory.slices_peak, sum.memory_bytes);
  const double unclamped = sum.radiance + sum.clamped_away;
  stats.clamped_energy_fraction += unclamped > 0 ? sum.clamped_away / unclamped : 0;
  return result;
}

namespace {

SliceSums gather_all(const FrameView& frame, const MethodParams& params, std::span<const ReceiverId> rows,
                     std::span<const LightId> lights, std::span<Rgb> radiance) {
  struct Sum {
    double r = 0, g = 0, b = 0;
  };
  std::vector<Sum> sums(rows.size());
  std::vector<Rgb> part(rows.size());
  const Vec3 centre = slice_centre(frame.receivers, rows);
  SliceSums report;
  ThreadStopwatch cpu;
  for (std::size_t first = 0; first < lights.size(); first += kBruteForceColumns) {
    const std::size_t n = std::min<std::size_t>(kBruteForceColumns, lights.size() - first);
    const std::vector<Column> columns = all_columns(frame.lights, lights.subspan(first, n), centre);
    SliceVisibility source(frame.world, frame.receivers, rows, frame.lights, columns, /*cull=*/true);
    BitMatrix visible(rows.size(), columns.size());
    report.entries += trace_all(source, visible).entries;
    report.rays += source.rays();
    report.memory_bytes = source.memory_bytes() + visible.n_words() * sizeof(std::uint64_t);
    report.visibility_s += cpu.lap();

    const ShadeResult shaded = shade_slice(frame.world, frame.receivers, rows, frame.lights, columns, visible,
                                           {.clamp_distance = params.cut.clamp_distance}, part);
    for (std::size_t r = 0; r < rows.size(); ++r)
      sums[r].r += static_cast<double>(part[r].r), sums[r].g += static_cast<double>(part[r].g),
          sums[r].b += static_cast<double>(part[r].b);
    report.radiance += shaded.radiance_sum, report.clamped_away += shaded.clamped_away_sum;
    report.shade_s += cpu.lap();
  }
  for (std::size_t r = 0; r < rows.size(); ++r)
    radiance[r] = {static_cast<float>(sums[r].r), static_cast<float>(sums[r].g), static_cast<float>(sums[r].b)};
  return report;
}

/// Ordered as light_cut() orders them.
std::vector<Column> all_columns(const VirtualLights& lights, std::span<const LightId> chosen, Vec3 centre) {
  std::vector<Column> columns;
  columns.reserve(chosen.size());
  for (const LightId j : chosen)
    columns.push_back({.light = j, .octant = static_cast<std::uint8_t>(octant(centre, lights, j))});
  std::stable_sort(columns.begin(), columns.end(), [&](const Column& a, const Column& b) {
    return std::tuple(lights.kind[index(a.light)], a.octant) < std::tuple(lights.kind[index(b.light)], b.octant);
  });
  return columns;
}

}  // namespace
}  // namespace myrialux
