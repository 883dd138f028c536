// Textures: bitmaps and checkerboards over uv, evaluated as linear Rec. 709.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "myrialux/math/transform.h"
#include "myrialux/math/vec.h"

namespace myrialux {

/// Pixels of an image: 8 bits with or without sRGB curve, or float. Row 0 is the top row of the file.
struct Image {
  int width = 0, height = 0;
  int channels = 3;                 ///< 1 (grey), 3 (RGB), 4 (RGB and alpha)
  bool srgb = false;                ///< bytes carry the sRGB curve
  std::vector<std::uint8_t> bytes;  ///< [height * width * channels], or empty
  std::vector<float> floats;        ///< [height * width * channels], or empty
  /// Linear colour of a pixel; indices must be inside.
  Rgb texel(int x, int y) const;
  float alpha(int x, int y) const;  ///< 1 where there is no alpha channel
  /// Asks for a pixel's memory.
  void prefetch(int x, int y) const {
    const std::size_t at =
        (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
        static_cast<std::size_t>(channels);
    __builtin_prefetch(floats.empty() ? static_cast<const void*>(bytes.data() + at) : floats.data() + at);
  }
};

struct Texture {
  enum class Kind : std::uint8_t { bitmap, checkerboard };
  enum class Wrap : std::uint8_t { repeat, mirror, clamp };
  enum class Filter : std::uint8_t { nearest, bilinear };
  Kind kind = Kind::bitmap;
  std::string name;
  std::shared_ptr<const Image> image;
  Wrap wrap = Wrap::repeat;
  Filter filter = Filter::bilinear;
  Transform to_uv;                               ///< applied to uv first (2-D part)
  Rgb color0 = gray(0.4f), color1 = gray(0.2f);  ///< checkerboard
};

/// Colour at uv, v downwards: v = 0 is the top row of a bitmap, as in Mitsuba 3. Meshes hold such uv (OBJ is turned on
/// loading). Checkerboards: color0 where both coordinates are in the same half of the unit square.
Rgb evaluate(const Texture& texture, Vec2 uv);
/// Mean over the unit square.
Rgb average(const Texture& texture);

}  // namespace myrialux
