// Slices, slice lightcut, adaptive matrix completion by elimination over GF(2). [wang20, 5.6]
// Deviations from the paper: docs/methods/gauss-jordan.md.
#include "myrialux/completion/gauss_jordan.h"
#include "myrialux/methods/slice_driver.h"

namespace myrialux {

MethodResult render_gauss_jordan(const FrameView& frame, const MethodParams& params, Progress& progress,
                                 RenderStats& stats) {
  const auto complete = [&](EntrySource& source, Rng& rng, BitMatrix& visible) {
    return complete_gauss_jordan(source, params.gauss_jordan, rng, visible);
  };
  return render_slices(frame, params, {complete, params.gauss_jordan_cull, params.gauss_jordan_guard}, progress, stats);
}

}  // namespace myrialux
