// Boolean matching: ((q ^ samples) & omega) is 0 for a match, omega for a match of the complement. [wang20, 4.5.1]
#include "myrialux/completion/column_basis.h"

namespace myrialux {

void ColumnBasis::reset(std::size_t words_per_column) {
  words_ = words_per_column;
  size_ = 0;
  visible_.clear();
  known_.clear();
}

void ColumnBasis::add(Words visible, Words known) {
  MYRIALUX_ASSERT(visible.size() == words_ && known.size() == words_);
  visible_.insert(visible_.end(), visible.begin(), visible.end());
  known_.insert(known_.end(), known.begin(), known.end());
  ++size_;
}

const std::vector<BasisMatch>& ColumnBasis::find(Words samples, Words omega) {
  found_.clear();
  for (std::size_t q = 0; q < size_; ++q) {
    const std::uint64_t* bits = visible_.data() + q * words_;
    const std::uint64_t* known = known_.data() + q * words_;
    bool same = true, opposite = true;
    for (std::size_t w = 0; w < words_ && (same || opposite); ++w) {
      const std::uint64_t differ = (bits[w] ^ samples[w]) & omega[w];
      const bool all_known = (omega[w] & ~known[w]) == 0;
      same &= all_known && differ == 0;
      opposite &= all_known && differ == omega[w];
    }
    if (same) found_.push_back({static_cast<std::uint32_t>(q), false});
    if (opposite) found_.push_back({static_cast<std::uint32_t>(q), true});
  }
  return found_;
}

}  // namespace myrialux
