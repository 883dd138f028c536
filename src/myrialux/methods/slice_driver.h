// What all slice methods share: slices, light tree, a cut a slice, some way to all bits of the slice, shading.
#pragma once

#include <functional>

#include "myrialux/methods/render.h"
#include "myrialux/visibility/slice_visibility.h"

namespace myrialux {

/// From a slice's entry source to all its bits: the stage in which slice methods differ. `visible` is all 0 at entry.
using CompleteSlice = std::function<CompletionStats(EntrySource& source, Rng& rng, BitMatrix& visible)>;

/// The pilot (see SliceMethod::guard): one slice of this many at most, and about so many slices of large frames. They
/// are held together until the other slices begin.
inline constexpr std::size_t kPilotStride = 64, kPilotSlices = 32;
/// Frames with fewer slices have no pilot.
inline constexpr std::size_t kLeastSlices = 8;
/// One slice of how many is the pilot's.
std::size_t pilot_stride(std::size_t n_slices);

/// Lights that brute-force joins with a slice at a time.
inline constexpr std::uint32_t kBruteForceColumns = 1024;

/// The frame once its rows and columns are grouped. Holds references.
struct SliceFrame {
  const FrameView& frame;
  const MethodParams& params;
  const Slices& slices;
  const LightTree& tree;
};
/// The columns of a slice, ordered as light_cut() orders them; called by many threads, and the same each time.
using ChooseColumns = std::function<std::vector<Column>(std::size_t s)>;

struct SliceMethod {
  CompleteSlice complete = {};
  bool cull = true;  ///< entries whose transfer is zero are left out
  /// Entries that may carry more than this many times the frame's mean radiance are always traced. The mean comes from
  /// a pilot: one slice of 64 is traced whole first, and completed besides to count wrong bits. 0: no pilot.
  float guard = 0;
  /// Prepares the choice of columns, once a frame. Empty: light_cut().
  std::function<ChooseColumns(const SliceFrame&)> columns = {};
  bool energies = false;  ///< the source tells what columns may bring
  /// In place of `complete`, where set: completion with about `slack` times the error that it has with 1, which says
  /// how sure it is of its blocks, too (not where null). The source tells what blocks may bring, and the pilot finds
  /// the slack with which its own slices stay within `largest_error`. Slices are then checked by random rays, and
  /// completed again with less slack where too much was wrong. Frames of few slices have no pilot: all is traced.
  std::function<CompletionStats(EntrySource& source, Rng& rng, BitMatrix& visible, float slack, BlockDoubts* doubts)>
      complete_within = {};
  /// Of complete_within: root mean square over pixels, over the mean radiance; 0: all is traced.
  float largest_error = 0;
};

/// Streams the slices: each is cut, traced, completed, shaded and forgotten, so memory does not grow with the frame
/// (but for the bits of the pilot's slices).
MethodResult render_slices(const FrameView& frame, const MethodParams& params, const SliceMethod& method,
                           Progress& progress, RenderStats& stats);

}  // namespace myrialux
