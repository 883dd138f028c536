// The goodness-of-fit test itself: known values, and that it accepts truth and rejects small lies.
#include "support/chi_square.h"

#include <gtest/gtest.h>

#include "myrialux/base/rng.h"
#include "myrialux/math/warp.h"

namespace myrialux::testing {
namespace {

TEST(ChiSquare, IncompleteGammaHasItsKnownValues) {
  EXPECT_NEAR(upper_gamma(1, 2.5), std::exp(-2.5), 1e-14);                     // Q(1, x) = exp(-x)
  EXPECT_NEAR(upper_gamma(0.5, 3), std::erfc(std::sqrt(3.0)), 1e-13);          // Q(1/2, x) = erfc(sqrt x)
  EXPECT_NEAR(upper_gamma(3, 0.2), std::exp(-0.2) * (1 + 0.2 + 0.02), 1e-13);  // Poisson sums
  EXPECT_NEAR(upper_gamma(3, 20) / (std::exp(-20.0) * (1 + 20 + 200)), 1, 1e-11);
  EXPECT_NEAR(upper_gamma(500, 500), 0.49405286, 1e-6);  // median of Gamma(a) is a - 1/3: a little below one half
  EXPECT_EQ(upper_gamma(4, 0), 1);
  EXPECT_LT(upper_gamma(2, 900), 1e-300);
}

TEST(ChiSquare, TabulatedQuantiles) {  // 95 % points of the chi-square distribution
  EXPECT_NEAR(upper_gamma(0.5, 3.841459 / 2), 0.05, 1e-7);
  EXPECT_NEAR(upper_gamma(5, 18.307038 / 2), 0.05, 1e-7);
  EXPECT_NEAR(upper_gamma(50, 124.342113 / 2), 0.05, 1e-7);
}

TEST(ChiSquare, SidakLevelKeepsTheSuiteLevel) {
  EXPECT_NEAR(1 - std::pow(1 - chi_square_level(700, 0.01), 700.0), 0.01, 1e-9);
}

TEST(ChiSquare, SmallCellsArePooledAndEmptyOnesForbidden) {
  const std::vector<double> expected{2, 2, 2, 100, 0};
  EXPECT_EQ(chi_square_counts(std::vector<double>{2, 2, 2, 100, 0}, expected).degrees_of_freedom, 1);
  EXPECT_NEAR(chi_square_counts(std::vector<double>{2, 2, 2, 100, 0}, expected).p_value, 1, 1e-12);
  EXPECT_LT(chi_square_counts(std::vector<double>{2, 2, 2, 50, 50}, expected).p_value, 1e-6);
}

std::optional<Vec3> cosine_sample(Rng& rng) {
  const float x = rng.next(), y = rng.next();
  return sample_cosine_hemisphere({x, y});
}

TEST(ChiSquare, AcceptsTruthAndRejectsALieOfFivePercent) {
  const auto cosine = [](Vec3 d) { return static_cast<double>(cosine_hemisphere_pdf_omega(d.z)); };
  Rng rng({1, 0}, Stage::test, 0);
  EXPECT_GT(chi_square_directions(
                "truth", 200000, 0, [&](int) { return cosine_sample(rng); }, cosine)
                .p_value,
            1e-3);
  const auto lie = [&](Vec3 d) { return cosine(d) * (1 + (d.x > 0 ? 0.05 : -0.05)); };
  EXPECT_LT(chi_square_directions(
                "lie", 40000, 0, [&](int) { return cosine_sample(rng); }, lie)
                .p_value,
            1e-3);
  const auto lost = [&](int i) { return i % 50 == 0 ? std::nullopt : cosine_sample(rng); };
  EXPECT_LT(chi_square_directions("lost", 200000, 0, lost, cosine).p_value, 1e-3);
}

}  // namespace
}  // namespace myrialux::testing
