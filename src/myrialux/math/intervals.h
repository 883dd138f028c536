// Confidence intervals of what was counted.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace myrialux {

struct Interval {
  double low = 0, high = 0;
};

/// Standard deviations on either side of the mean that hold 95 % of a normal distribution.
inline constexpr double kNormal95 = 1.959963985;

/// 95 % interval of a share of which `hits` of `n` independent trials told [wilson27]; n = 0: [0, 1].
inline Interval share_interval(std::uint64_t hits, std::uint64_t n) {
  if (n == 0) return {0, 1};
  constexpr double z2 = kNormal95 * kNormal95;
  const double trials = static_cast<double>(n), share = static_cast<double>(hits) / trials;
  const double middle = share + z2 / (2 * trials);
  const double half = kNormal95 * std::sqrt(share * (1 - share) / trials + z2 / (4 * trials * trials));
  const double scale = 1 / (1 + z2 / trials);
  return {std::max(0.0, (middle - half) * scale), std::min(1.0, (middle + half) * scale)};
}

}  // namespace myrialux
