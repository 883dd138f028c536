// Each row of the echelon form is a sum of basis columns: its bits in the sampled rows, then which columns it is made
// of.
#include "myrialux/completion/gauss_jordan.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "myrialux/completion/column_basis.h"
#include "myrialux/completion/packed_rows.h"
#include "myrialux/matrix/bit_ops.h"

namespace myrialux {
namespace {

void add_to(MutableWords sum, Words term) {
  for (std::size_t w = 0; w < sum.size(); ++w) sum[w] ^= term[w];
}

/// Reduced row echelon form, grown row by row.
class EchelonForm {
 public:
  /// Rows are n_words long; leading ones are looked for in the first n_leading words.
  void reset(std::size_t n_words, std::size_t n_leading) {
    n_words_ = n_words;
    n_leading_ = n_leading;
    rows_.clear();
    leading_.clear();
  }
  /// Reduces `row` by the rows here; joins it, and reduces them by it, unless nothing is left in its leading words.
  void add(MutableWords row) {
    for (std::size_t r = 0; r < leading_.size(); ++r)
      if (test_bit(row, leading_[r])) add_to(row, at(r));
    std::size_t w = 0;
    while (w < n_leading_ && row[w] == 0) ++w;
    if (w == n_leading_) return;
    const std::size_t lead = w * 64 + static_cast<std::size_t>(std::countr_zero(row[w]));
    for (std::size_t r = 0; r < leading_.size(); ++r)
      if (test_bit(at(r), lead)) add_to(at(r), row);
    rows_.insert(rows_.end(), row.begin(), row.end());
    leading_.push_back(lead);
  }
  /// Takes from `target` what sums of the rows can take; each leading one of `target` calls for its row.
  void reduce(MutableWords target) const {
    // Rows are reduced, so no row changes another's leading place.
    for (std::size_t r = 0; r < leading_.size(); ++r)
      if (test_bit(target, leading_[r])) add_to(target, Words(rows_).subspan(r * n_words_, n_words_));
  }

 private:
  MutableWords at(std::size_t r) { return MutableWords(rows_).subspan(r * n_words_, n_words_); }
  std::size_t n_words_ = 0, n_leading_ = 0;
  std::vector<std::uint64_t> rows_;   ///< [rank * n_words]
  std::vector<std::size_t> leading_;  ///< [rank]: the leading one of each row
};

class BooleanSum final : public ColumnPredictor {
 public:
  void reset(std::size_t words_per_column) override { basis_.reset(words_per_column); }
  bool ready() const override { return true; }
  void add(Words visible, Words known) override { basis_.add(visible, known); }
  bool predict(Words samples, Words omega, Rng&, MutableWords bits, MutableWords known) override;

 private:
  ColumnBasis basis_;  ///< Q
  EchelonForm form_;
  std::vector<std::uint64_t> row_;
};

bool BooleanSum::predict(Words samples, Words omega, Rng&, MutableWords bits, MutableWords known) {
  const std::size_t n_sampled = words_for(count_bits(omega)), n_words = n_sampled + words_for(basis_.size());
  form_.reset(n_words, n_sampled);
  row_.resize(n_words);
  const MutableWords sampled_part = MutableWords(row_).first(n_sampled);
  for (std::size_t q = 0; q < basis_.size(); ++q) {
    if (!knows_all(basis_.known(q), omega)) continue;
    std::fill(row_.begin(), row_.end(), 0);
    pack_rows(basis_.visible(q), omega, sampled_part);
    set_bit(row_, n_sampled * 64 + q);
    form_.add(row_);
  }

  std::fill(row_.begin(), row_.end(), 0);
  pack_rows(samples, omega, sampled_part);
  form_.reduce(row_);
  if (count_bits(sampled_part) > 0) return false;
  std::fill(bits.begin(), bits.end(), 0);
  std::fill(known.begin(), known.end(), ~std::uint64_t{0});
  for_each_bit(Words(row_).subspan(n_sampled), [&](std::size_t q) {
    add_to(bits, basis_.visible(q));
    for (std::size_t w = 0; w < known.size(); ++w) known[w] &= basis_.known(q)[w];
  });
  return true;
}

}  // namespace

CompletionStats complete_gauss_jordan(EntrySource& source, const RowRates& params, Rng& rng, BitMatrix& visible) {
  BooleanSum sum;
  return complete_columns(source, params, "gauss-jordan", sum, rng, visible);
}

}  // namespace myrialux
