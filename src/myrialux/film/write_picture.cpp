// Encodes a picture in memory by OpenImageIO, then puts the bytes on disk whole or not at all.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "myrialux/base/assert.h"
#include "myrialux/base/error.h"
#include "myrialux/base/output_file.h"
#include "myrialux/base/parallel.h"
#include "myrialux/base/suggest.h"
#include "myrialux/film/film.h"
#include "myrialux/math/srgb.h"

namespace myrialux {
namespace {

using Bytes = std::vector<unsigned char>;

void require_finite(const Picture& picture, const std::string& path);
/// All layers as one array of interleaved channels, and the channels' names.
struct Interleaved {
  std::vector<std::string> names;
  std::vector<float> pixels;
};
Interleaved interleave(const Picture& picture);
/// sRGB bytes of the beauty, 3 a pixel.
std::vector<std::uint8_t> tone_map(const Picture& picture, const Picture::Layer& beauty, float exposure);
Bytes encode(const std::string& path, const std::string& extension, const OIIO::ImageSpec& spec, const void* pixels);

const Picture::Layer& beauty_of(const Picture& picture, const std::string& path) {
  const Picture::Layer* beauty = picture.find("");
  if (beauty && beauty->channels.size() >= 3) return *beauty;
  throw Error(ErrorKind::input, path + ": the picture has no R G B to write; write its layers as .exr");
}

}  // namespace

const std::vector<std::string>& picture_extensions() {
  static const std::vector<std::string> known = {".exr", ".png", ".jpg", ".jpeg", ".hdr"};
  return known;
}

std::string picture_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const std::vector<std::string>& known = picture_extensions();
  if (std::find(known.begin(), known.end(), extension) != known.end()) return extension;
  throw Error(ErrorKind::usage,
              fmt::format("{}: {}; the extension chooses the format: {}", path,
                          extension.empty() ? "no extension" : "unknown picture format '" + extension + "'",
                          fmt::join(known, " ")));
}

void write_picture(const Picture& picture, const std::string& path, const Metadata& metadata, float exposure) {
  const std::string extension = picture_extension(path);
  require_writable(path);
  require_finite(picture, path);
  OIIO::ImageSpec spec(picture.width, picture.height, 3, OIIO::TypeDesc::FLOAT);
  const auto save = [&](const void* pixels) {
    const Bytes bytes = encode(path, extension, spec, pixels);
    write_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  };
  if (extension == ".exr") {
    const Interleaved all = interleave(picture);
    spec.nchannels = static_cast<int>(all.names.size());
    spec.channelnames = all.names;
    spec.attribute("compression", "zip");
    // Without a date of its own OpenImageIO adds the hour of writing; one of the wrong type is dropped instead, and the
    // same picture gives the same bytes.
    spec.attribute("DateTime", 0);
    spec.attribute("oiio:ColorSpace", "Linear");
    const float rec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), rec709);
    for (const auto& [key, value] : metadata) spec.attribute(key, value);
    save(all.pixels.data());
  } else if (extension == ".hdr") {
    Picture only{picture.width, picture.height, {beauty_of(picture, path)}};
    save(interleave(only).pixels.data());
  } else {
    const std::vector<std::uint8_t> bytes = tone_map(picture, beauty_of(picture, path), exposure);
    spec.set_format(OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    if (extension != ".png") spec.attribute("Compression", "jpeg:95");
    save(bytes.data());
  }
}

namespace {

void require_finite(const Picture& picture, const std::string& path) {
  for (const Picture::Layer& layer : picture.layers)
    for (std::size_t k = 0; k < layer.pixels.size(); ++k) {
      if (std::isfinite(layer.pixels[k])) continue;
      const std::size_t n = layer.channels.size(), pixel = k / n, width = static_cast<std::size_t>(picture.width);
      throw Error(ErrorKind::input,
                  fmt::format("{}: pixel {},{} of layer '{}' has {} in channel {}: not a finite number, so the picture "
                              "is not written; look for NaN or huge values in the scene's textures and emitters",
                              path, pixel % width, pixel / width, layer.name.empty() ? "RGB" : layer.name,
                              layer.pixels[k], layer.channels[k % n]));
    }
}

Interleaved interleave(const Picture& picture) {
  Interleaved all;
  for (const Picture::Layer& layer : picture.layers)
    for (const std::string& c : layer.channels) all.names.push_back(layer.name.empty() ? c : layer.name + "." + c);
  const std::size_t n = all.names.size();
  const std::size_t n_pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  all.pixels.resize(n * n_pixels);
  std::size_t first = 0;
  for (const Picture::Layer& layer : picture.layers) {
    const std::size_t m = layer.channels.size();
    MYRIALUX_ASSERT(layer.pixels.size() == m * n_pixels);
    for (std::size_t i = 0; i < n_pixels; ++i)
      std::copy_n(layer.pixels.data() + m * i, m, all.pixels.data() + n * i + first);
    first += m;
  }
  return all;
}

std::vector<std::uint8_t> tone_map(const Picture& picture, const Picture::Layer& beauty, float exposure) {
  const std::size_t n_pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  const std::size_t n = beauty.channels.size();
  const float factor = std::exp2(exposure);
  std::vector<std::uint8_t> bytes(3 * n_pixels);
  parallel_for(
      n_pixels,
      [&](std::size_t i) {
        for (std::size_t c = 0; c < 3; ++c) {
          const float linear = std::clamp(beauty.pixels[n * i + c] * factor, 0.0f, 1.0f);
          bytes[3 * i + c] = static_cast<std::uint8_t>(std::lround(255 * encode_srgb(linear)));
        }
      },
      4096);
  return bytes;
}

[[noreturn]] void refuse(const std::string& path, std::string reason) {
  while (reason.ends_with('\n')) reason.pop_back();
  throw Error(ErrorKind::output, path + ": cannot be encoded: " + reason);
}

Bytes encode(const std::string& path, const std::string& extension, const OIIO::ImageSpec& spec, const void* pixels) {
  // OpenEXR's own threads may hang at exit; without them the calling thread compresses.
  OIIO::attribute("exr_threads", -1);
  OIIO::attribute("debug", 0);  // some builds print warnings by default
  const auto output = OIIO::ImageOutput::create(extension.substr(1));
  if (!output) refuse(path, OIIO::geterror());
  MYRIALUX_ASSERT(output->supports("ioproxy"));
  Bytes bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  void* proxy = &memory;
  OIIO::ImageSpec with_memory = spec;
  with_memory.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  output->threads(1);
  if (!output->open("memory" + extension, with_memory)) refuse(path, output->geterror());
  if (!output->write_image(spec.format, pixels)) refuse(path, output->geterror());
  if (!output->close()) refuse(path, output->geterror());
  return bytes;
}

}  // namespace
}  // namespace myrialux
