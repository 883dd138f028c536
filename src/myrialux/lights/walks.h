// Which virtual lights come from the same light walk: walks are independent of each other, lights of one are not.
#pragma once

#include <cstdint>
#include <vector>

#include "myrialux/lights/virtual_lights.h"

namespace myrialux {

/// Lights grouped by walk.
struct Walks {
  std::vector<std::uint32_t> of;  ///< [lights.size()] number of the light's walk among those that left lights, rising
  std::uint32_t n_found = 0;      ///< of these
  double n_made = 0;              ///< all walks; VirtualLights::n_walks, or n_found where that is not known
};

/// Lights are ordered by walk and their bounces rise along it, so a bounce that does not rise begins a new walk. Two
/// walks whose lights follow on by chance are taken for one, which only lights without bounce 0 can be; being
/// independent they change a variance between walks by a share of about 1 / n_found.
Walks find_walks(const VirtualLights& lights);

}  // namespace myrialux
