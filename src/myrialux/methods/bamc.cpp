// Slices, slice lightcut, boolean adaptive matrix completion. [wang20, 4]
// Deviations from the paper: docs/methods/bamc.md.
#include "myrialux/methods/slice_driver.h"

namespace myrialux {

MethodResult render_bamc(const FrameView& frame, const MethodParams& params, Progress& progress, RenderStats& stats) {
  const auto complete = [&](SliceVisibility& source, Rng& rng, BitMatrix& visible) {
    return complete_bamc(source, params.bamc, rng, visible);
  };
  return render_slices(frame, params, params.bamc_cull, complete, progress, stats);
}

}  // namespace myrialux
