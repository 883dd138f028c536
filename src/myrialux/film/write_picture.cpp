// Encodes a picture in memory by OpenImageIO, band by band, then puts the bytes on disk whole or not at all.
#include <OpenEXR/ImfThreading.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <functional>

#include "myrialux/base/assert.h"
#include "myrialux/base/error.h"
#include "myrialux/base/output_file.h"
#include "myrialux/base/parallel.h"
#include "myrialux/base/process.h"
#include "myrialux/base/suggest.h"
#include "myrialux/film/film.h"
#include "myrialux/math/srgb.h"

namespace myrialux {
namespace {

using Bytes = std::vector<unsigned char>;

void require_finite(const Picture& picture, const std::string& path);
std::vector<std::string> channel_names(const Picture& picture);
/// Rows [y_begin, y_end) of the layers' channels side by side.
void interleave(const std::vector<const Picture::Layer*>& layers, int width, int y_begin, int y_end,
                std::vector<float>& pixels);
/// sRGB bytes of the beauty, 3 a pixel.
std::vector<std::uint8_t> tone_map(const Picture& picture, const Picture::Layer& beauty, float exposure);
/// The pixels of rows [y_begin, y_end), as the spec says; they need to last until the next call.
using Rows = std::function<const void*(int y_begin, int y_end)>;
Bytes encode(const std::string& path, const std::string& extension, const OIIO::ImageSpec& spec, const Rows& rows);

/// A block of ZIP: rows that are compressed together.
constexpr int kZipRows = 16;
/// Rows of a band: each thread compresses some blocks of it.
int band_rows(int n_threads) { return 4 * kZipRows * n_threads; }

/// OpenEXR's own threads while one file is written; none when they would be one. Gone with the object, since they may
/// hang at exit; OpenImageIO, told to leave them alone ("exr_threads"), does not start them anew.
class ExrThreads {
 public:
  explicit ExrThreads(int n) { Imf::setGlobalThreadCount(n > 1 ? n : 0); }
  ~ExrThreads() { Imf::setGlobalThreadCount(0); }
  ExrThreads(const ExrThreads&) = delete;
  ExrThreads& operator=(const ExrThreads&) = delete;
};

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
  const auto save = [&](const Rows& rows) {
    const Bytes bytes = encode(path, extension, spec, rows);
    write_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  };
  std::vector<const Picture::Layer*> layers;
  std::vector<float> band;
  const auto save_layers = [&] {
    save([&](int y_begin, int y_end) {
      interleave(layers, picture.width, y_begin, y_end, band);
      return band.data();
    });
  };
  if (extension == ".exr") {
    for (const Picture::Layer& layer : picture.layers) layers.push_back(&layer);
    spec.channelnames = channel_names(picture);
    spec.nchannels = static_cast<int>(spec.channelnames.size());
    spec.attribute("compression", "zip");
    // Without a date of its own OpenImageIO adds the hour of writing; one of the wrong type is dropped instead, and the
    // same picture gives the same bytes.
    spec.attribute("DateTime", 0);
    spec.attribute("oiio:ColorSpace", "Linear");
    const float rec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), rec709);
    for (const auto& [key, value] : metadata) spec.attribute(key, value);
    save_layers();
  } else if (extension == ".hdr") {
    layers = {&beauty_of(picture, path)};
    save_layers();
  } else {
    const std::vector<std::uint8_t> bytes = tone_map(picture, beauty_of(picture, path), exposure);
    spec.set_format(OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    if (extension != ".png") spec.attribute("Compression", "jpeg:95");
    save([&](int y_begin, int) { return bytes.data() + static_cast<std::size_t>(y_begin) * spec.scanline_bytes(); });
  }
}

std::uint64_t picture_write_bytes(int width, int height, std::size_t n_channels, int n_threads) {
  // The file, never larger than its pixels but for the header; a band, OpenEXR's blocks of it (2 a thread) and their
  // compressed forms.
  const std::uint64_t row = static_cast<std::uint64_t>(width) * std::max<std::size_t>(3, n_channels) * sizeof(float);
  const std::uint64_t band = static_cast<std::uint64_t>(band_rows(n_threads));
  return row * static_cast<std::uint64_t>(height) + row * (std::min(band, static_cast<std::uint64_t>(height)) +
                                                           4 * kZipRows * static_cast<std::uint64_t>(n_threads));
}

