// Discrete and piecewise-constant distributions: exact probabilities, frequencies, ends of the unit interval.
#include "myrialux/math/distribution.h"

#include <gtest/gtest.h>

#include "myrialux/base/rng.h"
#include "support/chi_square.h"

namespace myrialux::testing {
namespace {

constexpr float kLast = 0x1.fffffep-1f;

TEST(Distribution1D, ProbabilitiesAreExact) {
  const Distribution1D d(std::vector<float>{1, 0, 3, 4});
  EXPECT_EQ(d.size(), 4u);
  EXPECT_EQ(d.sum(), 8);
  EXPECT_EQ(d.probability(0), 0.125f);
  EXPECT_EQ(d.probability(1), 0);
  EXPECT_EQ(d.probability(2), 0.375f);
  EXPECT_EQ(d.probability(3), 0.5f);
}

TEST(Distribution1D, BoundariesBelongToTheUpperIndex) {
  const Distribution1D d(std::vector<float>{1, 0, 3, 4});
  EXPECT_EQ(d.sample(0).index, 0u);
  EXPECT_EQ(d.sample(0.125f).index, 2u);  // never index 1, of weight 0
  EXPECT_EQ(d.sample(0.125f).reused, 0);
  EXPECT_EQ(d.sample(0.3125f).reused, 0.5f);
  EXPECT_EQ(d.sample(0.5f).index, 3u);
  EXPECT_EQ(d.sample(kLast).index, 3u);
}

TEST(Distribution1D, ZeroWeightsAreNeverDrawn) {
  for (const std::vector<float>& weights :
       {std::vector<float>{0, 0, 5, 0, 0}, std::vector<float>{0, 1e-30f, 0, 1e30f, 0}, std::vector<float>{7}}) {
    const Distribution1D d(weights);
    for (const float u : {0.0f, 1e-45f, 1e-20f, 0.25f, 0.5f, kLast, 1.0f}) {
      const Distribution1D::Sample s = d.sample(u);
      EXPECT_GT(weights[s.index], 0) << u;
      EXPECT_TRUE(s.reused >= 0 && s.reused < 1) << u;
      EXPECT_EQ(s.probability, d.probability(s.index));
    }
  }
}

TEST(Distribution1D, FrequenciesAndReusedNumbersFollow) {
  std::vector<float> weights;
  for (int i = 0; i < 65; ++i) weights.push_back(static_cast<float>((i * 37) % 11));
  const Distribution1D d(weights);
  constexpr int kSamples = 200000;
  std::vector<double> observed(65), expected, reused(32), uniform(32, kSamples / 32.0);
  for (const float w : weights) expected.push_back(kSamples * w / d.sum());
  Rng rng({1, 0}, Stage::test, 0);
  for (int i = 0; i < kSamples; ++i) {
    const Distribution1D::Sample s = d.sample(rng.next());
    observed[s.index] += 1;
    reused[static_cast<std::size_t>(s.reused * 32)] += 1;
  }
  const double level = chi_square_level(2);
  EXPECT_GE(chi_square_counts(observed, expected).p_value, level);
  EXPECT_GE(chi_square_counts(reused, uniform).p_value, level);
}

TEST(Distribution1D, ManyEqualWeightsKeepTheirProbability) {
  const std::vector<float> weights(1000000, 0.1f);  // float sums would drift
  const Distribution1D d(weights);
  EXPECT_NEAR(d.sum(), 1e5, 1e-2);
  EXPECT_NEAR(d.probability(999999) * 1e6f, 1, 1e-5f);
  EXPECT_NEAR(static_cast<double>(d.sample(0.5f).index), 500000, 1);
}

TEST(Distribution2D, DensityIsExactAndMatchesSamples) {
  const std::vector<float> weights{1, 2, 3, 0, 0, 0, 4, 0, 6};  // 3 x 3, middle row empty
  const Distribution2D d(weights, 3, 3);
  EXPECT_EQ(d.sum(), 16);
  EXPECT_NEAR(d.pdf_uv({0.5f, 0.1f}), 2.0f / 16 * 9, 1e-6f);
  EXPECT_NEAR(d.pdf_uv({0.99f, 0.99f}), 6.0f / 16 * 9, 1e-6f);
  EXPECT_EQ(d.pdf_uv({0.5f, 0.5f}), 0);
  EXPECT_EQ(d.pdf_uv({0.5f, 0.9f}), 0);
  EXPECT_NEAR(d.pdf_uv({1, 1}), 6.0f / 16 * 9, 1e-6f);  // the edge counts to the last cell
  Rng rng({1, 0}, Stage::test, 0);
  constexpr int kSamples = 100000;
  std::vector<double> observed(9), expected;
  for (const float w : weights) expected.push_back(kSamples * w / 16.0);
  for (int i = 0; i < kSamples; ++i) {
    const float x = rng.next(), y = rng.next();
    const Distribution2D::Sample s = d.sample({x, y});
    ASSERT_GT(s.pdf_uv, 0);
    ASSERT_EQ(s.pdf_uv, d.pdf_uv(s.uv));
    observed[static_cast<std::size_t>(s.uv.y * 3) * 3 + static_cast<std::size_t>(s.uv.x * 3)] += 1;
  }
  EXPECT_GE(chi_square_counts(observed, expected).p_value, chi_square_level(1));
}

TEST(Distribution2D, SamplesStayInTheSquareAndInTheirCell) {
  for (const std::size_t n : {1u, 2u, 7u, 63u, 4096u}) {
    std::vector<float> weights(n * 2, 0.0f);
    weights[n - 1] = 1;  // the last cell of the first row alone
    const Distribution2D d(weights, n, 2);
    for (const float x : {0.0f, 0.3f, kLast})
      for (const float y : {0.0f, 0.3f, kLast}) {
        const Distribution2D::Sample s = d.sample({x, y});
        EXPECT_TRUE(s.uv.x >= 0 && s.uv.x < 1 && s.uv.y >= 0 && s.uv.y < 0.5f) << n << ' ' << s.uv.x << ' ' << s.uv.y;
        EXPECT_EQ(d.pdf_uv(s.uv), s.pdf_uv) << n;
      }
  }
}

TEST(Distribution2D, DensityIntegratesToOne) {
  std::vector<float> weights;
  for (int i = 0; i < 5 * 8; ++i) weights.push_back(static_cast<float>((i * 7) % 13));
  const Distribution2D d(weights, 5, 8);
  double sum = 0;
  for (int x = 0; x < 5; ++x)
    for (int y = 0; y < 8; ++y)
      sum += d.pdf_uv({(static_cast<float>(x) + 0.5f) / 5, (static_cast<float>(y) + 0.5f) / 8});
  EXPECT_NEAR(sum / 40, 1, 1e-6);
}

}  // namespace
}  // namespace myrialux::testing
