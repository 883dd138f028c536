// Order statistics of receivers' positions.
#include "myrialux/pipeline/clamp.h"

#include <algorithm>

#include "myrialux/base/parallel.h"

namespace myrialux {

std::vector<Vec3> size_points(const Receivers& receivers, int spp) {
  std::vector<Vec3> points;
  points.reserve(receivers.size());  // about right for few samples a pixel; pages not touched cost nothing
  for (std::size_t i = 0; i < receivers.size(); ++i)
    if (receivers.sample[i] % static_cast<std::uint32_t>(spp) < kSizeSamples) points.push_back(receivers.p[i]);
  return points;
}

float robust_radius(const std::vector<Vec3>& points) {
  if (points.empty()) return 0;
  Vec3 extent;
  parallel_for(3, [&](std::size_t axis) {
    std::vector<float> values(points.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = points[i][static_cast<int>(axis)];
    const std::size_t low = values.size() / 50, high = values.size() - 1 - low;
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(low), values.end());
    const float lower = values[low];
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(high), values.end());
    extent[static_cast<int>(axis)] = values[high] - lower;
  });
  return 0.5f * length(extent);
}

float clamp_length(float clamp, float clamp_distance, const std::vector<Vec3>& points) {
  return clamp_distance >= 0 ? clamp_distance : clamp * robust_radius(points);
}

}  // namespace myrialux
