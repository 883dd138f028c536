// From camera samples to pixels, and from pixels to files.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "myrialux/math/filter.h"
#include "myrialux/math/vec.h"

namespace myrialux {

/// A picture of named float layers, all of one size. Layer "" is the beauty (R G B); others as in docs/formats.md.
struct Picture {
  int width = 0, height = 0;
  struct Layer {
    std::string name;                   ///< "", "albedo", "normal", "depth", ...
    std::vector<std::string> channels;  ///< {"R","G","B"}, {"X","Y","Z"}, {"Z"}, {"id"}, ...
    std::vector<float> pixels;          ///< [height * width * channels.size()], row by row from the top
  };
  std::vector<Layer> layers;
  std::size_t n_channels() const;  ///< of all layers
  /// A new layer of zeros, of the picture's size; the name must be new. The reference holds until the next call.
  Layer& add_layer(const std::string& name, std::vector<std::string> channels);
  const Layer* find(const std::string& name) const;
};

/// Weighs samples into pixels: pixel = sum f(x) L / sum f(x) over samples within the filter's radius, in fixed order.
/// `position` in pixels from the top left, sorted by pixel: sample k of pixel i is i * spp + k. Parallel,
/// deterministic.
/// @param values [n_samples]; adds sums and weights to `sum` [3 * pixels] and `weight` [pixels] in double, so that
/// passes add up. Samples may be those of some rows of pixels from `first_row` on; rows given in rising order add up to
/// the same bits as all at once.
void accumulate(std::span<const Vec2> position, std::span<const Rgb> values, int width, int height, int spp,
                const Filter& filter, std::vector<double>& sum_rgb, std::vector<double>& weight, int first_row = 0);

/// Parameters kept in an EXR header, as text.
using Metadata = std::map<std::string, std::string>;

/// Extensions that write_picture knows, with the dot: .exr .png .jpg .jpeg .hdr
const std::vector<std::string>& picture_extensions();
/// The extension of `path` in small letters. @throws Error (usage) listing the known ones, if it is none of them
std::string picture_extension(const std::string& path);

/// Writes by extension (.exr all layers, float32, ZIP; .hdr the beauty; .png .jpg the beauty with sRGB curve and
/// `exposure` in stops). Written beside the target and renamed: a half picture never stands under the final name.
/// Layers of an EXR stand in the file's alphabetical order. Metadata goes to EXR only.
/// @throws Error (output); (usage) for an unknown extension; (input) if a pixel is not finite, naming it.
/// Uses as many threads as parallel loops may, for the same bytes. Memory: at most picture_write_bytes().
void write_picture(const Picture& picture, const std::string& path, const Metadata& metadata, float exposure = 0);

/// Memory that write_picture takes at most for one file of any format, besides the picture.
std::uint64_t picture_write_bytes(int width, int height, std::size_t n_channels, int n_threads);

/// Reads EXR, HDR, PNG, ... as layers ("albedo.R" is channel R of layer "albedo"; R G B without a dot are layer "").
/// Pictures of 8 or 16 bits come back linear (their sRGB curve undone).
/// @param metadata if not null, gets the header's text attributes
/// @throws Error (input)
Picture read_picture(const std::string& path, Metadata* metadata = nullptr);

}  // namespace myrialux
