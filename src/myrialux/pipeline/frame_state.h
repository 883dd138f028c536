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

  /// What the camera samples met first. Those of one pass may come in parts, by rows of pixels, from the top down.
  void add_first_hits(const CameraSamples& samples);
  /// @param radiance [samples.size()] finished camera samples; in parts as above
  void add_radiance(const CameraSamples& samples, std::span<const Rgb> radiance);
  /// Slices, cuts, visibility and its error of one pass. @param spp camera samples a pixel
  void add_slices(const Receivers& receivers, const MethodResult& method, int spp);

  /// @param aovs names among albedo normal depth slice cut visibility error; empty: all that are known
  Picture picture(const std::vector<std::string>& aovs) const;
  /// Channels of that picture. @param has_slices whether add_slices() is called; @param has_errors with errors
  static std::size_t n_channels(const std::vector<std::string>& aovs, bool has_slices, bool has_errors);
  /// Memory of the sums, for each pixel.
  static std::size_t bytes_a_pixel() { return sizeof(PixelSums) + 4 * sizeof(double); }

 private:
  struct PixelSums {
    double albedo[3] = {}, normal[3] = {}, depth = 0, cut = 0, visibility = 0, error = 0;
    std::uint32_t n_samples = 0, n_hits = 0, n_receivers = 0;
    float slice = -1;  ///< of the pixel's first receiver in the first pass
  };
  int width_, height_;
  Filter filter_;
  std::vector<double> sum_rgb_, weight_;
  std::vector<PixelSums> pixels_;
  bool has_slices_ = false, has_errors_ = false;
};

}  // namespace myrialux
