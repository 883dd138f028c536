// Low rank plus sparse comes back; guesses do what they say; samples stay in their budget.
#include "myrialux/completion/matrix_separation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "myrialux/base/error.h"
#include "myrialux/completion/entry_predictors.h"
#include "support/completion_checks.h"

namespace myrialux {
namespace {

using test::all_active;
using test::Completed;
using test::count_wrong;
using test::expect_sound;
using test::LoggingEntries;

Completed separate(EntrySource& source, const SeparationParams& params = {}) {
  Completed c{BitMatrix(source.n_rows(), source.n_columns()), {}};
  Rng rng({1}, Stage::visibility, 0);
  c.stats = complete_separation(source, params, rng, c.visible);
  return c;
}

struct Planted {
  std::size_t n_rows, n_columns;
  std::vector<float> low_rank, d;
  std::vector<EntryKind> kind;
};
/// Products of normal-ish factors; a share of the entries is off by up to 10 times their size, some are missing.
Planted plant(std::size_t n_rows, std::size_t n_columns, std::size_t rank, float sparse, float missing) {
  Rng rng({1}, Stage::test, rank);
  const auto normal = [&] { return (rng.next() + rng.next() + rng.next() + rng.next() - 2) * 1.732f; };
  std::vector<float> u(n_rows * rank), v(n_columns * rank);
  for (float& x : u) x = normal();
  for (float& x : v) x = normal();
  Planted p{n_rows, n_columns, std::vector<float>(n_rows * n_columns), {}, {}};
  for (std::size_t j = 0; j < n_columns; ++j)
    for (std::size_t i = 0; i < n_rows; ++i)
      for (std::size_t k = 0; k < rank; ++k) p.low_rank[j * n_rows + i] += u[k * n_rows + i] * v[k * n_columns + j];
  p.d = p.low_rank;
  p.kind.assign(p.d.size(), EntryKind::doubted);
  for (std::size_t k = 0; k < p.d.size(); ++k) {
    if (rng.next() < sparse) p.d[k] += (rng.next() - 0.5f) * 20 * std::sqrt(static_cast<float>(rank));
    if (rng.next() < missing) p.d[k] = std::nanf(""), p.kind[k] = EntryKind::missing;
  }
  return p;
}
double relative_error(const Planted& p, const RobustPca& split) {
  double error = 0, norm = 0;
  for (std::size_t k = 0; k < p.d.size(); ++k) {
    const double e = split.low_rank[k] - p.low_rank[k];
    error += e * e, norm += double{p.low_rank[k]} * p.low_rank[k];
  }
  return std::sqrt(error / norm);
}

TEST(RobustPca, PlantedLowRankPlusSparseComesBack) {
  // Rank and share of errors within what [candes11, theorem 1.1] and its experiments allow.
  for (const auto& [rows, columns, rank, sparse] :
       {std::tuple{200, 200, 10, 0.05f}, {200, 200, 5, 0.15f}, {300, 80, 4, 0.05f}, {64, 65, 1, 0.05f}}) {
    const Planted p = plant(std::size_t(rows), std::size_t(columns), std::size_t(rank), sparse, 0);
    const RobustPca split = robust_pca(p.n_rows, p.n_columns, p.d, {}, {});
    EXPECT_TRUE(split.converged);
    EXPECT_EQ(split.rank, std::size_t(rank));
    EXPECT_LT(relative_error(p, split), 5e-4) << rows << " x " << columns << ", tolerance 1e-4";
  }
}

TEST(RobustPca, MissingEntriesAreFilledIn) {
  const Planted p = plant(200, 200, 5, 0.05f, 0.4f);
  const RobustPca split = robust_pca(200, 200, p.d, p.kind, {});
  EXPECT_EQ(split.rank, 5u);
  EXPECT_LT(relative_error(p, split), 1e-3);
}

TEST(RobustPca, CertainEntriesAreKept) {
  // All certain, and of full rank: nothing may be taken for an error.
  Planted p = plant(40, 30, 30, 0, 0);
  p.kind.assign(p.d.size(), EntryKind::certain);
  const RobustPca split = robust_pca(40, 30, p.d, p.kind, {.tolerance = 1e-5f, .max_iterations = 200});
  EXPECT_TRUE(split.converged);
  EXPECT_LT(relative_error(p, split), 1e-4);
}

TEST(RobustPca, DegenerateMatricesAreFine) {
  EXPECT_TRUE(robust_pca(0, 0, {}, {}, {}).low_rank.empty());
  const std::vector<float> zeros(50), ones(50, 1.0f);
  EXPECT_EQ(robust_pca(10, 5, zeros, {}, {}).low_rank, zeros);
  const RobustPca split = robust_pca(5, 10, ones, std::vector<EntryKind>(50, EntryKind::certain), {});
  EXPECT_EQ(split.rank, 1u);
  for (const float x : split.low_rank) EXPECT_NEAR(x, 1, 1e-3);
}

/// Four patterns of four long runs each; every column is one of them or its complement.
BitMatrix runs(std::size_t n_columns, Rng& rng) {
  BitMatrix patterns(1024, 4), truth(1024, n_columns);
  for (std::size_t q = 0; q < 4; ++q)
    for (std::size_t i = 0; i < 1024; ++i)
      if ((i + 57 * q) / 256 % 2 == 0) patterns.set(i, q);
  for (std::size_t j = 0; j < n_columns; ++j) {
    const std::size_t q = rng.below(4);
    const bool turn = rng.below(2) == 1;
    for (std::size_t i = 0; i < 1024; ++i)
      if (patterns.test(i, q) != turn) truth.set(i, j);
  }
  return truth;
}

TEST(MatrixSeparation, WrongGuessesOfALowRankMatrixAreMended) {
  Rng rng({3}, Stage::test, 0);
  const BitMatrix truth = runs(200, rng);
  LoggingEntries guessed = all_active(truth), split = all_active(truth);
  const Completed guesses = separate(guessed, {.separate = false}), c = separate(split);
  expect_sound(split, c);
  EXPECT_EQ(split.asked(), guessed.asked()) << "separation asks for nothing";
  EXPECT_GT(count_wrong(guessed, guesses.visible).rate(), 0.01) << "or there is nothing to mend";
  EXPECT_EQ(c.visible, truth);
  // 5 % at first, 5 % to validate, and a second round for some.
  EXPECT_LT(c.stats.traced, c.stats.entries * 13 / 100);
}

TEST(MatrixSeparation, SamplesStayInTheirBudget) {
  Rng rng({4}, Stage::test, 0);
  LoggingEntries source = all_active(test::random_bits(1000, 20, rng));  // cannot be guessed: all rounds are used up
  const Completed c = separate(source, {.samples = 0.04f, .error = 0.1f, .rounds = 3});
  expect_sound(source, c);
  EXPECT_EQ(c.stats.traced, 20 * 4 * 40u);
  for (std::size_t j = 0; j < 20; ++j)
    for (const auto& call : source.calls_of(j)) EXPECT_EQ(call.n_wanted(), 40u);
  EXPECT_EQ(c.stats.verified_columns, 0u);
}

TEST(MatrixSeparation, ColumnsOfLittleEnergyAreNotValidated) {
  class Entries : public LoggingEntries {
   public:
    using LoggingEntries::LoggingEntries;
    float energy(std::size_t j) const override { return j % 2 == 0 ? 1.0f : 0.001f; }
  };
  Rng rng({5}, Stage::test, 0);
  Entries source(runs(40, rng), test::all_ones(1024, 40));
  expect_sound(source, separate(source, {.energy = 0.01f}));
  for (std::size_t j = 0; j < 40; ++j) {
    if (j % 2 == 0)
      EXPECT_GE(source.calls_of(j).size(), 2u);
    else
      EXPECT_EQ(source.calls_of(j).size(), 1u);
  }
}

TEST(MatrixSeparation, AStricterValidationLeavesFewerErrors) {
  Rng rng({6}, Stage::test, 0);
  const KnownEntries known = test::two_discs().entries(rng);
  LoggingEntries loose(known), strict(known);
  const Completed a = separate(loose, {.error = 0.2f, .separate = false});
  const Completed b = separate(strict, {.error = 0.02f, .separate = false});
  EXPECT_LT(count_wrong(known, b.visible).rate(), 0.7 * count_wrong(known, a.visible).rate());
  EXPECT_GT(b.stats.traced, a.stats.traced);
}

struct Guess {
  BitMatrix visible, traced, bits;
};
/// A column with a sample in every fourth row.
Guess sampled_column(const BitMatrix& truth) {
  Guess g{BitMatrix(truth.n_rows(), truth.n_columns()), BitMatrix(truth.n_rows(), truth.n_columns()),
          BitMatrix(truth.n_rows(), 1)};
  for (std::size_t j = 0; j < truth.n_columns(); ++j)
    for (std::size_t i = 0; i < truth.n_rows(); i += 4) {
      g.traced.set(i, j);
      if (truth.test(i, j)) g.visible.set(i, j);
    }
  return g;
}

TEST(EntryPredictors, NeighboursFollowLongRuns) {
  BitMatrix truth(200, 1);
  for (std::size_t i = 60; i < 140; ++i) truth.set(i, 0);
  Guess g = sampled_column(truth);
  ASSERT_TRUE(predict_by_neighbours({g.visible, g.traced}, 0, g.bits.column(0)));
  for (std::size_t i = 0; i < 200; ++i)
    if (std::abs(int(i) - 60) > 6 && std::abs(int(i) - 140) > 6) {
      EXPECT_EQ(g.bits.test(i, 0), truth.test(i, 0)) << i;
    }
}

TEST(EntryPredictors, NeighboursAreTheThreeNearestSamples) {
  Rng rng({7}, Stage::test, 0);
  const BitMatrix truth = test::random_bits(130, 1, rng), traced = test::random_bits(130, 1, rng, 0.2f);
  BitMatrix visible(130, 1), bits(130, 1);
  std::vector<std::size_t> rows;
  for_each_bit(traced.column(0), [&](std::size_t i) {
    rows.push_back(i);
    if (truth.test(i, 0)) visible.set(i, 0);
  });
  ASSERT_TRUE(predict_by_neighbours({visible, traced}, 0, bits.column(0)));
  const auto distance = [](std::size_t a, std::size_t b) { return a > b ? a - b : b - a; };
  for (std::size_t i = 0; i < 130; ++i) {
    std::vector<std::size_t> near = rows;
    std::sort(near.begin(), near.end(), [&](std::size_t a, std::size_t b) { return distance(a, i) < distance(b, i); });
    if (distance(near[2], i) == distance(near[3], i)) continue;  // either may be the third
    const int n = visible.test(near[0], 0) + visible.test(near[1], 0) + visible.test(near[2], 0);
    EXPECT_EQ(bits.test(i, 0), n >= 2) << i;
  }
}

TEST(EntryPredictors, APlaneSeparatesHalves) {
  // Rows at random places of a square; those beyond a slanted line are visible.
  Rng rng({8}, Stage::test, 0);
  std::vector<RowPoint> points(400);
  BitMatrix truth(400, 1);
  for (std::size_t i = 0; i < 400; ++i) {
    points[i] = {100 + rng.next(), rng.next(), 7};
    if (points[i][0] - 100 + 0.5f * points[i][1] > 0.75f) truth.set(i, 0);
  }
  Guess g = sampled_column(truth);
  ASSERT_TRUE(predict_by_plane({g.visible, g.traced}, 0, points, g.bits.column(0)));
  std::size_t n_wrong = 0;
  for (std::size_t i = 0; i < 400; ++i) n_wrong += g.bits.test(i, 0) != truth.test(i, 0);
  EXPECT_LT(n_wrong, 20u);
  EXPECT_FALSE(predict_by_plane({g.visible, g.traced}, 0, {}, g.bits.column(0))) << "no points, no plane";
}

TEST(EntryPredictors, ColumnsBesideTellOfABlock) {
  // Blocks 2 and 3 of 16 rows are occluded in all columns.
  BitMatrix truth = test::all_ones(128, 8);
  for (std::size_t j = 0; j < 8; ++j)
    for (std::size_t i = 32; i < 64; ++i) clear_bit(truth.column(j), i);
  Guess g = sampled_column(truth);
  ASSERT_TRUE(predict_by_columns({g.visible, g.traced}, 4, {0, 8}, g.bits.column(0)));
  for (std::size_t i = 0; i < 128; ++i) EXPECT_EQ(g.bits.test(i, 0), truth.test(i, 4)) << i;
}

TEST(EntryPredictors, WithoutSamplesThereIsNoGuess) {
  const BitMatrix none(64, 1);
  BitMatrix bits(64, 1);
  const std::vector<RowPoint> points(64);
  EXPECT_FALSE(predict_by_neighbours({none, none}, 0, bits.column(0)));
  EXPECT_FALSE(predict_by_plane({none, none}, 0, points, bits.column(0)));
  EXPECT_FALSE(predict_by_columns({none, none}, 0, {0, 1}, bits.column(0)));
}

TEST(MatrixSeparation, RefusesNonsense) {
  LoggingEntries source = all_active(BitMatrix(64, 2));
  for (const SeparationParams& bad : {SeparationParams{.error = -1}, {.energy = -1}, {.lambda = 0}})
    EXPECT_THROW(separate(source, bad), Error);
}

}  // namespace
}  // namespace myrialux
