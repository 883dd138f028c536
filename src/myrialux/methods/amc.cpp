// Slices, slice lightcut, adaptive matrix completion by projection. [wang20, 3.2, algorithm 1]
// Deviations from the paper: docs/methods/amc.md.
#include "myrialux/methods/slice_driver.h"

namespace myrialux {

MethodResult render_amc(const FrameView& frame, const MethodParams& params, Progress& progress, RenderStats& stats) {
  const auto complete = [&](EntrySource& source, Rng& rng, BitMatrix& visible) {
    return complete_amc(source, params.amc, rng, visible);
  };
  return render_slices(frame, params, {complete, params.amc_cull, params.amc_guard}, progress, stats);
}

}  // namespace myrialux
