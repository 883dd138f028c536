// Every receiver, every virtual light, every ray: what all other methods approximate for the same lights. The stages of
// the slice methods with all lights as columns, some at a time; its plain twin is reference/brute_force.h.
#include <algorithm>
#include <memory>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/methods/slice_driver.h"
#include "myrialux/shading/shade.h"

namespace myrialux {
namespace {

struct SliceSums {
  std::uint64_t entries = 0, rays = 0, memory_bytes = 0;
  double visibility_s = 0, shade_s = 0;  ///< CPU seconds
};

MethodResult gather(const FrameView& frame, const MethodParams& params, std::span<const LightId> lights,
                    Progress& progress, RenderStats& stats);
/// Adds kBruteForceColumns lights at a time in double precision, in the order given: a row's sum does not depend on
/// which rows share its slice.
SliceSums gather_slice(const FrameView& frame, const MethodParams& params, std::span<const ReceiverId> rows,
                       std::span<const LightId> lights, std::span<Rgb> radiance);

}  // namespace

MethodResult render_brute_force(const FrameView& frame, const MethodParams& params, Progress& progress,
                                RenderStats& stats) {
  const Method method = prepare_brute_force(frame.world, frame.lights, frame.scene_radius, params, progress, stats);
  return method(frame, params, progress, stats);
}

Method prepare_brute_force(const World& world, const VirtualLights& lights, float scene_radius,
                           const MethodParams& params, Progress& progress, RenderStats& stats) {
  // The tree's order only brings together what caches like; lights that send nothing are not in it.
  const Stopwatch wall;
  progress.stage("clusters", 0, "");
  const auto order =
      std::make_shared<const std::vector<LightId>>(build_light_tree(world, lights, scene_radius, params.tree).order);
  stats.time_s["cluster"] += wall.elapsed();
  return [order](const FrameView& frame, const MethodParams& own, Progress& shown, RenderStats& counted) {
    return gather(frame, own, *order, shown, counted);
  };
}

namespace {

MethodResult gather(const FrameView& frame, const MethodParams& params, std::span<const LightId> lights,
                    Progress& progress, RenderStats& stats) {
  Stopwatch wall;
  const Slices slices = make_slices(frame.receivers, frame.scene_radius, params.slices);
  stats.time_s["cluster"] += wall.lap();
  MethodResult result;
  result.radiance.resize(frame.receivers.size());
  std::vector<SliceSums> reports(slices.size());
  progress.stage("brute force", frame.receivers.size(), "receivers");
  parallel_for(slices.size(), [&](std::size_t s) {
    const std::span<const ReceiverId> rows = slices.rows(s);
    std::vector<Rgb> radiance(rows.size());
    reports[s] = gather_slice(frame, params, rows, lights, radiance);
    for (std::size_t r = 0; r < rows.size(); ++r) result.radiance[index(rows[r])] = radiance[r];
    progress.advance(rows.size());
  });

  SliceSums sum;
  for (const SliceSums& s : reports) {
    sum.entries += s.entries, sum.rays += s.rays, sum.memory_bytes = std::max(sum.memory_bytes, s.memory_bytes);
    sum.visibility_s += s.visibility_s, sum.shade_s += s.shade_s;
  }
  const double cpu_s = sum.visibility_s + sum.shade_s, scale = cpu_s > 0 ? wall.lap() / cpu_s : 0;
  stats.time_s["visibility"] += scale * sum.visibility_s;
  stats.time_s["shade"] += scale * sum.shade_s;
  stats.visibility.entries += sum.entries, stats.visibility.traced += sum.entries;
  stats.rays.shadow += sum.rays;
  stats.memory.slices_peak = std::max(stats.memory.slices_peak, sum.memory_bytes);
  return result;
}

SliceSums gather_slice(const FrameView& frame, const MethodParams& params, std::span<const ReceiverId> rows,
                       std::span<const LightId> lights, std::span<Rgb> radiance) {
  struct Sum {
    double r = 0, g = 0, b = 0;
  };
  std::vector<Sum> sums(rows.size());
  std::vector<Rgb> part(rows.size());
  SliceSums report;
  ThreadStopwatch cpu;
  for (std::size_t first = 0; first < lights.size(); first += kBruteForceColumns) {
    std::vector<Column> columns;
    for (const LightId j : lights.subspan(first, std::min<std::size_t>(kBruteForceColumns, lights.size() - first)))
      columns.push_back({.light = j});
    SliceVisibility source(frame.world, frame.receivers, rows, frame.lights, columns, /*cull=*/true);
    BitMatrix visible(rows.size(), columns.size());
    report.entries += trace_all(source, visible).entries;
    report.rays += source.rays();
    report.memory_bytes = source.memory_bytes() + visible.n_words() * sizeof(std::uint64_t);
    report.visibility_s += cpu.lap();

    shade_slice(frame.world, frame.receivers, rows, frame.lights, columns, visible,
                {.clamp_distance = params.cut.clamp_distance}, part);
    for (std::size_t r = 0; r < rows.size(); ++r)
      sums[r].r += static_cast<double>(part[r].r), sums[r].g += static_cast<double>(part[r].g),
          sums[r].b += static_cast<double>(part[r].b);
    report.shade_s += cpu.lap();
  }
  for (std::size_t r = 0; r < rows.size(); ++r)
    radiance[r] = {static_cast<float>(sums[r].r), static_cast<float>(sums[r].g), static_cast<float>(sums[r].b)};
  return report;
}

}  // namespace
}  // namespace myrialux
