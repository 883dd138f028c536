// Tells walks apart by their bounces, which saves storing them with every light.
#include "myrialux/lights/walks.h"

#include <algorithm>

namespace myrialux {

Walks find_walks(const VirtualLights& lights) {
  Walks walks;
  walks.of.resize(lights.size());
  for (std::size_t j = 0; j < lights.size(); ++j) {
    if (j == 0 || lights.bounce[j] <= lights.bounce[j - 1]) ++walks.n_found;
    walks.of[j] = walks.n_found - 1;
  }
  walks.n_made = static_cast<double>(std::max<std::uint64_t>(lights.n_walks, walks.n_found));
  return walks;
}

}  // namespace myrialux
