// Tells walks apart by their bounces, which saves storing them with every light.
#include "myrialux/lights/walks.h"

namespace myrialux {
namespace {

bool begins_walk(const VirtualLights& lights, std::size_t j) {
  return j == 0 || lights.bounce[j] <= lights.bounce[j - 1];
}

}  // namespace

std::pair<std::size_t, std::size_t> walk_of(const VirtualLights& lights, LightId light) {
  std::size_t first = index(light), end = first + 1;
  while (!begins_walk(lights, first)) --first;
  while (end < lights.size() && !begins_walk(lights, end)) ++end;
  return {first, end};
}

double count_walks(const VirtualLights& lights) {
  if (lights.n_walks > 0) return static_cast<double>(lights.n_walks);
  double n = 0;
  for (std::size_t j = 0; j < lights.size(); ++j) n += begins_walk(lights, j) ? 1 : 0;
  return n;
}

}  // namespace myrialux
