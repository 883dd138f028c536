// Traces and shades the rows of the reduced light matrix. [ou11]
#pragma once

#include "myrialux/clusters/reduced_matrix.h"
#include "myrialux/methods/render.h"

namespace myrialux {

struct ReducedRows {
  ReducedMatrix matrix;                    ///< [n_slices x n_lights of the tree], columns in LightTree::order
  std::vector<ReceiverId> representative;  ///< [n_slices], drawn uniformly from each
};

/// One receiver a slice, joined with all lights of the tree: active entries are traced in packets of the 16
/// representatives of neighbouring slices. Adds counters and times to `stats`.
ReducedRows trace_reduced_rows(const FrameView& frame, const MethodParams& params, const Slices& slices,
                               const LightTree& tree, Progress& progress, RenderStats& stats);

}  // namespace myrialux
