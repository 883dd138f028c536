// Column after column: sample, match against traced columns, verify, copy or trace. [wang20, algorithms 2 and 4]
#include "myrialux/completion/bamc.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "myrialux/base/error.h"
#include "myrialux/completion/column_basis.h"
#include "myrialux/completion/row_distribution.h"

namespace myrialux {
namespace {

/// Columns with no more active rows are traced whole: one packet of rays, and too little to learn from for Q.
constexpr std::size_t kTracedWhole = 16;

class Bamc {
 public:
  Bamc(EntrySource& source, const BamcParams& params, Rng& rng, BitMatrix& visible)
      : source_(source),
        params_(params),
        rng_(rng),
        visible_(visible),
        traced_(visible.words_per_column()),
        wanted_(traced_.size()),
        omega_(traced_.size()),
        pi_(traced_.size()),
        checkable_(traced_.size()) {}

  CompletionStats run();

 private:
  void complete_column(std::size_t j);
  void sample(std::size_t j, std::size_t n_active);
  bool copy_verified(std::size_t j, std::size_t n_active, BasisMatch match);
  void trace_required(std::size_t j);
  void trace_rest(std::size_t j);
  void trace_wanted(std::size_t j);
  void learn(std::size_t j);

  EntrySource& source_;
  const BamcParams params_;
  Rng& rng_;
  BitMatrix& visible_;
  CompletionStats stats_;

  // Of the group at hand.
  float alpha_ = 0;
  ColumnBasis basis_;             ///< Q
  RowDistribution distribution_;  ///< d

