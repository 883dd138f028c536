// Reads image files into memory as textures need them.
#pragma once

#include <optional>
#include <string>

#include "myrialux/scene/texture.h"

namespace myrialux {

/// 8-bit files stay bytes, all others become floats. Values are linear Rec. 709 after Image::texel.
/// @param raw   values are linear as they stand, whatever the file
/// @param gamma > 0: value^gamma instead of the sRGB curve
/// @param what  receives what is wrong when nothing comes back
std::optional<Image> read_image(const std::string& path, bool raw, float gamma, std::string& what);

}  // namespace myrialux
