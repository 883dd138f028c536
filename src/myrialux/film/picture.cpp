// Layers of a picture by name.
#include <algorithm>

#include "myrialux/base/assert.h"
#include "myrialux/film/film.h"

namespace myrialux {

Picture::Layer& Picture::add_layer(const std::string& name, std::vector<std::string> channels) {
  MYRIALUX_ASSERT(find(name) == nullptr);
  const std::size_t n = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * channels.size();
  layers.push_back({name, std::move(channels), std::vector<float>(n)});
  return layers.back();
}

std::size_t Picture::n_channels() const {
  std::size_t n = 0;
  for (const Layer& layer : layers) n += layer.channels.size();
  return n;
}

const Picture::Layer* Picture::find(const std::string& name) const {
  const auto it = std::find_if(layers.begin(), layers.end(), [&](const Layer& l) { return l.name == name; });
  return it == layers.end() ? nullptr : &*it;
}

}  // namespace myrialux
