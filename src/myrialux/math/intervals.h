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

/// 95 % interval of the mean of many independent numbers, told by their scatter and by how lopsided they are: where a
/// few large ones make most of it, it reaches farther up than down. [hall92, (2.2)]
/// @param variance of the mean, >= 0. @param third its third central moment
inline Interval skewed_interval(double mean, double variance, double third) {
  const double deviation = std::sqrt(variance);
  if (deviation <= 0) return {mean, mean};
  const double skewness = third / (variance * deviation);
  // The monotone cubic of the standardised mean that is normal but for terms of 1/n, solved for the mean.
  const auto at = [&](double z) {
    if (std::fabs(skewness) < 1e-6) return z;
    return 3 / skewness * (std::cbrt(1 + skewness * (z - skewness / 6)) - 1);
  };
  return {mean - deviation * at(kNormal95), mean - deviation * at(-kNormal95)};
}

}  // namespace myrialux
