// Reads a picture file by OpenImageIO and sorts its channels into layers.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <filesystem>

#include "myrialux/base/error.h"
#include "myrialux/film/film.h"
#include "myrialux/math/srgb.h"

namespace myrialux {
namespace {

[[noreturn]] void refuse(const std::string& path, std::string reason) {
  while (reason.ends_with('\n')) reason.pop_back();
  throw Error(ErrorKind::input, path + ": cannot be read: " + reason);
}

/// "albedo.R" is channel R of layer "albedo".
struct ChannelName {
  std::string layer, channel;
};
ChannelName split(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  return dot == std::string::npos ? ChannelName{"", name} : ChannelName{name.substr(0, dot), name.substr(dot + 1)};
}

/// Undoes the sRGB curve of colour channels.
void linearise(Picture::Layer& layer) {
  const std::size_t n = layer.channels.size();
  for (std::size_t k = 0; k < layer.pixels.size(); ++k)
    if (layer.channels[k % n] != "A") layer.pixels[k] = decode_srgb(layer.pixels[k]);
}

}  // namespace

Picture read_picture(const std::string& path, Metadata* metadata) {
  std::error_code none;
  if (!std::filesystem::exists(path, none)) refuse(path, "there is no such file");
  OIIO::attribute("exr_threads", -1);  // see write_picture
  OIIO::attribute("debug", 0);
  const auto input = OIIO::ImageInput::open(path);
  if (!input) refuse(path, OIIO::geterror());
  input->threads(1);
  const OIIO::ImageSpec spec = input->spec();
  if (spec.depth > 1 || spec.width < 1 || spec.height < 1) refuse(path, "it is not a flat picture");

  const std::size_t n = static_cast<std::size_t>(spec.nchannels);
  const std::size_t n_pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  std::vector<float> pixels(n * n_pixels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data()))
    refuse(path, input->geterror());

  // Which channels of the file make up which layer, in the order of the file.
  Picture picture{spec.width, spec.height, {}};
  std::vector<std::vector<std::size_t>> sources;
  for (std::size_t c = 0; c < n; ++c) {
    const ChannelName name = split(spec.channelnames[c]);
    std::size_t l = 0;
    while (l < picture.layers.size() && picture.layers[l].name != name.layer) ++l;
    if (l == picture.layers.size()) {
      picture.layers.push_back({name.layer, {}, {}});
      sources.emplace_back();
    }
    picture.layers[l].channels.push_back(name.channel);
    sources[l].push_back(c);
  }
  for (std::size_t l = 0; l < sources.size(); ++l) {
    Picture::Layer& layer = picture.layers[l];
    layer.pixels.reserve(sources[l].size() * n_pixels);
    for (std::size_t i = 0; i < n_pixels; ++i)
      for (const std::size_t c : sources[l]) layer.pixels.push_back(pixels[n * i + c]);
    if (!spec.format.is_floating_point()) linearise(layer);
  }
  if (metadata)
    for (const auto& attribute : spec.extra_attribs)
      if (attribute.type() == OIIO::TypeDesc::STRING) (*metadata)[attribute.name().string()] = attribute.get_string();
  return picture;
}

}  // namespace myrialux
