// Samples are packed, projected, and the coefficients applied to whole columns.
#include "myrialux/completion/amc.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/completion/column_basis.h"
#include "myrialux/completion/packed_rows.h"
#include "myrialux/completion/projection.h"

namespace myrialux {
namespace {

/// Coefficients below are 0 but for rounding: those that are not are fractions of small whole numbers.
constexpr double kNoCoefficient = 1e-9;

class Projection final : public ColumnPredictor {
 public:
  explicit Projection(float tolerance) : tolerance_(tolerance) {}
  void reset(std::size_t words_per_column) override {
    basis_.reset(words_per_column);
    column_.resize(words_per_column * 64);
  }
  bool ready() const override { return true; }
  void add(Words visible, Words known) override { basis_.add(visible, known); }
  bool predict(Words samples, Words omega, Rng&, MutableWords bits, MutableWords known) override;

 private:
  const double tolerance_;
  ColumnBasis basis_;  ///< Q
  BitProjection projection_;
  std::vector<std::size_t> usable_;     ///< columns of Q that know every sampled row
  std::vector<std::uint64_t> q_omega_;  ///< their sampled rows, packed
  std::vector<std::uint64_t> x_;        ///< the samples, packed
  std::vector<double> column_;          ///< Q c, [64 words_per_column]
};

bool Projection::predict(Words samples, Words omega, Rng&, MutableWords bits, MutableWords known) {
  usable_.clear();
  for (std::size_t q = 0; q < basis_.size(); ++q)
    if (knows_all(basis_.known(q), omega)) usable_.push_back(q);
  const std::size_t n_sampled = count_bits(omega), words = words_for(n_sampled);
  q_omega_.resize(usable_.size() * words);
  for (std::size_t k = 0; k < usable_.size(); ++k)
    pack_rows(basis_.visible(usable_[k]), omega, MutableWords(q_omega_).subspan(k * words, words));
  x_.resize(words);
  pack_rows(samples, omega, x_);
  const std::vector<double>& c = projection_.solve(n_sampled, usable_.size(), q_omega_, x_);

  std::fill(column_.begin(), column_.end(), 0);
  std::fill(known.begin(), known.end(), ~std::uint64_t{0});
  for (std::size_t k = 0; k < usable_.size(); ++k) {
    if (std::abs(c[k]) < kNoCoefficient) continue;
    const Words known_q = basis_.known(usable_[k]);
    for (std::size_t w = 0; w < known.size(); ++w) known[w] &= known_q[w];
    for_each_bit(basis_.visible(usable_[k]), [&](std::size_t i) { column_[i] += c[k]; });
  }
  double residual = 0;
  for_each_bit(omega, [&](std::size_t i) {
    const double r = column_[i] - (test_bit(samples, i) ? 1 : 0);
    residual += r * r;
  });
  if (!(residual <= tolerance_)) return false;

  std::fill(bits.begin(), bits.end(), 0);
  for (std::size_t i = 0; i < column_.size(); ++i)
    if (column_[i] > 0.5 + kNoCoefficient) set_bit(bits, i);  // halves, the mean of two columns, are not above 0.5
  for (std::size_t w = 0; w < bits.size(); ++w)
    if (((bits[w] ^ samples[w]) & omega[w]) != 0) return false;
  return true;
}

}  // namespace

CompletionStats complete_amc(EntrySource& source, const AmcParams& params, Rng& rng, BitMatrix& visible) {
  if (!(params.tolerance >= 0))
    throw Error(ErrorKind::usage, "amc.tolerance: must be >= 0, got " + std::to_string(params.tolerance));
  Projection projection(params.tolerance);
  return complete_columns(source, params.rows, "amc", projection, rng, visible);
}

}  // namespace myrialux
