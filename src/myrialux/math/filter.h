// Reconstruction filters of the film, as separable functions of the distance in pixels.
#pragma once

#include <cstdint>

namespace myrialux {

struct Filter {
  enum class Kind : std::uint8_t { box, tent, gaussian, mitchell, catmullrom, lanczos };
  Kind kind = Kind::gaussian;
  float radius = 2;    ///< pixels; box 0.5, tent 1, gaussian 4 sigma, mitchell and catmullrom 2, lanczos = lobes
  float sigma = 0.5f;  ///< gaussian, pixels
  float b = 1.0f / 3, c = 1.0f / 3;  ///< mitchell
  /// Unnormalised weight; 0 at and beyond the radius. Box: 1 for -radius <= x < radius, so that every sample counts
  /// once.
  float evaluate(float x) const;
};

}  // namespace myrialux
