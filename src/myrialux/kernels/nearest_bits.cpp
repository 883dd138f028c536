// Words of a column are the lanes; the last, partial vector is done word by word. Plain twin below.
#include "myrialux/kernels/nearest_bits.h"

#include <bit>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/targets.h"
// The rest of this file up to HWY_ONCE is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "myrialux/kernels/nearest_bits.cpp"
#include "hwy/foreach_target.h"
// Order matters: after foreach_target.h.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<std::uint64_t, 8>;

std::size_t distance(const std::uint64_t* visible, const std::uint64_t* known, const std::uint64_t* samples,
                     const std::uint64_t* omega, std::size_t words) {
  const Tag d;
  auto sum = hn::Zero(d);
  std::size_t w = 0;
  for (; w + hn::Lanes(d) <= words; w += hn::Lanes(d)) {
    const auto differ = hn::Xor(hn::LoadU(d, visible + w), hn::LoadU(d, samples + w));
    const auto wrong = hn::And(hn::Or(differ, hn::Not(hn::LoadU(d, known + w))), hn::LoadU(d, omega + w));
    sum = hn::Add(sum, hn::PopulationCount(wrong));
  }
  std::size_t total = static_cast<std::size_t>(hn::GetLane(hn::SumOfLanes(d, sum)));
  for (; w < words; ++w)
    total += static_cast<std::size_t>(std::popcount(((visible[w] ^ samples[w]) | ~known[w]) & omega[w]));
  return total;
}

NearestColumn nearest(const BitColumns& columns, std::size_t first, std::span<const std::uint64_t> samples,
                      std::span<const std::uint64_t> omega) {
  const std::size_t n = columns.visible.size() / columns.words;
  NearestColumn best{first, ~std::size_t{0}};
  for (std::size_t k = 0, q = first; k < n && best.distance > 0; ++k, q = q == 0 ? n - 1 : q - 1) {
    const std::size_t at = q * columns.words;
    const std::size_t here =
        distance(columns.visible.data() + at, columns.known.data() + at, samples.data(), omega.data(), columns.words);
    if (here < best.distance) best = {q, here};
  }
  return best;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace myrialux {

HWY_EXPORT(nearest);

NearestColumn nearest_column(const BitColumns& columns, std::size_t first, std::span<const std::uint64_t> samples,
                             std::span<const std::uint64_t> omega) {
  MYRIALUX_ASSERT(columns.words > 0 && samples.size() == columns.words && omega.size() == columns.words);
  MYRIALUX_ASSERT(columns.visible.size() == columns.known.size() && first * columns.words < columns.visible.size());
  return HWY_DYNAMIC_DISPATCH(nearest)(columns, first, samples, omega);
}

NearestColumn nearest_column_plain(const BitColumns& columns, std::size_t first, std::span<const std::uint64_t> samples,
                                   std::span<const std::uint64_t> omega) {
  const std::size_t n = columns.visible.size() / columns.words;
  NearestColumn best{first, ~std::size_t{0}};
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t q = (first + n - k) % n;
    std::size_t here = 0;
    for (std::size_t w = 0; w < columns.words; ++w) {
      const std::uint64_t differ = columns.visible[q * columns.words + w] ^ samples[w];
      here += static_cast<std::size_t>(std::popcount((differ | ~columns.known[q * columns.words + w]) & omega[w]));
    }
    if (here < best.distance) best = {q, here};
  }
  return best;
}

}  // namespace myrialux
#endif
