// Exact properties of the completion: traced bits, counts, sample sizes, planted matrices, determinism.
#include "myrialux/completion/bamc.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "myrialux/base/error.h"
#include "support/completion_checks.h"

namespace myrialux {
namespace {

using test::all_active;
using test::all_ones;
using test::bumpy;
using test::Completed;
using test::DemandingEntries;
using test::expect_sound;
using test::half_plane;
using test::LoggingEntries;
using test::planted;
using test::random_bits;
using test::two_discs;

Completed complete(EntrySource& source, const BamcParams& params = {}, std::uint64_t seed = 1) {
  Completed c{BitMatrix(source.n_rows(), source.n_columns()), {}};
  Rng rng({seed}, Stage::visibility, 0);
  c.stats = complete_bamc(source, params, rng, c.visible);
  return c;
}
std::size_t share_of(double share, std::size_t n) {
  return static_cast<std::size_t>(std::ceil(share * double(n) - 1e-6));
}

TEST(Bamc, PlantedLowRankMatricesComeBack) {
  // A wrong copy needs 26 samples and 26 verified rows of random columns to agree: 2^-52 a pair.
  Rng rng({2}, Stage::test, 0);
  LoggingEntries source = all_active(planted(1024, 500, 6, rng));
  const Completed c = complete(source);
  expect_sound(source, c);
  EXPECT_EQ(c.visible, source.truth());
  EXPECT_EQ(c.stats.full_columns, 6u);
  EXPECT_EQ(c.stats.verified_columns, 494u);
  EXPECT_EQ(c.stats.traced, 6 * 1024u + 494 * 2 * 26u);
}

TEST(Bamc, PlantedMatricesWithDontCareEntriesComeBack) {
  Rng rng({2}, Stage::test, 1);
  const BitMatrix active = random_bits(1024, 300, rng, 0.9f);
  BitMatrix truth = planted(1024, 300, 4, rng);
  for (std::size_t j = 0; j < 300; ++j)
    for (std::size_t w = 0; w < truth.words_per_column(); ++w) truth.column(j)[w] &= active.column(j)[w];
  LoggingEntries source(truth, active);
  const Completed c = complete(source, {.alpha = 0.02f, .beta = 0.02f});
  expect_sound(source, c);
  EXPECT_EQ(c.visible, truth);
  EXPECT_LT(c.stats.traced, c.stats.entries / 2);
}

TEST(Bamc, ConstantMatricesNeedOneColumn) {
  for (const BitMatrix& truth : {BitMatrix(1000, 50), all_ones(1000, 50)}) {
    LoggingEntries source = all_active(truth);
    const Completed c = complete(source);
    expect_sound(source, c);
    EXPECT_EQ(c.visible, truth);
    EXPECT_EQ(c.stats.full_columns, 1u);
    EXPECT_EQ(c.stats.traced, 1000u + 49 * 2 * 25u) << "0.025 of 1000 rows are 25";
  }
}

TEST(Bamc, CheckerboardIsOneColumnAndItsComplement) {
  BitMatrix truth(1024, 64);
  for (std::size_t j = 0; j < 64; ++j)
    for (std::size_t i = j % 2; i < 1024; i += 2) truth.set(i, j);
  LoggingEntries source = all_active(truth);
  const Completed c = complete(source);
  expect_sound(source, c);
  EXPECT_EQ(c.visible, truth);
  EXPECT_EQ(c.stats.full_columns, 1u);
}

TEST(Bamc, OneFlippedBitIsFoundAsOftenAsItIsSampled) {
  // A column is all 0 but for one bit: uniform samples and verification see it in 52 of 1024 cases.
  // Each such column is a group with an all-0 one before it, so that Q holds nothing else.
  BitMatrix pairs(1024, 8000);
  std::vector<std::size_t> groups;
  Rng rng({3}, Stage::test, 0);
  for (std::size_t j = 1; j < 8000; j += 2) {
    pairs.set(rng.below(1024), j);
    groups.push_back(j + 1);
  }
  LoggingEntries source = all_active(pairs, groups);
  const Completed c = complete(source, {.importance = false, .adaptive = false});
  expect_sound(source, c);
  const double n_found = static_cast<double>(c.stats.full_columns - 4000), p = 52.0 / 1024;
  EXPECT_NEAR(n_found, 4000 * p, 4 * std::sqrt(4000 * p * (1 - p)));
  EXPECT_EQ(c.visible.count(), c.stats.full_columns - 4000) << "a bit found comes back, a bit missed is 0";
}

TEST(Bamc, EverythingTracedEqualsTheTruth) {
  Rng rng({4}, Stage::test, 0);
  for (const test::ShadowScene& scene : {two_discs(), bumpy(half_plane())}) {
    LoggingEntries source(scene.entries(rng));
    const Completed c = complete(source, {.alpha = 1, .beta = 0.025f, .omega = 1});
    expect_sound(source, c);
    EXPECT_EQ(c.visible, source.truth());
    EXPECT_EQ(c.stats.traced, c.stats.entries);
  }
}

TEST(Bamc, TracingAllEqualsTheTruth) {
  Rng rng({4}, Stage::test, 1);
  LoggingEntries source(bumpy(two_discs()).entries(rng));
  BitMatrix visible(source.n_rows(), source.n_columns());
  const CompletionStats stats = trace_all(source, visible);
  expect_sound(source, {visible, stats});
  EXPECT_EQ(visible, source.truth());
  EXPECT_EQ(stats.traced, stats.entries);
}

class BamcSizes : public ::testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Rows, BamcSizes, ::testing::Values(1, 15, 17, 63, 64, 65, 1000, 1024));

TEST_P(BamcSizes, TracedBitsNeverChangeAndAreAskedForOnce) {
  Rng rng({5}, Stage::test, GetParam());
  for (const float density : {1.0f, 0.7f, 0.1f, 0.0f})
    for (const bool importance : {true, false}) {
      BitMatrix truth = planted(GetParam(), 60, 5, rng), active = random_bits(GetParam(), 60, rng, density);
      for (std::size_t j = 0; j < 60; ++j) {
        if (rng.below(3) == 0) truth.set(rng.below(static_cast<std::uint32_t>(GetParam())), j);
        for (std::size_t w = 0; w < truth.words_per_column(); ++w) truth.column(j)[w] &= active.column(j)[w];
      }
      LoggingEntries source(truth, active, {7, 7, 30, 60});  // one group empty
      if (density == 0) {
        EXPECT_EQ(complete(source).stats.traced, 0u);
        EXPECT_TRUE(source.calls.empty());
        continue;
      }
      expect_sound(source, complete(source, {.importance = importance}));
    }
}

TEST(Bamc, SampleSizesStartAtAlphaGrowByBetaAndStopAtOmega) {
  // Columns that differ from each other in 2 % of the rows: verification fails often.
  Rng rng({6}, Stage::test, 0);
  BitMatrix truth = planted(1024, 400, 1, rng);
  for (std::size_t j = 0; j < 400; ++j)
    for (int k = 0; k < 20; ++k) truth.column(j)[rng.below(16)] ^= std::uint64_t{1} << rng.below(64);
  LoggingEntries source = all_active(truth, {200, 400});
  const BamcParams params{.alpha = 0.01f, .beta = 0.02f, .omega = 0.1f, .importance = false};
  const Completed c = complete(source, params);
  expect_sound(source, c);
  double alpha = 0.01;
  std::size_t n_failed = 0;
  for (std::size_t j = 0; j < 400; ++j) {
    const auto calls = source.calls_of(j);
    if (j == 0 || j == 200) {  // a group starts afresh: nothing in Q, alpha as given
      alpha = 0.01;
      ASSERT_EQ(calls.size(), 1u);
      EXPECT_EQ(calls[0].n_wanted(), 1024u);
      continue;
    }
    ASSERT_EQ(calls[0].n_wanted(), share_of(alpha, 1024)) << "column " << j;
    if (calls.size() == 1 || calls[1].n_wanted() > 512) continue;  // no match: alpha stays
    ASSERT_EQ(calls[1].n_wanted(), share_of(0.02, 1024)) << "column " << j;
    if (calls.size() == 3) alpha = std::min(alpha + 0.02, 0.1), ++n_failed;
  }
  EXPECT_GT(n_failed, 5u);
  EXPECT_NEAR(alpha, 0.1, 1e-9) << "omega reached in the second group";
}

TEST(Bamc, FixedRatesStayFixed) {
  Rng rng({6}, Stage::test, 1);
  LoggingEntries source(two_discs().entries(rng));
  complete(source, {.adaptive = false});
  for (std::size_t j = 1; j < source.n_columns(); ++j) EXPECT_EQ(source.calls_of(j)[0].n_wanted(), 26u);
}

TEST(Bamc, VerificationLooksAtOtherRowsThanTheSamples) {
  Rng rng({7}, Stage::test, 0);
  LoggingEntries source(half_plane().entries(rng));
  complete(source, {.alpha = 0.4f, .beta = 0.4f, .omega = 0.4f});
  std::size_t n_verified = 0;
  for (std::size_t j = 0; j < source.n_columns(); ++j) {
    const auto calls = source.calls_of(j);
    if (calls.size() < 2) continue;
    ++n_verified;
    for (std::size_t w = 0; w < 16; ++w) EXPECT_EQ(calls[0].wanted[w] & calls[1].wanted[w], 0u);
  }
  EXPECT_GT(n_verified, 20u);
}

TEST(Bamc, SeveralMatchesAreChosenFromAtRandom) {
  std::size_t n_first = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    BitMatrix truth(400, 3);
    for (std::size_t i = 200; i < 400; ++i) truth.set(i, 1);
    for (std::size_t i = 200; i < 400; ++i) truth.set(i, 2);
    LoggingEntries source = all_active(truth);
    Rng rng({seed}, Stage::visibility, 0);
    BitMatrix visible(400, 3);
    // One sample cannot tell the all-0 column from the half one: each matches, as it is or complemented.
    const CompletionStats stats =
        complete_bamc(source, {.alpha = 0.002f, .beta = 0.002f, .importance = false, .adaptive = false}, rng, visible);
    if (stats.full_columns == 2) n_first += visible.column(2)[0] == truth.column(2)[0];
  }
  EXPECT_GT(n_first, 40u);
  EXPECT_LT(n_first, 360u);
}

