// Order statistics of receivers' positions.
#include "myrialux/pipeline/clamp.h"

#include <algorithm>
#include <array>

#include "myrialux/base/ranks.h"

namespace myrialux {
namespace {

/// The values of the given ranks, rising, of x(0), ..., x(n - 1). Parallel.
template <std::size_t N, class X>
std::array<float, N> order_statistics(std::size_t n, const std::array<std::size_t, N>& ranks, const X& x) {
  const std::array<RankBin, N> bins = rank_bins(n, ranks, x);
  std::array<float, N> result{};
  for (std::size_t k = 0; k < N; ++k) {
    Array<float> values = select<float>(
        n, [&](std::size_t i) { return upper_bits(x(i)) == bins[k].upper; }, x);
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(ranks[k] - bins[k].before);
    std::nth_element(values.begin(), place, values.end());
    result[k] = *place;
  }
  return result;
}

}  // namespace

Array<Vec3> size_points(const Receivers& receivers, int spp) {
  return select<Vec3>(
      receivers.size(),
      [&](std::size_t i) { return receivers.sample[i] % static_cast<std::uint32_t>(spp) < kSizeSamples; },
      [&](std::size_t i) { return receivers.p[i]; });
}

float robust_radius(std::span<const Vec3> points) {
  if (points.empty()) return 0;
  const std::size_t low = points.size() / 50, high = points.size() - 1 - low;
  Vec3 extent;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [lower, upper] =
        order_statistics(points.size(), std::array{low, high}, [&](std::size_t i) { return points[i][axis]; });
    extent[axis] = upper - lower;
  }
  return 0.5f * length(extent);
}

float clamp_length(float clamp, float clamp_distance, std::span<const Vec3> points) {
  return clamp_distance >= 0 ? clamp_distance : clamp * robust_radius(points);
}

}  // namespace myrialux
