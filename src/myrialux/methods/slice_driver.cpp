// Groups rows and columns, then hands the slices to the loop over them.
#include "myrialux/methods/slice_driver.h"

#include <fmt/format.h>

#include <utility>

#include "myrialux/base/clock.h"
#include "myrialux/methods/auto_clusters.h"
#include "myrialux/methods/slice_loop.h"

namespace myrialux {
namespace {

/// Lightcuts' choice: each slice refines the tree where its own bounds are largest.
ChooseColumns by_light_cut(const SliceFrame& f) {
  return [f](std::size_t s) {
    return light_cut(f.frame.world, f.frame.receivers, f.slices.rows(s), f.frame.lights, f.tree, f.params.cut);
  };
}

/// What the meter of this pass says, for people.
std::string meter_words(const RenderStats::Visibility::Meter& m) {
  const MeterErrors e = meter_errors(m);
  return fmt::format("visibility: error by copied bits {}, {:.2f} % of the bits wrong{}", error_words(e), 100 * e.wrong,
                     m.redone_slices > 0 ? fmt::format(", {} of {} slices redone", m.redone_slices, m.slices) : "");
}

}  // namespace

MethodResult render_slices(const FrameView& frame, const MethodParams& params, const SliceMethod& method,
                           Progress& progress, RenderStats& stats) {
  // Rows and columns are grouped first: both depend only on where things are, not on who sees whom.
  Stopwatch wall;
  const ProcessStopwatch cpu;
  progress.stage("clusters", 0, "");
  const Slices slices = make_slices(frame.receivers, frame.scene_radius, params.slices);
  const LightTree tree = build_light_tree(frame.world, frame.lights, frame.scene_radius, params.tree);
  stats.time_s["cluster"] += wall.lap(), stats.cpu_s["group"] += cpu.elapsed();

  // Which lights stand for all, slice by slice; methods may look at the whole frame first.
  const MethodParams chosen = with_chosen_clusters(frame, params, slices, tree, progress, stats);
  const SliceFrame grouped{frame, chosen, slices, tree};
  SliceLoop loop(frame, chosen, method, slices, tree, method.columns ? method.columns(grouped) : by_light_cut(grouped));
  wall.lap();
  progress.stage("slices", slices.size(), "slices");
  if (method.guard > 0 || method.largest_error > 0) loop.run_pilot(progress);
  loop.run(progress);
  RenderStats::Visibility::Meter meter;
  loop.finish(wall.lap(), stats, meter);
  if (meter.rays > 0) progress.note(meter_words(meter));
  return std::move(loop.result);
}

}  // namespace myrialux
