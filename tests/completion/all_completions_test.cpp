// What every completion must do: keep traced bits, ask once, ask nothing that does not matter, repeat itself.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "myrialux/base/error.h"
#include "myrialux/completion/amc.h"
#include "myrialux/completion/bamc.h"
#include "myrialux/completion/gauss_jordan.h"
#include "myrialux/completion/localized.h"
#include "myrialux/completion/matrix_separation.h"
#include "support/completion_checks.h"

namespace myrialux {
namespace {

using test::all_active;
using test::Completed;
using test::expect_sound;
using test::LoggingEntries;

/// A completion at its defaults, and one that samples a given share of the rows.
struct Method {
  std::string name;
  std::function<CompletionStats(EntrySource&, float share, Rng&, BitMatrix&)> run;
  bool takes_shares = true;  ///< false: counts
};
constexpr float kDefault = -1;

RowRates rates(float share) {
  RowRates r;
  if (share != kDefault) r.alpha = share, r.omega = std::max(share, r.omega);
  return r;
}
const std::vector<Method>& methods() {
  static const std::vector<Method> all = {
      {"bamc", [](auto& s, float x, auto& r, auto& v) { return complete_bamc(s, rates(x), r, v); }},
      {"amc", [](auto& s, float x, auto& r, auto& v) { return complete_amc(s, {.rows = rates(x)}, r, v); }},
      {"amc_uniform",
       [](auto& s, float x, auto& r, auto& v) {
         AmcParams p{.rows = rates(x)};
         p.rows.importance = p.rows.adaptive = p.rows.resample = false;
         p.rows.beta = 0;
         return complete_amc(s, p, r, v);
       }},
      {"gauss_jordan", [](auto& s, float x, auto& r, auto& v) { return complete_gauss_jordan(s, rates(x), r, v); }},
      {"matrix_separation",
       [](auto& s, float x, auto& r, auto& v) {
         SeparationParams p;
         if (x != kDefault) p.samples = x;
         return complete_separation(s, p, r, v);
       }},
      {"localized",
       [](auto& s, float x, auto& r, auto& v) {
         LocalizedParams p;
         if (x == 1) p.few = static_cast<std::uint32_t>(s.n_rows());  // whole columns: it never samples all rows
         return complete_localized(s, p, r, v);
       },
       false},
      {"matrix_separation_guesses",
       [](auto& s, float x, auto& r, auto& v) {
         SeparationParams p{.separate = false};
         if (x != kDefault) p.samples = x;
         return complete_separation(s, p, r, v);
       }},
  };
  return all;
}

class Completions : public ::testing::TestWithParam<Method> {
 protected:
  Completed complete(EntrySource& source, float share = kDefault, std::uint64_t seed = 1) const {
    Completed c{BitMatrix(source.n_rows(), source.n_columns()), {}};
    Rng rng({seed}, Stage::visibility, 0);
    c.stats = GetParam().run(source, share, rng, c.visible);
    return c;
  }
};
INSTANTIATE_TEST_SUITE_P(All, Completions, ::testing::ValuesIn(methods()),
                         [](const auto& test) { return test.param.name; });

TEST_P(Completions, TracedBitsStayAndAreAskedForOnceAtAllSizes) {
  for (const std::size_t n_rows : {1u, 15u, 17u, 63u, 64u, 65u, 300u}) {
    Rng rng({5}, Stage::test, n_rows);
    for (const float density : {1.0f, 0.7f, 0.1f, 0.0f}) {
      BitMatrix truth = test::planted(n_rows, 60, 5, rng);
      const BitMatrix active = test::random_bits(n_rows, 60, rng, density);
      for (std::size_t j = 0; j < 60; j += 3) truth.set(rng.below(static_cast<std::uint32_t>(n_rows)), j);
      LoggingEntries source = test::masked(truth, active, {7, 7, 30, 60});  // one group empty
      expect_sound(source, complete(source));
    }
  }
}

TEST_P(Completions, ShadowsAreSound) {
  Rng rng({6}, Stage::test, 0);
  for (test::ShadowScene scene : {test::two_discs(), test::bumpy(test::half_plane())}) {
    scene.n_columns = 96;
    LoggingEntries source(scene.entries(rng));
    const Completed c = complete(source);
    expect_sound(source, c);
    EXPECT_LT(c.stats.traced, c.stats.entries);
    EXPECT_LT(test::count_wrong(source, c.visible).rate(), 0.15);
  }
}

TEST_P(Completions, EverythingSampledEqualsTheTruth) {
  Rng rng({4}, Stage::test, 0);
  for (test::ShadowScene scene : {test::two_discs(), test::bumpy(test::half_plane())}) {
    scene.n_columns = 40;
    LoggingEntries source(scene.entries(rng));
    const Completed c = complete(source, 1);
    expect_sound(source, c);
    EXPECT_EQ(c.visible, source.truth());
    EXPECT_EQ(c.stats.traced, c.stats.entries);
  }
}

TEST_P(Completions, RequiredEntriesAreTracedOnce) {
  Rng rng({12}, Stage::test, 0);
  test::ShadowScene scene = test::bumpy(test::two_discs());
  scene.n_columns = 64;
  test::DemandingEntries source(scene.entries(rng));
  expect_sound(source, complete(source));
  for (std::size_t j = 0; j < source.n_columns(); ++j)
    for (std::size_t w = 0; w < 16; ++w)
      ASSERT_EQ(source.required(j)[w] & ~source.asked().column(j)[w], 0u) << "column " << j;
}

TEST_P(Completions, SameSeedSameBitsOtherSeedOtherSamples) {
  Rng rng({8}, Stage::test, 0);
  test::ShadowScene scene = test::bumpy(test::two_discs());
  scene.n_columns = 64;
  const KnownEntries known = scene.entries(rng);
  LoggingEntries a(known), b(known), d(known);
  EXPECT_EQ(complete(a, kDefault, 1).visible, complete(b, kDefault, 1).visible);
  complete(d, kDefault, 2);
  EXPECT_EQ(a.asked(), b.asked());
  EXPECT_NE(a.asked(), d.asked());
}

TEST_P(Completions, ConstantMatricesComeBack) {
  for (const BitMatrix& truth : {BitMatrix(500, 40), test::all_ones(500, 40)}) {
    LoggingEntries source = all_active(truth);
    const Completed c = complete(source);
    expect_sound(source, c);
    EXPECT_EQ(c.visible, truth);
    EXPECT_LT(c.stats.traced, c.stats.entries / 5);
  }
}

TEST_P(Completions, MatricesWithoutRowsOrColumnsAreFine) {
  for (const auto& [rows, columns] : {std::pair<std::size_t, std::size_t>{0, 5}, {5, 0}, {0, 0}}) {
    LoggingEntries source = all_active(BitMatrix(rows, columns));
    EXPECT_EQ(complete(source).stats.entries, 0u);
  }
}

TEST(CompletionShares, AreRefusedOutsideTheirRange) {
  for (const Method& method : methods()) {
    if (!method.takes_shares) continue;
    LoggingEntries source = all_active(BitMatrix(64, 2));
    for (const float share : {0.0f, 1.5f, -0.1f, std::numeric_limits<float>::quiet_NaN()}) {
      BitMatrix visible(64, 2);
      Rng rng({1}, Stage::visibility, 0);
      try {
        method.run(source, share, rng, visible);
        FAIL() << method.name << " accepted " << share;
      } catch (const Error& e) {
        EXPECT_EQ(e.kind(), ErrorKind::usage);
        EXPECT_NE(std::string(e.what()).find("must lie in"), std::string::npos) << e.what();
      }
    }
  }
}

}  // namespace
}  // namespace myrialux
