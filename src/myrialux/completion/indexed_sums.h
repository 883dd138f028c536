// Draws from integer weights: inversion of their running sums by indexed search. [chen74]
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "myrialux/base/assert.h"
#include "myrialux/base/rng.h"

namespace myrialux {

/// Running sums with an index that says where to begin: a draw looks at two sums on average, whatever the weights.
class IndexedSums {
 public:
  /// weight(k) for k in [0, n), n > 0; their sum must lie in [1, 2^62]. Cost: O(n); memory is kept from call to call.
  template <class Weight>
  void build(std::size_t n, Weight&& weight) {
    sums_.resize(n);
    std::uint64_t sum = 0;
    for (std::size_t k = 0; k < n; ++k) sums_[k] = sum += weight(k);
    MYRIALUX_ASSERT(sum > 0 && sum <= std::uint64_t{1} << 62);
    index();
  }

  /// k with probability weight(k) / sum, within 2^-32.
  std::size_t draw(Rng& rng) const {
    const std::uint64_t r = rng.next_uint(), total = sums_.back();
    const std::uint64_t u = r * (total >> 32) + (r * (total & 0xffffffffu) >> 32);  // r * total / 2^32
    std::size_t k = first_[r >> shift_];
    while (sums_[k] <= u) ++k;
    return k;
  }

 private:
  /// first_[g]: number of sums that are surely at most every u of interval g of [0, sum).
  void index() {
    const std::size_t n_intervals = std::bit_ceil(sums_.size());
    shift_ = 32 - std::countr_zero(n_intervals);
    first_.assign(n_intervals + 1, 0);
    // Rounded up a little: a sum may seem to lie in a later interval than it does, never in an earlier one.
    const double scale = static_cast<double>(n_intervals) / static_cast<double>(sums_.back()) * (1 + 1e-12);
    for (std::size_t k = 0; k + 1 < sums_.size(); ++k) {
      const auto g = static_cast<std::size_t>(static_cast<double>(static_cast<std::int64_t>(sums_[k])) * scale);
      first_[g < n_intervals ? g + 1 : n_intervals] = static_cast<std::uint32_t>(k + 1);
    }
    std::uint32_t most = 0;
    for (std::uint32_t& f : first_) f = most = f > most ? f : most;
  }

  std::vector<std::uint64_t> sums_;
  std::vector<std::uint32_t> first_;  ///< [intervals + 1]; the last one only collects
  int shift_ = 0;
};

}  // namespace myrialux