TEST(Bamc, SameSeedSameBitsOtherSeedOtherBits) {
  Rng rng({8}, Stage::test, 0);
  const KnownEntries known = bumpy(two_discs()).entries(rng);
  LoggingEntries a(known), b(known), d(known);
  EXPECT_EQ(complete(a, {}, 1).visible, complete(b, {}, 1).visible);
  complete(d, {}, 2);
  EXPECT_EQ(a.asked(), b.asked());
  EXPECT_NE(a.asked(), d.asked());
}

TEST(Bamc, GroupsShareNoColumns) {
  Rng rng({9}, Stage::test, 0);
  const BitMatrix half = planted(1024, 40, 3, rng);
  BitMatrix truth(1024, 80);
  for (std::size_t j = 0; j < 80; ++j)
    for (std::size_t w = 0; w < 16; ++w) truth.column(j)[w] = half.column(j % 40)[w];
  LoggingEntries one = all_active(truth), two = all_active(truth, {40, 80});
  EXPECT_EQ(complete(one).stats.full_columns, 3u);
  EXPECT_EQ(complete(two).stats.full_columns, 6u) << "columns of the first group are not matched in the second";
}

TEST(Bamc, RequiredEntriesAreTracedFirstAndOnce) {
  Rng rng({12}, Stage::test, 0);
  DemandingEntries source(bumpy(two_discs()).entries(rng));
  const Completed c = complete(source);
  expect_sound(source, c);
  for (std::size_t j = 0; j < source.n_columns(); ++j) {
    const auto calls = source.calls_of(j);
    if (count_bits(source.required(j)) == 0) continue;
    ASSERT_FALSE(calls.empty());
    EXPECT_TRUE(std::equal(calls[0].wanted.begin(), calls[0].wanted.end(), source.required(j).begin())) << j;
  }
  EXPECT_LT(c.stats.traced, c.stats.entries);
}

