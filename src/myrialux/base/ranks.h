// Which value is the k-th smallest, by all threads: numbers are counted by their upper halves, so that few are left to
// be put in order.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "myrialux/base/parallel.h"

namespace myrialux {

/// Upper half of the number that stands in the order of floats for x (-0 below 0).
inline std::uint32_t upper_bits(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  return (bits >> 31 ? ~bits : bits | 0x80000000u) >> 16;
}

/// Values that share their upper bits.
struct RankBin {
  std::uint32_t upper;
  std::size_t before;  ///< how many values are in lower bins
};

/// The bins of the values of the given ranks, rising, among x(0), ..., x(n - 1).
template <std::size_t N, class X>
std::array<RankBin, N> rank_bins(std::size_t n, const std::array<std::size_t, N>& ranks, const X& x) {
  constexpr std::size_t kBins = 1 << 16;
  const std::size_t n_parts = std::min<std::size_t>(32, n / kBins + 1);  // 256 KB each
  std::vector<std::vector<std::uint32_t>> counts(n_parts);
  parallel_for(n_parts, [&](std::size_t part) {
    counts[part].resize(kBins);
    for (std::size_t i = n * part / n_parts; i < n * (part + 1) / n_parts; ++i) ++counts[part][upper_bits(x(i))];
  });
  std::array<RankBin, N> bins{};
  std::size_t found = 0, sum = 0;
  for (std::uint32_t b = 0; b < kBins && found < N; ++b) {
    const std::size_t before = sum;
    for (const std::vector<std::uint32_t>& of_part : counts) sum += of_part[b];
    for (; found < N && ranks[found] < sum; ++found) bins[found] = {b, before};
  }
  return bins;
}

}  // namespace myrialux