  // Of the column at hand, [words_per_column].
  std::vector<std::uint64_t> traced_;      ///< rows whose bit is true
  std::vector<std::uint64_t> wanted_;      ///< rows to trace next
  std::vector<std::uint64_t> omega_, pi_;  ///< sampled and verified rows
  std::vector<std::uint64_t> checkable_;   ///< rows to draw from
};

/// ceil(share * n), at most n; in single precision, so that 0.025 of 1000 rows is 25.
std::size_t share_of(float share, std::size_t n) {
  return std::min(n, static_cast<std::size_t>(std::ceil(share * static_cast<float>(n))));
}

CompletionStats Bamc::run() {
  std::size_t j = 0;
  for (std::size_t g = 0; g < source_.n_groups(); ++g) {
    basis_.reset(visible_.words_per_column());
    distribution_.reset(visible_.n_rows());
    alpha_ = std::min(params_.alpha, params_.omega);
    for (; j < source_.group_end(g); ++j) complete_column(j);
  }
  MYRIALUX_ASSERT(j == source_.n_columns());
  return stats_;
}

void Bamc::complete_column(std::size_t j) {
  const std::size_t n_active = count_bits(source_.active(j));
  if (n_active == 0) return;
  stats_.entries += n_active;
  std::fill(traced_.begin(), traced_.end(), 0);
  trace_required(j);

  // Nothing to gain where samples and verification would cost as much as the column.
  if (n_active <= kTracedWhole || share_of(alpha_, n_active) + share_of(params_.beta, n_active) >= n_active)
    return trace_rest(j);
  // Without columns in Q samples cannot match: they would be traced first, the rest of the column right after.
  if (basis_.empty()) {
    trace_rest(j);
    return learn(j);
  }

  sample(j, n_active);
  const std::vector<BasisMatch>& matches = basis_.find(visible_.column(j), omega_);
  if (!matches.empty()) {
    const BasisMatch match = matches[rng_.below(static_cast<std::uint32_t>(matches.size()))];
    if (copy_verified(j, n_active, match)) return;
    if (params_.adaptive) alpha_ = std::min(alpha_ + params_.beta, params_.omega);
  }
  trace_rest(j);
  learn(j);
}

/// Draws Omega among the rows not traced yet and traces it; required rows count as samples, too.
void Bamc::sample(std::size_t j, std::size_t n_active) {
  std::fill(omega_.begin(), omega_.end(), 0);
  const std::size_t n_samples = share_of(alpha_, n_active);
  const Words active = source_.active(j);
  for (std::size_t w = 0; w < active.size(); ++w) checkable_[w] = active[w] & ~traced_[w];
  if (params_.importance)
    distribution_.draw(n_samples, checkable_, rng_, omega_);
  else
    distribution_.draw_uniform(n_samples, checkable_, rng_, omega_);
  wanted_ = omega_;
  trace_wanted(j);
  omega_ = traced_;
}

/// Algorithm 4: compares the match with fresh samples Pi. If they agree, the column becomes the match. Rows that the
/// match does not know are traced along with Pi.
bool Bamc::copy_verified(std::size_t j, std::size_t n_active, BasisMatch match) {
  const Words active = source_.active(j), q = basis_.visible(match.column), known = basis_.known(match.column);
  const std::uint64_t turn = match.complemented ? ~std::uint64_t{0} : 0;
  for (std::size_t w = 0; w < active.size(); ++w) checkable_[w] = active[w] & known[w] & ~traced_[w];
  std::fill(pi_.begin(), pi_.end(), 0);
  distribution_.draw_uniform(share_of(params_.beta, n_active), checkable_, rng_, pi_);
  for (std::size_t w = 0; w < active.size(); ++w) wanted_[w] = pi_[w] | (active[w] & ~known[w]);
  trace_wanted(j);

  const MutableWords column = visible_.column(j);
  for (std::size_t w = 0; w < active.size(); ++w)
    if (((column[w] ^ q[w] ^ turn) & pi_[w]) != 0) return false;
  for (std::size_t w = 0; w < active.size(); ++w) {
    MYRIALUX_ASSERT(((column[w] ^ q[w] ^ turn) & traced_[w] & known[w]) == 0);  // the copy keeps every traced bit
    column[w] |= (q[w] ^ turn) & active[w] & ~traced_[w];
  }
  ++stats_.verified_columns;
  return true;
}

void Bamc::trace_required(std::size_t j) {
  const Words required = source_.required(j);
  if (required.empty()) return;
  std::copy(required.begin(), required.end(), wanted_.begin());
  trace_wanted(j);
}

/// Traces what is not traced yet.
void Bamc::trace_rest(std::size_t j) {
  const Words active = source_.active(j);
  for (std::size_t w = 0; w < active.size(); ++w) wanted_[w] = active[w] & ~traced_[w];
  trace_wanted(j);
  ++stats_.full_columns;
}

void Bamc::trace_wanted(std::size_t j) {
  const std::size_t n = count_bits(wanted_);
  if (n == 0) return;
  stats_.traced += n;
  source_.trace(j, wanted_, visible_.column(j));
  for (std::size_t w = 0; w < traced_.size(); ++w) {
    MYRIALUX_ASSERT((traced_[w] & wanted_[w]) == 0);  // no entry is asked for twice
    traced_[w] |= wanted_[w];
  }
}

/// A fully traced column joins Q and sharpens d.
void Bamc::learn(std::size_t j) {
  const Words active = source_.active(j), column = std::as_const(visible_).column(j);
  basis_.add(column, active);
  if (params_.importance) distribution_.add_column(active, column);
}

void check_share(const char* name, float value, bool zero_allowed) {
  if ((value > 0 || (zero_allowed && value == 0)) && value <= 1) return;  // false for NaN
  throw Error(ErrorKind::usage, std::string("bamc.") + name + ": must lie in " + (zero_allowed ? "[0, 1]" : "(0, 1]") +
                                    ", got " + std::to_string(value));
}

}  // namespace

CompletionStats complete_bamc(EntrySource& source, const BamcParams& params, Rng& rng, BitMatrix& visible) {
  check_share("alpha", params.alpha, false);
  check_share("beta", params.beta, true);
  check_share("omega", params.omega, false);
  MYRIALUX_ASSERT(visible.n_rows() == source.n_rows() && visible.n_columns() == source.n_columns());
  return Bamc(source, params, rng, visible).run();
}

CompletionStats trace_all(EntrySource& source, BitMatrix& visible) {
  CompletionStats stats;
  for (std::size_t j = 0; j < source.n_columns(); ++j) {
    const Words active = source.active(j);
    const std::size_t n = count_bits(active);
    if (n == 0) continue;
    source.trace(j, active, visible.column(j));
    stats.entries += n;
    stats.traced += n;
    ++stats.full_columns;
  }
  return stats;
}

}  // namespace myrialux
