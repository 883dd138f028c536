// Indices of refraction of named materials.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "myrialux/math/vec.h"

namespace myrialux {

/// Of gases, liquids and glasses at 589 nm; nothing for an unknown name. Case matters.
std::optional<float> dielectric_ior(const std::string& name);
const std::vector<std::string>& dielectric_names();

/// Complex index eta - i k as linear Rec. 709: the measured spectra seen under D65, negative channels set to 0.
struct ConductorIndex {
  Rgb eta, k;
};
std::optional<ConductorIndex> conductor_index(const std::string& name);
const std::vector<std::string>& conductor_names();

}  // namespace myrialux
