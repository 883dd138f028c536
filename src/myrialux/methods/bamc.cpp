// Slices, slice lightcut, boolean adaptive matrix completion. [wang20, 4]
// Deviations from the paper: docs/methods/bamc.md.
#include "myrialux/methods/slice_driver.h"

namespace myrialux {

MethodResult render_bamc(const FrameView& frame, const MethodParams& params, Progress& progress, RenderStats& stats) {
  const auto complete = [&](EntrySource& source, Rng& rng, BitMatrix& visible) {
    return complete_bamc(source, params.bamc, rng, visible);
  };
  return render_slices(frame, params, {complete, params.bamc_cull, params.bamc_guard}, progress, stats);
}

}  // namespace myrialux
