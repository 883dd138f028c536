// Small picture files for tests.
#pragma once

#include <OpenImageIO/imageio.h>

#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "myrialux/film/film.h"

namespace myrialux::test {

/// An EXR whose channels all hold `value`; its header says "myrialux.method" = "test". Gives back the path.
inline std::string write_gray(const std::string& path, int width, int height, float value,
                              const std::vector<std::string>& channels = {"R", "G", "B"}) {
  Picture picture{width, height, {}};
  for (float& v : picture.add_layer("", channels).pixels) v = value;
  write_picture(picture, path, {{"myrialux.method", "test"}});
  return path;
}

/// The same with NaN in the first pixel's G: by the library, since write_picture refuses it.
inline std::string write_with_nan(const std::string& path, int width, int height, float value) {
  const OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::FLOAT);
  std::vector<float> pixels(3 * static_cast<std::size_t>(width * height), value);
  pixels[1] = std::numeric_limits<float>::quiet_NaN();
  OIIO::attribute("exr_threads", -1);
  const auto output = OIIO::ImageOutput::create(path);
  if (!output || !output->open(path, spec) || !output->write_image(OIIO::TypeDesc::FLOAT, pixels.data())) abort();
  output->close();
  return path;
}

}  // namespace myrialux::test
