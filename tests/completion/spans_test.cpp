// amc and gauss-jordan: planted sums of few columns come back from as many traced columns as the rank says.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "myrialux/base/error.h"
#include "myrialux/completion/amc.h"
#include "myrialux/completion/bamc.h"
#include "myrialux/completion/gauss_jordan.h"
#include "myrialux/completion/projection.h"
#include "support/completion_checks.h"

namespace myrialux {
namespace {

using test::all_active;
using test::Completed;
using test::expect_sound;
using test::LoggingEntries;

template <class Complete>
Completed run(EntrySource& source, Complete&& complete, std::uint64_t seed = 1) {
  Completed c{BitMatrix(source.n_rows(), source.n_columns()), {}};
  Rng rng({seed}, Stage::visibility, 0);
  c.stats = complete(source, rng, c.visible);
  return c;
}
Completed amc(EntrySource& source, const AmcParams& params = {}, std::uint64_t seed = 1) {
  return run(
      source, [&](auto& s, auto& r, auto& v) { return complete_amc(s, params, r, v); }, seed);
}
Completed gauss_jordan(EntrySource& source, const RowRates& params = {}, std::uint64_t seed = 1) {
  return run(
      source, [&](auto& s, auto& r, auto& v) { return complete_gauss_jordan(s, params, r, v); }, seed);
}
Completed bamc(EntrySource& source, const RowRates& params = {}) {
  return run(source, [&](auto& s, auto& r, auto& v) { return complete_bamc(s, params, r, v); });
}

/// Columns are sums over GF(2) of random subsets of `basis`.
BitMatrix sums(const BitMatrix& basis, std::size_t n_columns, Rng& rng) {
  BitMatrix m(basis.n_rows(), n_columns);
  for (std::size_t j = 0; j < n_columns; ++j)
    for (std::size_t q = 0; q < basis.n_columns(); ++q)
      if (rng.below(2) == 1)
        for (std::size_t w = 0; w < m.words_per_column(); ++w) m.column(j)[w] ^= basis.column(q)[w];
  return m;
}

/// Each row belongs to one of n columns: their sums are bits over the reals, too.
BitMatrix partition(std::size_t n_rows, std::size_t n, Rng& rng) {
  BitMatrix m(n_rows, n);
  for (std::size_t i = 0; i < n_rows; ++i) m.set(i, rng.below(static_cast<std::uint32_t>(n)));
  return m;
}

TEST(GaussJordan, SumsOverGf2ComeBackFromAsManyColumnsAsTheRank) {
  // A column outside the span passes 26 samples and 26 checks with probability 2^-44 at most.
  Rng rng({2}, Stage::test, 0);
  LoggingEntries source = all_active(sums(test::random_bits(1024, 8, rng), 500, rng));
  const Completed c = gauss_jordan(source);
  expect_sound(source, c);
  EXPECT_EQ(c.visible, source.truth());
  EXPECT_EQ(c.stats.full_columns, 8u);
  EXPECT_EQ(c.stats.traced, 8 * 1024u + 492 * 2 * 26u);
  EXPECT_GT(bamc(source).stats.full_columns, 100u) << "sums of several columns match no single one";
}

TEST(Amc, SumsOverTheRealsComeBackFromAsManyColumnsAsTheRank) {
  Rng rng({2}, Stage::test, 1);
  LoggingEntries source = all_active(sums(partition(1024, 8, rng), 500, rng));
  for (const bool resample : {true, false}) {
    LoggingEntries entries(source);
    const Completed c = amc(entries, {.rows = {.alpha = 0.1f, .resample = resample}});
    expect_sound(entries, c);
    EXPECT_EQ(c.visible, source.truth());
    EXPECT_EQ(c.stats.full_columns, 8u);
    EXPECT_EQ(c.stats.traced, 8 * 1024u + 492 * (103 + 26u));
  }
}

TEST(Amc, Algorithm1ToTheLetterKeepsItsRowsBetweenFullColumns) {
  Rng rng({2}, Stage::test, 2);
  LoggingEntries source = all_active(sums(partition(1024, 6, rng), 200, rng));
  const Completed c =
      amc(source, {.rows = {.alpha = 0.1f, .beta = 0, .importance = false, .adaptive = false, .resample = false}});
  expect_sound(source, c);
  EXPECT_EQ(c.visible, source.truth());
  std::size_t n_changes = 0;
  for (std::size_t j = 1; j < 200; ++j) {
    const auto before = source.calls_of(j - 1), calls = source.calls_of(j);
    ASSERT_EQ(calls[0].n_wanted(), 103u);
    if (calls[0].wanted == before[0].wanted) continue;
    ++n_changes;
    EXPECT_EQ(before.size(), 2u) << "rows are drawn anew after a column traced whole, and only then; column " << j;
  }
  EXPECT_EQ(n_changes, c.stats.full_columns);
}

TEST(Spans, SumsWithDontCareEntriesComeBack) {
  Rng rng({3}, Stage::test, 0);
  const BitMatrix active = test::random_bits(1024, 200, rng, 0.97f);
  LoggingEntries gf2 = test::masked(sums(test::random_bits(1024, 4, rng), 200, rng), active);
  LoggingEntries reals = test::masked(sums(partition(1024, 4, rng), 200, rng), active);
  const Completed a = gauss_jordan(gf2, {.alpha = 0.02f, .beta = 0.02f}), b = amc(reals);
  expect_sound(gf2, a);
  expect_sound(reals, b);
  EXPECT_EQ(a.visible, gf2.truth());
  EXPECT_EQ(b.visible, reals.truth());
  EXPECT_LT(a.stats.traced, a.stats.entries * 7 / 10);
  EXPECT_LT(b.stats.traced, b.stats.entries * 7 / 10);
}

TEST(Spans, ColumnsOfZerosNeedNoBasis) {
  const BitMatrix zeros(1024, 30);
  for (const bool real : {true, false}) {
    LoggingEntries source = all_active(zeros);
    const Completed c = real ? amc(source) : gauss_jordan(source);
    EXPECT_EQ(c.visible, zeros);
    EXPECT_EQ(c.stats.full_columns, 0u);
    EXPECT_EQ(c.stats.traced, 30 * 2 * 26u);
  }
}

TEST(Amc, ToleranceAdmitsColumnsNearTheSpan) {
  // Columns that differ from each other in single rows: a residual of up to 1 a sample passes a large tolerance only.
  Rng rng({4}, Stage::test, 0);
  BitMatrix truth(1024, 100);
  for (std::size_t j = 0; j < 100; ++j) {
    for (std::size_t i = 0; i < 512; ++i) truth.set(i, j);
    truth.column(j)[rng.below(16)] ^= 0xffull << rng.below(56);
  }
  LoggingEntries strict = all_active(truth), lax = all_active(truth);
  const AmcParams fixed{.rows = {.alpha = 0.1f, .beta = 0, .adaptive = false}};
  AmcParams wide = fixed;
  wide.tolerance = 1;
  const std::uint64_t n_strict = amc(strict, fixed).stats.full_columns;
  const Completed c = amc(lax, wide);
  expect_sound(lax, c);
  EXPECT_LT(c.stats.full_columns, n_strict);
  EXPECT_THROW(amc(lax, {.tolerance = -1}), Error);
}

TEST(BitProjection, EqualsThePseudoInverseBySvd) {
  Rng rng({5}, Stage::test, 0);
  for (const auto& [m, n] : {std::pair<std::size_t, std::size_t>{1, 1}, {5, 3}, {26, 40}, {65, 20}, {30, 30}, {100, 7}})
    for (int round = 0; round < 20; ++round) {
      // Few distinct rows and columns, as in shadows, so that there is something to merge.
      const BitMatrix few = test::random_bits(7, 5, rng);
      BitMatrix a(m, n), x(m, 1);
      std::vector<std::size_t> row(m), column(n);
      for (auto& r : row) r = rng.below(7);
      for (auto& c : column) c = rng.below(5);
      Eigen::MatrixXd dense(m, n);
      Eigen::VectorXd right(m);
      for (std::size_t i = 0; i < m; ++i) {
        for (std::size_t j = 0; j < n; ++j) {
          const bool bit = few.test(row[i], column[j]) != (round % 4 == 0 && rng.below(9) == 0);
          if (bit) a.set(i, j);
          dense(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = bit;
        }
        if (rng.below(2) == 1) x.set(i, 0);
        right[static_cast<Eigen::Index>(i)] = x.test(i, 0);
      }
      Eigen::JacobiSVD<Eigen::MatrixXd> svd(dense, Eigen::ComputeThinU | Eigen::ComputeThinV);
      svd.setThreshold(1e-10);
      const Eigen::VectorXd expected = svd.solve(right);
      std::vector<std::uint64_t> packed;
      for (std::size_t j = 0; j < n; ++j) packed.insert(packed.end(), a.column(j).begin(), a.column(j).end());
      BitProjection projection;
      const std::vector<double>& c = projection.solve(m, n, packed, std::as_const(x).column(0));
      for (std::size_t j = 0; j < n; ++j)
        EXPECT_NEAR(c[j], expected[static_cast<Eigen::Index>(j)], 1e-9) << m << " x " << n << ", coefficient " << j;
    }
}

}  // namespace
}  // namespace myrialux