namespace {

void require_finite(const Picture& picture, const std::string& path) {
  constexpr std::size_t kBlock = 1 << 16;
  for (const Picture::Layer& layer : picture.layers) {
    const std::size_t n_values = layer.pixels.size();
    std::vector<std::size_t> bad((n_values + kBlock - 1) / kBlock, n_values);  // the first of each block
    parallel_for(bad.size(), [&](std::size_t b) {
      const auto begin = layer.pixels.begin() + static_cast<std::ptrdiff_t>(b * kBlock);
      const auto end = layer.pixels.begin() + static_cast<std::ptrdiff_t>(std::min(n_values, (b + 1) * kBlock));
      const auto found = std::find_if(begin, end, [](float x) { return !std::isfinite(x); });
      if (found != end) bad[b] = static_cast<std::size_t>(found - layer.pixels.begin());
    });
    const auto first = std::find_if(bad.begin(), bad.end(), [&](std::size_t k) { return k < n_values; });
    if (first == bad.end()) continue;
    const std::size_t k = *first;
    const std::size_t n = layer.channels.size(), pixel = k / n, width = static_cast<std::size_t>(picture.width);
    throw Error(ErrorKind::input,
                fmt::format("{}: pixel {},{} of layer '{}' has {} in channel {}: not a finite number, so the picture "
                            "is not written; look for NaN or huge values in the scene's textures and emitters",
                            path, pixel % width, pixel / width, layer.name.empty() ? "RGB" : layer.name,
                            layer.pixels[k], layer.channels[k % n]));
  }
}

std::vector<std::string> channel_names(const Picture& picture) {
  std::vector<std::string> names;
  for (const Picture::Layer& layer : picture.layers)
    for (const std::string& c : layer.channels) names.push_back(layer.name.empty() ? c : layer.name + "." + c);
  return names;
}

void interleave(const std::vector<const Picture::Layer*>& layers, int width, int y_begin, int y_end,
                std::vector<float>& pixels) {
  const auto at = [&](int y) { return static_cast<std::size_t>(y) * static_cast<std::size_t>(width); };
  const std::size_t begin = at(y_begin), n_pixels = at(y_end) - begin;
  std::size_t n = 0, first = 0;
  for (const Picture::Layer* layer : layers) n += layer->channels.size();
  pixels.resize(n * n_pixels);
  for (const Picture::Layer* layer : layers) {
    const std::size_t m = layer->channels.size();
    MYRIALUX_ASSERT(layer->pixels.size() >= m * (begin + n_pixels));
    parallel_for(
        n_pixels,
        [&](std::size_t i) { std::copy_n(layer->pixels.data() + m * (begin + i), m, pixels.data() + n * i + first); },
        4096);
    first += m;
  }
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

Bytes encode(const std::string& path, const std::string& extension, const OIIO::ImageSpec& spec, const Rows& rows) {
  OIIO::attribute("exr_threads", -1);  // OpenImageIO starts none
  OIIO::attribute("debug", 0);         // some builds print warnings by default
  const int n_threads = allowed_threads();
  const ExrThreads threads(extension == ".exr" ? n_threads : 1);
  const auto output = OIIO::ImageOutput::create(extension.substr(1));
  if (!output) refuse(path, OIIO::geterror());
  MYRIALUX_ASSERT(output->supports("ioproxy"));
  // Room for all, so that the bytes never stand there twice while they grow; pages not written to cost nothing.
  Bytes bytes;
  bytes.reserve(spec.image_bytes() + (1 << 16));
  OIIO::Filesystem::IOVecOutput memory(bytes);
  void* proxy = &memory;
  OIIO::ImageSpec with_memory = spec;
  with_memory.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  output->threads(1);
  if (!output->open("memory" + extension, with_memory)) refuse(path, output->geterror());
  for (int y = 0; y < spec.height; y += band_rows(n_threads)) {
    const int end = std::min(spec.height, y + band_rows(n_threads));
    if (!output->write_scanlines(y, end, 0, spec.format, rows(y, end))) refuse(path, output->geterror());
  }
  if (!output->close()) refuse(path, output->geterror());
  return bytes;
}

}  // namespace
}  // namespace myrialux
