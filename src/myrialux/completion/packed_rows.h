// Bits of a column at some of its rows, moved together.
#pragma once

#include <algorithm>

#include "myrialux/matrix/bit_ops.h"

namespace myrialux {

/// packed [words_for(number of ones in omega)]: bit k is the bit of `words` at the k-th one of `omega`.
inline void pack_rows(Words words, Words omega, MutableWords packed) {
  std::fill(packed.begin(), packed.end(), 0);
  std::size_t k = 0;
  for_each_bit(omega, [&](std::size_t i) {
    packed[k / 64] |= static_cast<std::uint64_t>(test_bit(words, i)) << k % 64;
    ++k;
  });
}

/// Whether `known` has every one of `omega`.
inline bool knows_all(Words known, Words omega) {
  for (std::size_t w = 0; w < omega.size(); ++w)
    if ((omega[w] & ~known[w]) != 0) return false;
  return true;
}

}  // namespace myrialux
