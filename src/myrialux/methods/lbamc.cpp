// Slices, slice lightcut, localized completion: doubtful blocks of 16 rows are traced in coherent packets, the others
// copied from the column most alike. Ours: docs/methods/lbamc.md.
#include "myrialux/methods/slice_driver.h"

namespace myrialux {

MethodResult render_lbamc(const FrameView& frame, const MethodParams& params, Progress& progress, RenderStats& stats) {
  const auto complete = [&](EntrySource& source, Rng& rng, BitMatrix& visible) {
    return complete_localized(source, params.lbamc, rng, visible);
  };
  return render_slices(frame, params, {.complete = complete, .block_energies = true}, progress, stats);
}

}  // namespace myrialux
