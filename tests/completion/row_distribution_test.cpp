// The distribution d against hand-computed runs, and draws from it against its probabilities.
#include "myrialux/completion/row_distribution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace myrialux {
namespace {

constexpr double kUnit = 0x1p-39;  // two roundings to the distribution's unit

std::vector<std::uint64_t> words_of(const std::string& bits) {
  std::vector<std::uint64_t> words(words_for(bits.size()));
  for (std::size_t i = 0; i < bits.size(); ++i)
    if (bits[i] == '1') set_bit(words, i);
  return words;
}
std::vector<std::uint64_t> full_words(std::size_t n) {
  std::vector<std::uint64_t> words(words_for(n));
  fill_rows(words, n);
  return words;
}

/// Standard deviations by which a chi-square statistic exceeds its mean; above 5 has a chance below 1e-4 for >= 5
/// degrees of freedom.
double chi_square_excess(const std::map<std::uint64_t, std::size_t>& seen,
                         const std::map<std::uint64_t, double>& probability, std::size_t n) {
  double statistic = 0;
  for (const auto& [key, p] : probability) {
    const double expected = p * static_cast<double>(n);
    EXPECT_GE(expected, 5.0);
    const double d = (seen.count(key) ? static_cast<double>(seen.at(key)) : 0.0) - expected;
    statistic += d * d / expected;
  }
  for (const auto& entry : seen) EXPECT_TRUE(probability.count(entry.first)) << "impossible draw " << entry.first;
  const double degrees = static_cast<double>(probability.size()) - 1;
  return (statistic - degrees) / std::sqrt(2 * degrees);
}

TEST(RowDistribution, StartsUniform) {
  RowDistribution d;
  d.reset(10);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_NEAR(d.weight(i), 0.1, kUnit);
}

TEST(RowDistribution, AddsTheBucketsOfThePapersFigure4) {
  RowDistribution d;
  d.reset(10);
  d.add_column(full_words(10), words_of("1100011100"));
  const double expected[10] = {1. / 8, 1. / 8, 1. / 12, 1. / 12, 1. / 12, 1. / 12, 1. / 12, 1. / 12, 1. / 8, 1. / 8};
  for (std::size_t i = 0; i < 10; ++i) EXPECT_NEAR(d.weight(i), 0.1 + expected[i], kUnit) << i;
}

TEST(RowDistribution, InactiveRowsNeitherEndARunNorGain) {
  RowDistribution d;
  d.reset(10);
  // Active bits in order: 1 1 1 | 0 0; inactive ones hold whatever.
  d.add_column(words_of("0101101001"), words_of("1111101000"));
  // Active rows 1 3 4 6 9 with bits 1 1 1 1 0: two runs of 4 and 1 rows.
  const double expected[10] = {0, 1. / 8, 0, 1. / 8, 1. / 8, 0, 1. / 8, 0, 0, 1. / 2};
  for (std::size_t i = 0; i < 10; ++i) EXPECT_NEAR(d.weight(i), 0.1 + expected[i], kUnit) << i;
}

/// The same by a plain loop over active rows.
std::vector<double> bucket_probabilities(Words active, Words visible, std::size_t n_rows) {
  std::vector<std::size_t> rows, run_of, run_size;
  for_each_bit(active, [&](std::size_t i) {
    if (rows.empty() || test_bit(visible, i) != test_bit(visible, rows.back())) run_size.push_back(0);
    rows.push_back(i);
    run_of.push_back(run_size.size() - 1);
    ++run_size.back();
  });
  std::vector<double> p(n_rows, 0.0);
  for (std::size_t k = 0; k < rows.size(); ++k)
    p[rows[k]] = 1.0 / static_cast<double>(run_size.size() * run_size[run_of[k]]);
  return p;
}

TEST(RowDistribution, AddsTheSameAsAPlainLoopForAnyLengthAndActiveRows) {
  Rng rng({3}, Stage::test, 0);
  for (const std::size_t n_rows : {1u, 2u, 63u, 64u, 65u, 128u, 200u, 1000u, 1024u})
    for (int round = 0; round < 20; ++round) {
      const float density = round % 3 == 0 ? 1.0f : rng.next(), change = rng.next() * 0.3f;
      std::vector<std::uint64_t> active(words_for(n_rows)), visible(active.size());
      bool bit = false;
      for (std::size_t i = 0; i < n_rows; ++i) {
        if (rng.next() < change) bit = !bit;
        if (bit) set_bit(visible, i);
        if (rng.next() < density) set_bit(active, i);
      }
      RowDistribution d;
      d.reset(n_rows);
      d.add_column(active, visible);
      const std::vector<double> p = bucket_probabilities(active, visible, n_rows);
      for (std::size_t i = 0; i < n_rows; ++i)
        ASSERT_NEAR(d.weight(i), 1.0 / static_cast<double>(n_rows) + p[i], kUnit) << n_rows << " row " << i;
    }
}

TEST(RowDistribution, SingleDrawsFollowD) {
  RowDistribution d;
  d.reset(70);
  d.add_column(full_words(70), words_of(std::string(30, '1') + "0100" + std::string(36, '1')));
  d.add_column(full_words(70), words_of(std::string(8, '0') + std::string(60, '1') + "00"));
  double total = 0;
  for (std::size_t i = 0; i < 70; ++i) total += d.weight(i);
  EXPECT_NEAR(total, 3, 1e-9);
  std::map<std::uint64_t, double> p;
  for (std::size_t i = 0; i < 70; ++i) p[i] = d.weight(i) / total;
  Rng rng({5}, Stage::test, 0);
  std::map<std::uint64_t, std::size_t> seen;
  constexpr std::size_t kDraws = 200000;
  for (std::size_t k = 0; k < kDraws; ++k) {
    std::vector<std::uint64_t> drawn(2);
    d.draw(1, full_words(70), rng, drawn);
    for_each_bit(drawn, [&](std::size_t i) { ++seen[i]; });
  }
  EXPECT_LT(chi_square_excess(seen, p, kDraws), 5);
}

/// Chance of each pair of rows drawn one after the other without replacement, key 64 * smaller + larger.
std::map<std::uint64_t, double> pair_probabilities(const std::vector<std::size_t>& rows, const std::vector<double>& w) {
  double total = 0;
  for (const double x : w) total += x;
  std::map<std::uint64_t, double> p;
  for (std::size_t a = 0; a < rows.size(); ++a)
    for (std::size_t b = 0; b < rows.size(); ++b)
      if (a != b) p[rows[std::min(a, b)] * 2048 + rows[std::max(a, b)]] += w[a] / total * w[b] / (total - w[a]);
  return p;
}

/// Four eligible rows among n_rows: with many rows all but a few draws miss, so that the rows are listed.
void check_pairs(std::size_t n_rows, bool uniform) {
  RowDistribution d;
  d.reset(n_rows);
  const std::vector<std::size_t> rows{1, 2, 4, n_rows - 1};
  std::vector<std::uint64_t> eligible(words_for(n_rows)), bits(words_for(n_rows));
  for (const std::size_t i : rows) set_bit(eligible, i);
  set_bit(bits, 2);
  d.add_column(eligible, bits);  // runs 1 | 2 | 4, last
  std::vector<double> w;
  for (const std::size_t i : rows) w.push_back(uniform ? 1 : d.weight(i));
  Rng rng({6}, Stage::test, n_rows);
  std::map<std::uint64_t, std::size_t> seen;
  constexpr std::size_t kDraws = 60000;
  for (std::size_t k = 0; k < kDraws; ++k) {
    std::vector<std::uint64_t> drawn(eligible.size());
    uniform ? d.draw_uniform(2, eligible, rng, drawn) : d.draw(2, eligible, rng, drawn);
    std::uint64_t key = 0;
    for_each_bit(drawn, [&](std::size_t i) { key = key * 2048 + i; });
    ++seen[key];
  }
  EXPECT_LT(chi_square_excess(seen, pair_probabilities(rows, w), kDraws), 5);
}
TEST(RowDistribution, PairsFollowDWithoutReplacement) { check_pairs(6, false); }
TEST(RowDistribution, PairsFollowDAmongFewEligibleRows) { check_pairs(1000, false); }
TEST(RowDistribution, UniformPairsAreEquallyLikely) { check_pairs(6, true); }
TEST(RowDistribution, UniformPairsAreEquallyLikelyAmongFewEligibleRows) { check_pairs(1000, true); }

TEST(RowDistribution, DrawsExactlyTheWantedNumberOfEligibleRows) {
  Rng rng({7}, Stage::test, 0);
  for (const std::size_t n_rows : {1u, 63u, 64u, 65u, 1000u, 1024u}) {
    RowDistribution d;
    d.reset(n_rows);
    std::vector<std::uint64_t> eligible(words_for(n_rows)), bits(eligible.size());
    for (std::size_t i = 0; i < n_rows; ++i)
      if (rng.below(3) != 0) set_bit(eligible, i);
    for (std::size_t i = 0; i < n_rows / 2; ++i) set_bit(bits, i);
    for (int k = 0; k < 5; ++k) d.add_column(eligible, bits);
    const std::size_t n = count_bits(eligible);
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, n / 2, n - n / 10, n, n + 5})
      for (const bool uniform : {false, true}) {
        std::vector<std::uint64_t> drawn(eligible.size());
        uniform ? d.draw_uniform(count, eligible, rng, drawn) : d.draw(count, eligible, rng, drawn);
        EXPECT_EQ(count_bits(drawn), std::min(count, n));
        for (std::size_t w = 0; w < drawn.size(); ++w) EXPECT_EQ(drawn[w] & ~eligible[w], 0u);
      }
  }
}

}  // namespace
}  // namespace myrialux
