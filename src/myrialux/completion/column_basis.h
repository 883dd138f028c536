// The fully traced columns Q of one group and the search for one that agrees with some samples. [wang20, 4.5.1]
#pragma once

#include <cstdint>
#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/matrix/bit_ops.h"

namespace myrialux {

/// A column of Q, as it is or with every bit turned over.
struct BasisMatch {
  std::uint32_t column = 0;
  bool complemented = false;
};

/// Q, kept contiguous; memory is kept from group to group. Bits outside a column's known rows mean nothing.
class ColumnBasis {
 public:
  void reset(std::size_t words_per_column);
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  void add(Words visible, Words known);
  Words visible(std::size_t q) const { return Words(visible_).subspan(q * words_, words_); }
  Words known(std::size_t q) const { return Words(known_).subspan(q * words_, words_); }

  /// All columns that know every row of `omega` and agree there with `samples`, or disagree in every row; in the order
  /// of adding. Valid until the next call. Cost: about a word's comparison for most columns, size() * words at most.
  const std::vector<BasisMatch>& find(Words samples, Words omega);

 private:
  std::size_t words_ = 0, size_ = 0;
  std::vector<std::uint64_t> visible_, known_;  ///< [size * words]
  std::vector<BasisMatch> found_;
};

}  // namespace myrialux
