// An entry source over a matrix that is known already: for tests, benchmarks and analysis of stored matrices.
#pragma once

#include <vector>

#include "myrialux/matrix/entry_source.h"

namespace myrialux {

/// Copies both matrices. `group_ends` ascending, the last one n_columns; empty: one group.
class KnownEntries : public EntrySource {
 public:
  KnownEntries(BitMatrix truth, BitMatrix active, std::vector<std::size_t> group_ends = {})
      : truth_(std::move(truth)), active_(std::move(active)), group_ends_(std::move(group_ends)) {
    MYRIALUX_ASSERT(truth_.n_rows() == active_.n_rows() && truth_.n_columns() == active_.n_columns());
    if (group_ends_.empty()) group_ends_ = {truth_.n_columns()};
    MYRIALUX_ASSERT(group_ends_.back() == truth_.n_columns());
  }
  std::size_t n_rows() const override { return truth_.n_rows(); }
  std::size_t n_columns() const override { return truth_.n_columns(); }
  Words active(std::size_t j) const override { return active_.column(j); }
  std::size_t n_groups() const override { return group_ends_.size(); }
  std::size_t group_end(std::size_t g) const override { return group_ends_[g]; }
  void trace(std::size_t j, Words wanted, MutableWords visible) override {
    const Words truth = truth_.column(j);
    for (std::size_t w = 0; w < wanted.size(); ++w) visible[w] = (visible[w] & ~wanted[w]) | (truth[w] & wanted[w]);
  }
  const BitMatrix& truth() const { return truth_; }
  const BitMatrix& active_matrix() const { return active_; }

 private:
  BitMatrix truth_, active_;
  std::vector<std::size_t> group_ends_;
};

}  // namespace myrialux
