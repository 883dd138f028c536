// Columns of a group are sampled and guessed in turn, round after round, then separated as one matrix.
#include "myrialux/completion/matrix_separation.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/completion/entry_predictors.h"
#include "myrialux/completion/row_distribution.h"

namespace myrialux {
namespace {

constexpr std::size_t kTracedWhole = 16;      ///< active rows: one packet of rays
constexpr std::size_t kSeparatedColumns = 8;  ///< groups of fewer are not separated

class Separation {
 public:
  Separation(EntrySource& source, const SeparationParams& params, Rng& rng, BitMatrix& visible)
      : source_(source),
        params_(params),
        rng_(rng),
        visible_(visible),
        traced_(visible.n_rows(), visible.n_columns()),
        guessed_(visible.n_rows(), visible.n_columns()),
        wanted_(visible.words_per_column()),
        eligible_(wanted_.size()),
        guess_(wanted_.size()),
        best_(wanted_.size()) {}

  CompletionStats run();

 private:
  void complete_group(ColumnRange group);
  void sample(std::size_t j);
  std::size_t trace_share(std::size_t j);
  std::size_t trace_rest(std::size_t j);
  void trace_wanted(std::size_t j);
  bool validate(std::size_t j, ColumnRange group);
  void guess(std::size_t j, ColumnRange group, std::vector<std::vector<std::uint64_t>>& guesses);
  void separate(ColumnRange group);
  void take_guesses(ColumnRange group);
  SampledBits sampled() const { return {visible_, traced_}; }

