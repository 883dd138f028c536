// The slices and cuts of bamc with every active entry traced in coherent packets: its honest baseline. [wang20, 5.3.4]
#include "myrialux/methods/slice_driver.h"

namespace myrialux {

MethodResult render_slice_lightcuts(const FrameView& frame, const MethodParams& params, Progress& progress,
                                    RenderStats& stats) {
  const auto complete = [](EntrySource& source, Rng&, BitMatrix& visible) { return trace_all(source, visible); };
  return render_slices(frame, params, {complete}, progress, stats);
}

}  // namespace myrialux
