// Non-negative floats in 16 bits: the first half of their bits, where 8 bits of mantissa are enough.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace myrialux {

/// The least short float that is not below x. @param x in [0, infinity); what is above 1e38 counts as that
inline std::uint16_t short_above(float x) {
  return static_cast<std::uint16_t>((std::bit_cast<std::uint32_t>(std::min(x, 1e38f)) + 0xffff) >> 16);
}

inline float from_short(std::uint16_t x) { return std::bit_cast<float>(std::uint32_t{x} << 16); }

}  // namespace myrialux
