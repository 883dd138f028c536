// A ring of bit columns, side by side as the search wants them.
#include "myrialux/completion/remembered_columns.h"

#include <algorithm>

namespace myrialux {

void RememberedColumns::add(Words visible, Words known, Words blocks, Kind kind) {
  if (kinds_.size() < capacity_) {
    visible_.insert(visible_.end(), visible.begin(), visible.end());
    known_.insert(known_.end(), known.begin(), known.end());
    blocks_.insert(blocks_.end(), blocks.begin(), blocks.end());
    newest_ = kinds_.size();
    kinds_.push_back(kind);
    return;
  }
  newest_ = (newest_ + 1) % capacity_;
  const auto at = static_cast<std::ptrdiff_t>(newest_ * words_);
  std::copy(visible.begin(), visible.end(), visible_.begin() + at);
  std::copy(known.begin(), known.end(), known_.begin() + at);
  std::copy(blocks.begin(), blocks.end(), blocks_.begin() + static_cast<std::ptrdiff_t>(newest_ * block_words_));
  kinds_[newest_] = kind;
}

}  // namespace myrialux
