// Principal axis of points in six dimensions: the eigenvector of their covariance with the largest eigenvalue.
// From at most kAxisSamples evenly spaced points and by power iteration: only the order along the axis matters.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace myrialux {

using SixVector = std::array<float, 6>;

inline constexpr std::size_t kAxisSamples = 512;
inline constexpr int kAxisIterations = 8;

using SixMatrix = std::array<SixVector, 6>;

/// Sum of outer products of the deviations from the mean, all 36 entries.
template <class T, class Coordinates>
SixMatrix scatter_matrix(std::span<const T> points, const Coordinates& coordinates) {
  const std::size_t n = std::min(points.size(), kAxisSamples);
  const auto sample = [&](std::size_t k) -> const SixVector& { return coordinates(points[k * points.size() / n]); };
  SixVector mean{};
  for (std::size_t k = 0; k < n; ++k)
    for (int a = 0; a < 6; ++a) mean[a] += sample(k)[a];
  for (float& m : mean) m /= static_cast<float>(n);
  SixMatrix sum{};
  for (std::size_t k = 0; k < n; ++k) {
    SixVector d = sample(k);
    for (int a = 0; a < 6; ++a) d[a] -= mean[a];
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) sum[a][b] += d[a] * d[b];
  }
  return sum;
}

/// Unit vector; all 0 when the points coincide. Starts from the widest coordinate's column.
template <class T, class Coordinates>
SixVector principal_axis(std::span<T> points, const Coordinates& coordinates) {
  const SixMatrix m = scatter_matrix<T>(points, coordinates);
  int widest = 0;
  for (int k = 1; k < 6; ++k)
    if (m[k][k] > m[widest][widest]) widest = k;
  SixVector axis = m[widest];
  for (int iteration = 0; iteration <= kAxisIterations; ++iteration) {
    float largest = 0, norm = 0;  // scaled first, so that squares stay in range
    for (const float a : axis) largest = std::max(largest, std::fabs(a));
    if (!(largest > 0)) return {};
    for (float& a : axis) a /= largest, norm += a * a;
    const float inverse = 1 / std::sqrt(norm);
    for (float& a : axis) a *= inverse;
    if (iteration == kAxisIterations) break;
    SixVector next{};
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) next[b] += m[a][b] * axis[a];
    axis = next;
  }
  return axis;
}

}  // namespace myrialux
