// What all slice methods share: slices, light tree, a cut a slice, some way to all bits of the slice, shading.
#pragma once

#include <functional>

#include "myrialux/methods/render.h"
#include "myrialux/visibility/slice_visibility.h"

namespace myrialux {

/// From a slice's entry source to all its bits: the stage in which slice methods differ. `visible` is all 0 at entry.
using CompleteSlice = std::function<CompletionStats(SliceVisibility& source, Rng& rng, BitMatrix& visible)>;

/// Streams the slices: each is cut, traced, completed, shaded and forgotten, so memory does not grow with the frame.
/// @param cull entries whose transfer is zero are left out
MethodResult render_slices(const FrameView& frame, const MethodParams& params, bool cull, const CompleteSlice& complete,
                           Progress& progress, RenderStats& stats);

}  // namespace myrialux