  EntrySource& source_;
  const SeparationParams params_;
  Rng& rng_;
  BitMatrix& visible_;
  BitMatrix traced_, guessed_;
  RowDistribution distribution_;  ///< uniform draws only
  CompletionStats stats_;
  float least_energy_ = 0;
  std::vector<std::uint64_t> wanted_, eligible_, guess_, best_;  ///< [words_per_column]
  std::vector<std::vector<std::uint64_t>> guesses_;
};

CompletionStats Separation::run() {
  distribution_.reset(visible_.n_rows());
  double energy = 0;
  for (std::size_t j = 0; j < source_.n_columns(); ++j) energy += source_.energy(j);
  if (source_.n_columns() > 0)
    least_energy_ = params_.energy * static_cast<float>(energy / static_cast<double>(source_.n_columns()));
  std::size_t begin = 0;
  for (std::size_t g = 0; g < source_.n_groups(); ++g) {
    complete_group({begin, source_.group_end(g)});
    begin = source_.group_end(g);
  }
  MYRIALUX_ASSERT(begin == source_.n_columns());
  return stats_;
}

void Separation::complete_group(ColumnRange group) {
  for (std::size_t j = group.begin; j < group.end; ++j) sample(j);

  // Every round guesses from the samples of all columns, so columns take turns, not rounds.
  std::vector<std::size_t> open;
  for (std::size_t j = group.begin; j < group.end; ++j) {
    if (count_bits(source_.active(j)) == count_bits(std::as_const(traced_).column(j))) continue;
    if (source_.energy(j) >= least_energy_ && params_.rounds > 0)
      open.push_back(j);
    else
      predict_by_neighbours(sampled(), j, guessed_.column(j));
  }
  for (std::uint32_t round = 0; round < params_.rounds && !open.empty(); ++round)
    std::erase_if(open, [&](std::size_t j) { return validate(j, group); });

  if (params_.separate && group.end - group.begin >= kSeparatedColumns)
    separate(group);
  else
    take_guesses(group);
}

/// The first samples of a column; all of it where that costs no more than a packet.
void Separation::sample(std::size_t j) {
  const Words active = source_.active(j), required = source_.required(j);
  const std::size_t n_active = count_bits(active);
  if (n_active == 0) return;
  stats_.entries += n_active;
  if (!required.empty()) {
    std::copy(required.begin(), required.end(), wanted_.begin());
    trace_wanted(j);
  }
  if (n_active <= kTracedWhole || trace_share(j) == 0) {
    for (std::size_t w = 0; w < active.size(); ++w) wanted_[w] = active[w] & ~traced_.column(j)[w];
    trace_wanted(j);
    ++stats_.full_columns;
  }
}

/// Traces the share of fresh samples, uniformly among the rows not traced; returns how many rows are left.
std::size_t Separation::trace_share(std::size_t j) {
  const Words active = source_.active(j);
  const auto n_active = static_cast<float>(count_bits(active));
  for (std::size_t w = 0; w < active.size(); ++w) eligible_[w] = active[w] & ~traced_.column(j)[w];
  std::fill(wanted_.begin(), wanted_.end(), 0);
  distribution_.draw_uniform(static_cast<std::size_t>(std::ceil(params_.samples * n_active)), eligible_, rng_, wanted_);
  const std::size_t n_left = count_bits(eligible_) - count_bits(wanted_);
  trace_wanted(j);
  return n_left;
}

void Separation::trace_wanted(std::size_t j) {
  const std::size_t n = count_bits(wanted_);
  if (n == 0) return;
  stats_.traced += n;
  source_.trace(j, wanted_, visible_.column(j));
  for (std::size_t w = 0; w < wanted_.size(); ++w) {
    MYRIALUX_ASSERT((traced_.column(j)[w] & wanted_[w]) == 0);  // no entry is asked for twice
    traced_.column(j)[w] |= wanted_[w];
  }
}

/// Guesses, traces fresh samples, keeps the best guess. True: the column needs no further round.
bool Separation::validate(std::size_t j, ColumnRange group) {
  guesses_.clear();
  if (predict_by_neighbours(sampled(), j, guess_)) guesses_.push_back(guess_);
  if (predict_by_plane(sampled(), j, source_.row_points(), guess_)) guesses_.push_back(guess_);
  if (predict_by_columns(sampled(), j, group, guess_)) guesses_.push_back(guess_);
  const std::size_t n_left = trace_share(j), n_fresh = count_bits(wanted_);
  const Words column = std::as_const(visible_).column(j);

  std::size_t least = n_fresh + 1;
  for (const std::vector<std::uint64_t>& guess : guesses_) {
    std::size_t n_missed = 0;
    for (std::size_t w = 0; w < column.size(); ++w)
      n_missed += static_cast<std::size_t>(std::popcount((column[w] ^ guess[w]) & wanted_[w]));
    if (n_missed >= least) continue;
    least = n_missed;
    std::copy(guess.begin(), guess.end(), guessed_.column(j).begin());
  }
  if (n_left == 0) {
    ++stats_.full_columns;
    return true;
  }
  const bool right = static_cast<float>(least) <= params_.error * static_cast<float>(n_fresh);
  stats_.verified_columns += right;
  return right;
}

void Separation::take_guesses(ColumnRange group) {
  for (std::size_t j = group.begin; j < group.end; ++j) {
    const Words active = source_.active(j), traced = std::as_const(traced_).column(j);
    for (std::size_t w = 0; w < active.size(); ++w)
      visible_.column(j)[w] |= guessed_.column(j)[w] & active[w] & ~traced[w];
  }
}

void Separation::separate(ColumnRange group) {
  const std::size_t n_rows = visible_.n_rows(), n_columns = group.end - group.begin;
  std::vector<float> d(n_rows * n_columns);
  std::vector<EntryKind> kind(d.size(), EntryKind::missing);
  for (std::size_t c = 0; c < n_columns; ++c) {
    const std::size_t j = group.begin + c;
    for_each_bit(source_.active(j), [&](std::size_t i) {
      const bool certain = traced_.test(i, j), bit = certain ? visible_.test(i, j) : guessed_.test(i, j);
      d[c * n_rows + i] = bit ? 1.0f : -1.0f;
      kind[c * n_rows + i] = certain ? EntryKind::certain : EntryKind::doubted;
    });
  }
  const RobustPca split =
      robust_pca(n_rows, n_columns, d, kind, {.lambda = params_.lambda, .max_iterations = params_.iterations});
  for (std::size_t c = 0; c < n_columns; ++c) {
    const std::size_t j = group.begin + c;
    for_each_bit(source_.active(j), [&](std::size_t i) {
      if (!traced_.test(i, j) && split.low_rank[c * n_rows + i] > 0) visible_.set(i, j);
    });
  }
}

void check_share(const char* name, float value, float low) {
  if (value >= low && value > 0 && value <= 1) return;  // false for NaN
  throw Error(ErrorKind::usage,
              std::string("separation.") + name + ": must lie in (0, 1], got " + std::to_string(value));
}

}  // namespace

CompletionStats complete_separation(EntrySource& source, const SeparationParams& params, Rng& rng, BitMatrix& visible) {
  check_share("samples", params.samples, 0);
  if (!(params.error >= 0) || !(params.energy >= 0) || !(params.lambda > 0))
    throw Error(ErrorKind::usage, "separation: error and energy must be at least 0, lambda above 0");
  MYRIALUX_ASSERT(visible.n_rows() == source.n_rows() && visible.n_columns() == source.n_columns());
  return Separation(source, params, rng, visible).run();
}

}  // namespace myrialux
