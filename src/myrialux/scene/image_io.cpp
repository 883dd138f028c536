// Reads image files by OpenImageIO into linear or sRGB-coded pixels.
#include "myrialux/scene/image_io.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <filesystem>

#include "myrialux/math/srgb.h"

namespace myrialux {

namespace {

constexpr std::int64_t kMaxPixels = std::int64_t{1} << 28;

/// Channels to read: 1, 3 or 4 of the file's.
int kept_channels(int n) { return n >= 4 ? 4 : n == 3 ? 3 : 1; }

}  // namespace

std::optional<Image> read_image(const std::string& path, bool raw, float gamma, std::string& what) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return what = "does not exist", std::nullopt;
  OIIO::attribute("exr_threads", -1);  // else one a processor, kept to the end of the process
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);  // colours are not multiplied by alpha
  const auto input = OIIO::ImageInput::open(path, &config);
  if (!input) {
    what = "cannot be read: " + OIIO::geterror();
    while (what.ends_with('\n')) what.pop_back();
    return {};
  }
  input->threads(1);  // images are read in parallel already
  const OIIO::ImageSpec& spec = input->spec();
  const std::int64_t n_pixels = std::int64_t{spec.width} * spec.height;
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || n_pixels > kMaxPixels)
    return what = "is not a flat image of at most 2^28 pixels", std::nullopt;
  Image image;
  image.width = spec.width, image.height = spec.height, image.channels = kept_channels(spec.nchannels);
  const std::size_t n = static_cast<std::size_t>(n_pixels) * image.channels;
  const bool is_byte = spec.format == OIIO::TypeDesc::UINT8;
  const bool is_integer = !spec.format.is_floating_point();
  const bool is_curved = is_integer && !raw && gamma <= 0;
  bool is_good = false;
  if (is_byte && (raw || gamma <= 0)) {
    image.bytes.resize(n);
    image.srgb = is_curved;
    is_good = input->read_image(0, 0, 0, image.channels, OIIO::TypeDesc::UINT8, image.bytes.data());
  } else {
    image.floats.resize(n);
    is_good = input->read_image(0, 0, 0, image.channels, OIIO::TypeDesc::FLOAT, image.floats.data());
    if (is_curved || (!raw && gamma > 0))
      for (std::size_t i = 0; i < n; ++i) {
        if (image.channels == 4 && i % 4 == 3) continue;
        image.floats[i] = is_curved ? decode_srgb(image.floats[i]) : std::pow(image.floats[i], gamma);
      }
  }
  if (!is_good) {
    what = "cannot be read: " + input->geterror();
    while (what.ends_with('\n')) what.pop_back();
    return {};
  }
  for (const float v : image.floats)
    if (!std::isfinite(v)) return what = "holds values that are not finite", std::nullopt;
  return image;
}

}  // namespace myrialux
