// Keeps what is traced of the column at hand, so that no entry is asked for twice whatever the predictor does.
#include "myrialux/completion/adaptive_columns.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/completion/row_distribution.h"

namespace myrialux {
namespace {

/// Columns with no more active rows are traced whole: one packet of rays, and too little to learn from.
constexpr std::size_t kTracedWhole = 16;

class AdaptiveColumns {
 public:
  AdaptiveColumns(EntrySource& source, const RowRates& rates, ColumnPredictor& predictor, Rng& rng, BitMatrix& visible)
      : source_(source),
        rates_(rates),
        predictor_(predictor),
        rng_(rng),
        visible_(visible),
        traced_(visible.words_per_column()),
        wanted_(traced_.size()),
        omega_(traced_.size()),
        pi_(traced_.size()),
        checkable_(traced_.size()),
        bits_(traced_.size()),
        known_(traced_.size()),
        kept_(traced_.size()) {}

  CompletionStats run();

 private:
  void complete_column(std::size_t j);
  void sample(std::size_t j, std::size_t n_active);
  void draw_samples(std::size_t count, Words eligible);
  bool take_verified(std::size_t j, std::size_t n_active);
  void trace_required(std::size_t j);
  void trace_rest(std::size_t j);
  void trace_wanted(std::size_t j);
  void learn(std::size_t j);

  EntrySource& source_;
  const RowRates rates_;
  ColumnPredictor& predictor_;
  Rng& rng_;
  BitMatrix& visible_;
  CompletionStats stats_;

  // Of the group at hand.
  float alpha_ = 0;
  RowDistribution distribution_;  ///< d

