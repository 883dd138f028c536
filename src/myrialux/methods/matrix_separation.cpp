// Slices, slice lightcut, visibility guessed from samples and split into low rank and sparse. [huo15]
// Deviations from the paper: docs/methods/matrix-separation.md.
#include "myrialux/methods/slice_driver.h"

namespace myrialux {

MethodResult render_matrix_separation(const FrameView& frame, const MethodParams& params, Progress& progress,
                                      RenderStats& stats) {
  const auto complete = [&](EntrySource& source, Rng& rng, BitMatrix& visible) {
    return complete_separation(source, params.separation, rng, visible);
  };
  return render_slices(
      frame, params,
      {.complete = complete, .cull = params.separation_cull, .guard = params.separation_guard, .energies = true},
      progress, stats);
}

}  // namespace myrialux
