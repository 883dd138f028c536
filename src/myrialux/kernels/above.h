// Which of many numbers lie above a limit, as bits.
#pragma once

#include <cstdint>
#include <span>

namespace myrialux {

/// Bit i of `bits`: values[i] > limit; false for NaN; bits beyond the values are 0. Same answer on every instruction
/// set. @param bits [values.size() / 64, rounded up], set
void above(std::span<const float> values, float limit, std::span<std::uint64_t> bits);
void above_plain(std::span<const float> values, float limit, std::span<std::uint64_t> bits);

}  // namespace myrialux
