// Reconstruction filters at known places.
#include "myrialux/math/filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace myrialux {
namespace {

using Kind = Filter::Kind;

std::vector<Filter> all_filters() {
  return {{.kind = Kind::box, .radius = 0.5f},     {.kind = Kind::tent, .radius = 1},
          {.kind = Kind::gaussian, .radius = 2},   {.kind = Kind::mitchell, .radius = 2},
          {.kind = Kind::catmullrom, .radius = 2}, {.kind = Kind::lanczos, .radius = 3}};
}

TEST(Filter, VanishesAtAndBeyondTheRadius) {
  for (const Filter& f : all_filters()) {
    EXPECT_EQ(f.evaluate(f.radius), 0);
    EXPECT_EQ(f.evaluate(f.radius + 1), 0);
    EXPECT_EQ(f.evaluate(-f.radius - 1e-4f), 0);
    EXPECT_GT(f.evaluate(0), 0);
  }
}

TEST(Filter, IsEven) {
  for (const Filter& f : all_filters())
    for (const float x : {0.1f, 0.45f, 0.9f, 1.7f, 2.3f}) EXPECT_EQ(f.evaluate(x), f.evaluate(-x));
}

TEST(Filter, BoxCountsEverySampleOnce) {
  const Filter f{.kind = Kind::box, .radius = 0.5f};
  for (const float x : {0.0f, 0.25f, 0.5f, 0.75f}) EXPECT_EQ(f.evaluate(x - 0.5f) + f.evaluate(x + 0.5f), 1) << x;
}

TEST(Filter, InterpolatingKindsAreOneAtTheCentreAndZeroAtPixels) {
  for (const Filter& f : all_filters()) {
    if (f.kind != Kind::catmullrom && f.kind != Kind::lanczos && f.kind != Kind::tent) continue;
    EXPECT_NEAR(f.evaluate(0), 1, 1e-6f);
    for (const float x : {1.0f, 2.0f}) EXPECT_NEAR(f.evaluate(x), 0, 1e-6f);
  }
}

TEST(Filter, KnownValues) {
  const Filter mitchell{.kind = Kind::mitchell, .radius = 2};
  EXPECT_NEAR(mitchell.evaluate(0), 8.0f / 9, 1e-6f);   // (6 - 2B) / 6
  EXPECT_NEAR(mitchell.evaluate(1), 1.0f / 18, 1e-6f);  // B / 6
  const Filter tent{.kind = Kind::tent, .radius = 1};
  EXPECT_NEAR(tent.evaluate(0.25f), 0.75f, 1e-6f);
  const Filter gaussian{.kind = Kind::gaussian, .radius = 2, .sigma = 0.5f};
  EXPECT_NEAR(gaussian.evaluate(0.5f), std::exp(-0.5f) - std::exp(-8.0f), 1e-6f);
  const Filter lanczos{.kind = Kind::lanczos, .radius = 3};
  EXPECT_NEAR(lanczos.evaluate(0.5f), 2 / M_PI * 3 / M_PI, 1e-6);  // sinc(1/2) sinc(1/6)
}

TEST(Filter, ShiftedCopiesAddUpToAConstant) {
  for (const Filter& f : all_filters()) {
    if (f.kind == Kind::gaussian || f.kind == Kind::lanczos) continue;
    for (const float x : {0.0f, 0.13f, 0.5f, 0.77f}) {
      float sum = 0;
      for (int k = -4; k <= 4; ++k) sum += f.evaluate(x + static_cast<float>(k));
      EXPECT_NEAR(sum, 1, 1e-5f) << static_cast<int>(f.kind) << ' ' << x;
    }
  }
}

}  // namespace
}  // namespace myrialux
