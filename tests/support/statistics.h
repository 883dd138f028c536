// Means with measured variance, and the z-score of their difference, for tests of unbiasedness.
#pragma once

#include <cmath>
#include <cstddef>

namespace myrialux::test {

/// Mean and variance of independent values, updated one by one [welford62].
struct Sample {
  std::size_t n = 0;
  double mean = 0, squares = 0;  ///< squares: sum of squared deviations
  void add(double value) {
    const double change = value - mean;
    mean += change / static_cast<double>(++n);
    squares += change * (value - mean);
  }
  double variance_of_mean() const { return squares / (static_cast<double>(n) * static_cast<double>(n - 1)); }
};

/// Difference of two means in units of its standard error. Equal constants give 0.
inline double z_score(const Sample& a, const Sample& b) {
  const double difference = a.mean - b.mean;
  if (difference == 0) return 0;
  return difference / std::sqrt(a.variance_of_mean() + b.variance_of_mean());
}
inline double z_score(const Sample& a, double expected) {
  if (a.mean == expected) return 0;
  return (a.mean - expected) / std::sqrt(a.variance_of_mean());
}

}  // namespace myrialux::test
