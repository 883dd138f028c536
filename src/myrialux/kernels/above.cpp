// Values are the lanes; what does not fill a vector is done one by one. Plain twin below.
#include "myrialux/kernels/above.h"

#include <algorithm>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/targets.h"
// The rest of this file up to HWY_ONCE is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "myrialux/kernels/above.cpp"
#include "hwy/foreach_target.h"
// Order matters: after foreach_target.h.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;

void above_limit(std::span<const float> values, float limit, std::span<std::uint64_t> bits) {
  const Tag d;
  const std::size_t lanes = hn::Lanes(d);
  const auto limits = hn::Set(d, limit);
  std::fill(bits.begin(), bits.end(), std::uint64_t{0});
  std::size_t i = 0;
  for (; i + lanes <= values.size(); i += lanes) {
    std::uint8_t bytes[2] = {};
    hn::StoreMaskBits(d, hn::Gt(hn::LoadU(d, values.data() + i), limits), bytes);
    const std::uint64_t mask = (bytes[0] | std::uint64_t{bytes[1]} << 8) & ((std::uint64_t{1} << lanes) - 1);
    bits[i / 64] |= mask << i % 64;
  }
  for (; i < values.size(); ++i)
    if (values[i] > limit) bits[i / 64] |= std::uint64_t{1} << i % 64;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace myrialux {

HWY_EXPORT(above_limit);

void above(std::span<const float> values, float limit, std::span<std::uint64_t> bits) {
  MYRIALUX_ASSERT(bits.size() * 64 >= values.size());
  HWY_DYNAMIC_DISPATCH(above_limit)(values, limit, bits);
}

void above_plain(std::span<const float> values, float limit, std::span<std::uint64_t> bits) {
  std::fill(bits.begin(), bits.end(), std::uint64_t{0});
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] > limit) bits[i / 64] |= std::uint64_t{1} << i % 64;
}

}  // namespace myrialux
#endif
