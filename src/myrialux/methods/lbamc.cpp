// Slices, slice lightcut, localized completion: doubtful blocks of 16 rows are traced in coherent packets, the others
// copied from the column most alike. Ours: docs/methods/lbamc.md.
#include "myrialux/methods/slice_driver.h"

namespace myrialux {

MethodResult render_lbamc(const FrameView& frame, const MethodParams& params, Progress& progress, RenderStats& stats) {
  const auto complete = [&](EntrySource& source, Rng& rng, BitMatrix& visible, float slack, BlockDoubts* doubts) {
    return complete_localized(source, with_slack(params.lbamc, slack), rng, visible, doubts);
  };
  return render_slices(frame, params, {.complete_within = complete, .largest_error = params.visibility_error}, progress,
                       stats);
}

}  // namespace myrialux
