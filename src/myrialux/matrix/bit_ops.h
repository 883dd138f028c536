// Loops over the set bits of a column, word by word.
#pragma once

#include <bit>

#include "myrialux/matrix/bit_matrix.h"

namespace myrialux {

inline constexpr std::size_t words_for(std::size_t n_rows) { return (n_rows + 63) / 64; }

/// Ones in the lowest n places; n in [0, 64].
inline constexpr std::uint64_t low_bits(std::size_t n) {
  return n >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1;
}

/// Calls visit(row) for every set bit, rows ascending.
template <class Visit>
void for_each_bit(Words words, Visit&& visit) {
  for (std::size_t w = 0; w < words.size(); ++w)
    for (std::uint64_t left = words[w]; left != 0; left &= left - 1)
      visit(w * 64 + static_cast<std::size_t>(std::countr_zero(left)));
}

/// Sets the lowest n_rows bits, clears the rest.
inline void fill_rows(MutableWords words, std::size_t n_rows) {
  for (std::size_t w = 0; w < words.size(); ++w) words[w] = n_rows > w * 64 ? low_bits(n_rows - w * 64) : 0;
}

}  // namespace myrialux