  // Of the column at hand, [words_per_column].
  std::vector<std::uint64_t> traced_;        ///< rows whose bit is true
  std::vector<std::uint64_t> wanted_;        ///< rows to trace next
  std::vector<std::uint64_t> omega_, pi_;    ///< sampled and verified rows
  std::vector<std::uint64_t> checkable_;     ///< rows to draw from
  std::vector<std::uint64_t> bits_, known_;  ///< the prediction
  std::vector<std::uint64_t> kept_;          ///< Omega that outlives its column; rates.resample = false only
  bool keeps_ = false;                       ///< kept_ is set
};

/// ceil(share * n), at most n; in single precision, so that 0.025 of 1000 rows is 25.
std::size_t share_of(float share, std::size_t n) {
  return std::min(n, static_cast<std::size_t>(std::ceil(share * static_cast<float>(n))));
}

CompletionStats AdaptiveColumns::run() {
  std::size_t j = 0;
  for (std::size_t g = 0; g < source_.n_groups(); ++g) {
    predictor_.reset(visible_.words_per_column());
    distribution_.reset(visible_.n_rows());
    keeps_ = false;
    alpha_ = std::min(rates_.alpha, rates_.omega);
    for (; j < source_.group_end(g); ++j) complete_column(j);
  }
  MYRIALUX_ASSERT(j == source_.n_columns());
  return stats_;
}

void AdaptiveColumns::complete_column(std::size_t j) {
  const std::size_t n_active = count_bits(source_.active(j));
  if (n_active == 0) return;
  stats_.entries += n_active;
  std::fill(traced_.begin(), traced_.end(), 0);
  trace_required(j);

  // Nothing to gain where samples and verification would cost as much as the column.
  if (n_active <= kTracedWhole || share_of(alpha_, n_active) + share_of(rates_.beta, n_active) >= n_active)
    return trace_rest(j);
  // Samples that nothing can be predicted from would be traced first, the rest of the column right after.
  if (!predictor_.ready()) {
    trace_rest(j);
    return learn(j);
  }

  sample(j, n_active);
  if (count_bits(omega_) > 0 && predictor_.predict(visible_.column(j), omega_, rng_, bits_, known_)) {
    if (take_verified(j, n_active)) return;
    if (rates_.adaptive) alpha_ = std::min(alpha_ + rates_.beta, rates_.omega);
  }
  trace_rest(j);
  learn(j);
}

/// Draws Omega among the rows not traced yet and traces it; required rows count as samples, too.
void AdaptiveColumns::sample(std::size_t j, std::size_t n_active) {
  const Words active = source_.active(j);
  if (rates_.resample) {
    std::fill(omega_.begin(), omega_.end(), 0);
    for (std::size_t w = 0; w < active.size(); ++w) checkable_[w] = active[w] & ~traced_[w];
    draw_samples(share_of(alpha_, n_active), checkable_);
  } else {
    // Algorithm 1: Omega outlives its column, so it is a set of rows of the slice; those active here are sampled.
    if (!keeps_) {
      fill_rows(checkable_, visible_.n_rows());
      std::fill(omega_.begin(), omega_.end(), 0);
      draw_samples(share_of(alpha_, visible_.n_rows()), checkable_);
      kept_ = omega_;
      keeps_ = true;
    }
    for (std::size_t w = 0; w < active.size(); ++w) omega_[w] = kept_[w] & active[w] & ~traced_[w];
  }
  wanted_ = omega_;
  trace_wanted(j);
  omega_ = traced_;
}

void AdaptiveColumns::draw_samples(std::size_t count, Words eligible) {
  if (rates_.importance)
    distribution_.draw(count, eligible, rng_, omega_);
  else
    distribution_.draw_uniform(count, eligible, rng_, omega_);
}

/// Algorithm 4: compares the prediction with fresh samples Pi. If they agree, the column becomes the prediction. Rows
/// that the prediction does not know are traced along with Pi.
bool AdaptiveColumns::take_verified(std::size_t j, std::size_t n_active) {
  const Words active = source_.active(j);
  for (std::size_t w = 0; w < active.size(); ++w) checkable_[w] = active[w] & known_[w] & ~traced_[w];
  std::fill(pi_.begin(), pi_.end(), 0);
  distribution_.draw_uniform(share_of(rates_.beta, n_active), checkable_, rng_, pi_);
  for (std::size_t w = 0; w < active.size(); ++w) wanted_[w] = pi_[w] | (active[w] & ~known_[w] & ~traced_[w]);
  trace_wanted(j);

  const MutableWords column = visible_.column(j);
  for (std::size_t w = 0; w < active.size(); ++w)
    if (((column[w] ^ bits_[w]) & pi_[w]) != 0) return false;
  for (std::size_t w = 0; w < active.size(); ++w) {
    MYRIALUX_ASSERT(((column[w] ^ bits_[w]) & traced_[w] & known_[w]) == 0);  // the prediction keeps every traced bit
    column[w] |= bits_[w] & active[w] & ~traced_[w];
  }
  ++stats_.verified_columns;
  return true;
}

void AdaptiveColumns::trace_required(std::size_t j) {
  const Words required = source_.required(j);
  if (required.empty()) return;
  std::copy(required.begin(), required.end(), wanted_.begin());
  trace_wanted(j);
}

/// Traces what is not traced yet.
void AdaptiveColumns::trace_rest(std::size_t j) {
  const Words active = source_.active(j);
  for (std::size_t w = 0; w < active.size(); ++w) wanted_[w] = active[w] & ~traced_[w];
  trace_wanted(j);
  ++stats_.full_columns;
}

void AdaptiveColumns::trace_wanted(std::size_t j) {
  const std::size_t n = count_bits(wanted_);
  if (n == 0) return;
  stats_.traced += n;
  source_.trace(j, wanted_, visible_.column(j));
  for (std::size_t w = 0; w < traced_.size(); ++w) {
    MYRIALUX_ASSERT((traced_[w] & wanted_[w]) == 0);  // no entry is asked for twice
    traced_[w] |= wanted_[w];
  }
}

/// A fully traced column is learnt by the predictor and sharpens d; a kept Omega is drawn anew.
void AdaptiveColumns::learn(std::size_t j) {
  const Words active = source_.active(j), column = std::as_const(visible_).column(j);
  predictor_.add(column, active);
  if (rates_.importance) distribution_.add_column(active, column);
  keeps_ = false;
}

void check_share(const char* method, const char* name, float value, bool zero_allowed) {
  if ((value > 0 || (zero_allowed && value == 0)) && value <= 1) return;  // false for NaN
  throw Error(ErrorKind::usage, std::string(method) + "." + name + ": must lie in " +
                                    (zero_allowed ? "[0, 1]" : "(0, 1]") + ", got " + std::to_string(value));
}

}  // namespace

CompletionStats complete_columns(EntrySource& source, const RowRates& rates, const char* name,
                                 ColumnPredictor& predictor, Rng& rng, BitMatrix& visible) {
  check_share(name, "alpha", rates.alpha, false);
  check_share(name, "beta", rates.beta, true);
  check_share(name, "omega", rates.omega, false);
  MYRIALUX_ASSERT(visible.n_rows() == source.n_rows() && visible.n_columns() == source.n_columns());
  return AdaptiveColumns(source, rates, predictor, rng, visible).run();
}

}  // namespace myrialux
