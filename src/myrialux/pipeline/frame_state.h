// What grows over the passes of one frame: pixel sums and the layers that explain them.
#pragma once

#include <vector>

#include "myrialux/film/film.h"
#include "myrialux/methods/render.h"

namespace myrialux {

/// Sums over passes, in double. Layers other than the beauty are plain means over a pixel's samples.
class FrameState {
 public:
  FrameState(int width, int height, const Filter& filter);

  /// @param radiance [n_samples] finished camera samples of one pass
  void add_pass(const CameraSamples& samples, const Receivers& receivers, std::span<const Rgb> radiance,
                const MethodResult& method);

  /// @param aovs names among albedo normal depth slice cut visibility; empty: all that are known
  Picture picture(const std::vector<std::string>& aovs) const;

 private:
  struct PixelSums {
    double albedo[3] = {}, normal[3] = {}, depth = 0, cut = 0, visibility = 0;
    std::uint32_t n_samples = 0, n_hits = 0, n_receivers = 0;
    float slice = -1;  ///< of the pixel's first receiver in the first pass
  };
  int width_, height_;
  Filter filter_;
  std::vector<double> sum_rgb_, weight_;
  std::vector<PixelSums> pixels_;
  bool has_slices_ = false;
};

}  // namespace myrialux
