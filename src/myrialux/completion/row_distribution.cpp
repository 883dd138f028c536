// Runs of equal bits become weights; rows are drawn without replacement by rejection. [wang20, 4.5.2]
#include "myrialux/completion/row_distribution.h"

#include <algorithm>

namespace myrialux {
namespace {

constexpr std::uint64_t kOne = std::uint64_t{1} << 40;  ///< weight 1

/// Copies to each inactive bit the nearest active bit below it; `carry` (all 0 or all 1) stands below bit 0.
std::uint64_t fill_inactive(std::uint64_t active, std::uint64_t visible, std::uint64_t carry) {
  std::uint64_t ones = visible & active, through = ~active;
  ones |= through & carry & 1;
  for (int shift = 1; shift < 64; shift *= 2) {  // parallel prefix: ones spread upwards through inactive places
    ones |= through & (ones << shift);
    through &= through << shift;
  }
  return ones;
}

/// All of `eligible` is to be drawn: nothing to choose.
bool drew_all(std::size_t count, std::size_t n_eligible, Words eligible, MutableWords drawn) {
  if (count < n_eligible) return false;
  std::copy(eligible.begin(), eligible.end(), drawn.begin());
  return true;
}

/// Listing the rows left costs about as much as an eighth as many misses.
bool list_pays(std::size_t n_missed, std::size_t n_eligible) { return 8 * n_missed > n_eligible; }

}  // namespace

void RowDistribution::reset(std::size_t n_rows) {
  weights_.assign(n_rows, n_rows > 0 ? kOne / n_rows : 0);
  rows_.resize(n_rows);
  filled_.resize(words_for(n_rows));
  clean_ = false;
}

void RowDistribution::add_column(Words active, Words visible) {
  std::size_t first = 0;  // word of the first active row
  while (first < active.size() && active[first] == 0) ++first;
  if (first == active.size()) return;
  clean_ = false;

  // Inactive rows take over the bit below them (the first ones: of the first active row), so that runs span them.
  const bool first_bit = (visible[first] >> std::countr_zero(active[first])) & 1;
  std::uint64_t carry = first_bit ? ~std::uint64_t{0} : 0;
  std::uint64_t below_word = carry & 1;
  std::size_t n_runs = 1;
  for (std::size_t w = 0; w < active.size(); ++w) {
    filled_[w] = fill_inactive(active[w], visible[w], carry);
    n_runs += static_cast<std::size_t>(std::popcount(filled_[w] ^ (filled_[w] << 1 | below_word)));
    below_word = filled_[w] >> 63;
    carry = below_word ? ~std::uint64_t{0} : 0;
  }

  // Each run shares out 1 / n_runs among its active rows.
  std::size_t begin = 0, n_in_run = 0;
  below_word = first_bit;
  for (std::size_t w = 0; w < active.size(); ++w) {
    std::uint64_t edges = filled_[w] ^ (filled_[w] << 1 | below_word);
    below_word = filled_[w] >> 63;
    std::uint64_t unseen = active[w];
    for (; edges != 0; edges &= edges - 1) {
      const std::size_t bit = static_cast<std::size_t>(std::countr_zero(edges));
      n_in_run += static_cast<std::size_t>(std::popcount(unseen & low_bits(bit)));
      add_to_rows(begin, w * 64 + bit, active, kOne / (n_runs * n_in_run));
      begin = w * 64 + bit;
      n_in_run = 0;
      unseen &= ~low_bits(bit);
    }
    n_in_run += static_cast<std::size_t>(std::popcount(unseen));
  }
  add_to_rows(begin, weights_.size(), active, kOne / (n_runs * n_in_run));
}

void RowDistribution::add_to_rows(std::size_t begin, std::size_t end, Words active, std::uint64_t amount) {
  for (std::size_t i = begin; i < end;) {
    const std::size_t stop = std::min(end, (i / 64 + 1) * 64);
    const std::uint64_t word = active[i / 64] >> (i % 64);
    if ((~word & low_bits(stop - i)) == 0) {
      for (; i < stop; ++i) weights_[i] += amount;
    } else {
      for (std::size_t bit = 0; i < stop; ++i, ++bit) weights_[i] += amount & (0 - (word >> bit & 1));
    }
  }
}

void RowDistribution::draw(std::size_t count, Words eligible, Rng& rng, MutableWords drawn) {
  const std::size_t n_eligible = count_bits(eligible);
  if (drew_all(count, n_eligible, eligible, drawn)) return;
  if (!clean_) sums_.build(weights_.size(), [&](std::size_t i) { return weights_[i]; });
  clean_ = true;

  // A row that may not be taken is rejected: what is left then follows d among the rows left. Whether rows were
  // listed anew does not depend on the draw to come, so it changes nothing in their probabilities.
  bool listed = false;
  for (std::size_t n_drawn = 0, n_missed = 0; n_drawn < count;) {
    const std::size_t i = listed ? rows_[listed_sums_.draw(rng)] : sums_.draw(rng);
    if (test_bit(eligible, i) && !test_bit(drawn, i)) {
      set_bit(drawn, i);
      ++n_drawn;
    } else if (list_pays(++n_missed, n_eligible)) {
      list_rows(eligible, drawn);
      listed_sums_.build(rows_.size(), [&](std::size_t k) { return weights_[rows_[k]]; });
      listed = true;
      n_missed = 0;
    }
  }
}

void RowDistribution::draw_uniform(std::size_t count, Words eligible, Rng& rng, MutableWords drawn) {
  const std::size_t n_eligible = count_bits(eligible);
  if (drew_all(count, n_eligible, eligible, drawn)) return;
  bool listed = false;
  std::size_t n = weights_.size();
  for (std::size_t n_drawn = 0, n_missed = 0; n_drawn < count;) {
    const std::size_t k = rng.below(static_cast<std::uint32_t>(n));
    const std::size_t i = listed ? rows_[k] : k;
    if (test_bit(eligible, i) && !test_bit(drawn, i)) {
      set_bit(drawn, i);
      ++n_drawn;
    } else if (list_pays(++n_missed, n_eligible)) {
      list_rows(eligible, drawn);
      n = rows_.size();
      listed = true;
      n_missed = 0;
    }
  }
}

void RowDistribution::list_rows(Words eligible, Words drawn) {
  rows_.clear();  // keeps its memory
  for (std::size_t w = 0; w < eligible.size(); ++w)
    for (std::uint64_t left = eligible[w] & ~drawn[w]; left != 0; left &= left - 1)
      rows_.push_back(static_cast<std::uint32_t>(w * 64 + static_cast<std::size_t>(std::countr_zero(left))));
}

}  // namespace myrialux
