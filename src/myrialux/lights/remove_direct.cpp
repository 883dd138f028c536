// Leaves out the virtual lights that stand for direct light.
#include <vector>

#include "myrialux/lights/virtual_lights.h"

namespace myrialux {

void remove_direct(VirtualLights& lights) {
  std::vector<bool> keep(lights.size());
  for (std::size_t j = 0; j < keep.size(); ++j) keep[j] = lights.bounce[j] > 0;
  const auto compact = [&](auto& values) {
    std::size_t n = 0;
    for (std::size_t j = 0; j < keep.size(); ++j)
      if (keep[j]) values[n++] = values[j];
    values.resize(n);
  };
  compact(lights.p), compact(lights.n), compact(lights.ng), compact(lights.offset), compact(lights.light);
  compact(lights.kind), compact(lights.extra), compact(lights.bounce);
}

}  // namespace myrialux
