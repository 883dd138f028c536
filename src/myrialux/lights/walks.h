// Which virtual lights come from the same light walk: walks are independent of each other, lights of one are not.
#pragma once

#include <cstdint>
#include <utility>

#include "myrialux/lights/virtual_lights.h"

namespace myrialux {

/// Lights [first, second) of the walk that left `light`. Lights are ordered by walk and their bounces rise along it, so
/// a bounce that does not rise begins a new walk. Where lights of bounce 0 are left out, two walks may follow on by
/// chance and are taken for one; they are independent, so that a variance between walks hardly changes.
std::pair<std::size_t, std::size_t> walk_of(const VirtualLights& lights, LightId light);

/// All walks made, those that left no lights included; where that is not known, those that left some.
double count_walks(const VirtualLights& lights);

}  // namespace myrialux
