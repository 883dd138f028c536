// How much memory a frame takes at most, stage by stage, and which smaller settings would fit a limit.
#pragma once

#include <cstdint>
#include <string>

namespace myrialux {

/// What the memory of a frame depends on. Bytes are those beside what is held before the frame begins.
struct FrameExtent {
  bool has_lights = true, has_slices = true;  ///< mdlc has no slices, path neither
  bool has_cuts = true;                       ///< --clusters limits columns; brute-force takes all
  bool has_pixel_cuts = false;                ///< a cut a pixel, over trees of its receivers and of all lights (mdlc)
  std::uint64_t band_samples = 0;             ///< held at once, or a row of pixels if that has more; 0: all
  int band_rows = 0;                          ///< the same in rows of pixels, if not 0
  std::uint32_t completion_bytes = 0;         ///< working space of the completion for each entry of a slice
  bool has_point_tree = false;                ///< of all receivers; then slices are small blocks of them
  bool has_pilot = false;                     ///< some slices' bits are kept (SliceMethod::guard)
  bool has_errors = false;                    ///< of visibility, estimated slice by slice
  bool has_packets = false;                   ///< a cut a receiver in place of one a slice (lightcuts)
  int width = 0, height = 0, spp = 1, passes = 1;
  std::uint64_t n_lights = 0, n_glossy = 0;  ///< virtual lights of a pass, and how many of them are glossy
  std::uint64_t lights_file_bytes = 0;       ///< 0: they are traced
  std::uint32_t n_clusters = 0, slice_rows = 0;
  bool has_auto_clusters = false;                          ///< n_clusters is the most that may be chosen
  std::uint32_t reduced_rows = 0, reduced_dimensions = 0;  ///< of the reduced matrix (lightslice); 0: none
  std::size_t n_channels = 0;                              ///< of the picture
  int n_threads = 1;
};

/// The largest sum of what lives at the same time, an allowance for libraries and the allocator included.
std::uint64_t frame_bytes(const FrameExtent& frame);

/// Camera samples of a band of rows, where a method takes these one by one; fewer where memory is short.
inline constexpr std::uint64_t kBandSamples = 1 << 19, kSmallBandSamples = 1 << 16;
/// Rows of pixels whose receivers are held at once.
int rows_at_once(const FrameExtent& frame);

/// Rows of pixels that the path tracer holds at once.
int path_rows_at_once(const FrameExtent& frame);

/// @param held_bytes by the process before the frame; @param peak_bytes it has held at most so far
/// @throws Error (limit) if the frame would take the process above limit_bytes: how much is needed, and for what;
/// which smaller settings fit
void require_memory(const FrameExtent& frame, std::uint64_t held_bytes, std::uint64_t peak_bytes,
                    std::uint64_t limit_bytes);

}  // namespace myrialux
