// The known bits of a slice in place of its rays: to see how far a completion of it goes wrong.
#pragma once

#include "myrialux/matrix/entry_source.h"

namespace myrialux {

/// All but trace() as the slice says. Keeps references to both.
class TracedEntries final : public EntrySource {
 public:
  TracedEntries(const EntrySource& slice, const BitMatrix& truth) : slice_(slice), truth_(truth) {}
  std::size_t n_rows() const override { return slice_.n_rows(); }
  std::size_t n_columns() const override { return slice_.n_columns(); }
  Words active(std::size_t j) const override { return slice_.active(j); }
  Words required(std::size_t j) const override { return slice_.required(j); }
  float energy(std::size_t j) const override { return slice_.energy(j); }
  void block_energies(std::size_t j, std::span<float> energies) const override { slice_.block_energies(j, energies); }
  std::span<const RowPoint> row_points() const override { return slice_.row_points(); }
  std::size_t n_groups() const override { return slice_.n_groups(); }
  std::size_t group_end(std::size_t g) const override { return slice_.group_end(g); }
  void trace(std::size_t j, Words wanted, MutableWords visible) override {
    const Words truth = truth_.column(j);
    for (std::size_t w = 0; w < wanted.size(); ++w) visible[w] = (visible[w] & ~wanted[w]) | (truth[w] & wanted[w]);
  }

 private:
  const EntrySource& slice_;
  const BitMatrix& truth_;
};

}  // namespace myrialux
