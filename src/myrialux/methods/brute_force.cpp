// Every receiver, every virtual light, every ray: what all other methods approximate for the same lights.
#include "myrialux/reference/brute_force.h"

#include "myrialux/base/clock.h"
#include "myrialux/methods/render.h"

namespace myrialux {

MethodResult render_brute_force(const FrameView& frame, const MethodParams& params, Progress& progress,
                                RenderStats& stats) {
  MethodResult result;
  result.radiance.resize(frame.receivers.size());
  Stopwatch wall;
  const BruteForceCounters counters =
      brute_force(frame.world, frame.receivers, frame.lights, params.cut.clamp_distance, result.radiance, progress);
  stats.time_s["visibility"] += wall.lap();
  stats.visibility.entries += counters.entries;
  stats.visibility.traced += counters.traced;
  stats.rays.shadow += counters.traced;
  return result;
}

Method prepare_brute_force(const World&, const VirtualLights&, float, const MethodParams&, Progress&, RenderStats&) {
  return render_brute_force;
}

}  // namespace myrialux