TEST(Bamc, ARequiredEntryThatDisagreesForbidsTheCopy) {
  // Two columns equal but for row 500, which one sample in forty would see: required, it is always right.
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    BitMatrix truth(1024, 2);
    for (std::size_t i = 0; i < 512; ++i) truth.set(i, 0), truth.set(i, 1);
    clear_bit(truth.column(1), 500);
    class Entries : public KnownEntries {
     public:
      explicit Entries(const BitMatrix& t) : KnownEntries(t, all_ones(1024, 2)), row_(16) { set_bit(row_, 500); }
      Words required(std::size_t) const override { return row_; }

     private:
      std::vector<std::uint64_t> row_;
    } source(truth);
    EXPECT_EQ(complete(source, {}, seed).visible, truth);
  }
}

TEST(Bamc, MatricesWithoutRowsOrColumnsAreFine) {
  for (const auto& [rows, columns] : {std::pair<std::size_t, std::size_t>{0, 5}, {5, 0}, {0, 0}}) {
    LoggingEntries source = all_active(BitMatrix(rows, columns));
    EXPECT_EQ(complete(source).stats.entries, 0u);
  }
}

TEST(Bamc, RefusesSharesOutsideTheirRange) {
  LoggingEntries source = all_active(BitMatrix(64, 2));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const BamcParams& bad : {BamcParams{.alpha = 0},
                                {.alpha = 1.5f},
                                {.alpha = nan},
                                {.beta = -0.1f},
                                {.beta = 2},
                                {.omega = 0},
                                {.omega = nan}}) {
    try {
      complete(source, bad);
      FAIL() << "accepted";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::usage);
      EXPECT_NE(std::string(e.what()).find("must lie in"), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace myrialux
