// Filters: what must hold of sums and weights for every filter, at sizes that fit no block.
#include <gtest/gtest.h>

#include <cmath>

#include "myrialux/base/parallel.h"
#include "myrialux/base/rng.h"
#include "myrialux/film/film.h"

namespace myrialux {
namespace {

using Kind = Filter::Kind;

const std::vector<Filter>& all_filters() {
  static const std::vector<Filter> filters = {{.kind = Kind::box, .radius = 0.5f},
                                              {.kind = Kind::tent, .radius = 1},
                                              {.kind = Kind::gaussian, .radius = 2, .sigma = 0.5f},
                                              {.kind = Kind::mitchell, .radius = 2},
                                              {.kind = Kind::catmullrom, .radius = 2},
                                              {.kind = Kind::lanczos, .radius = 3},
                                              {.kind = Kind::box, .radius = 1.3f}};
  return filters;
}

struct Samples {
  int width, height, spp;
  std::vector<Vec2> position;
  std::vector<Rgb> values;
};

Samples random_samples(int width, int height, int spp) {
  Samples s{width, height, spp, {}, {}};
  Rng rng({3, 0}, Stage::test, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int k = 0; k < spp; ++k) {
        s.position.push_back({static_cast<float>(x) + rng.next(), static_cast<float>(y) + rng.next()});
        s.values.push_back({rng.next(), rng.next(), rng.next()});
      }
  return s;
}

struct Sums {
  std::vector<double> rgb, weight;
  explicit Sums(const Samples& s) : rgb(3 * n_pixels(s)), weight(n_pixels(s)) {}
  static std::size_t n_pixels(const Samples& s) { return std::size_t(s.width) * std::size_t(s.height); }
  void add(const Samples& s, const Filter& f) {
    accumulate(s.position, s.values, s.width, s.height, s.spp, f, rgb, weight);
  }
};

/// The definition: every pixel looks at every sample.
Sums plain_sums(const Samples& s, const Filter& f) {
  Sums sums(s);
  for (std::size_t i = 0; i < sums.weight.size(); ++i) {
    const float x = static_cast<float>(i % std::size_t(s.width)) + 0.5f;
    const float y = static_cast<float>(i / std::size_t(s.width)) + 0.5f;
    for (std::size_t k = 0; k < s.position.size(); ++k) {
      const double w =
          static_cast<double>(f.evaluate(s.position[k].x - x)) * static_cast<double>(f.evaluate(s.position[k].y - y));
      sums.weight[i] += w;
      sums.rgb[3 * i] += w * static_cast<double>(s.values[k].r);
      sums.rgb[3 * i + 1] += w * static_cast<double>(s.values[k].g);
      sums.rgb[3 * i + 2] += w * static_cast<double>(s.values[k].b);
    }
  }
  return sums;
}

TEST(Accumulate, BandsOfRowsAddUpToTheSameBits) {
  const Samples s = random_samples(37, 50, 3);
  for (const Filter& filter : all_filters()) {
    Sums whole(s), banded(s);
    whole.add(s, filter);
    int first = 0;
    for (const int n_rows : {1, 2, 33, 14}) {
      const std::size_t begin = std::size_t(first) * 37 * 3, n = std::size_t(n_rows) * 37 * 3;
      accumulate(std::span(s.position).subspan(begin, n), std::span(s.values).subspan(begin, n), s.width, s.height,
                 s.spp, filter, banded.rgb, banded.weight, first);
      first += n_rows;
    }
    ASSERT_EQ(first, s.height);
    EXPECT_EQ(whole.rgb, banded.rgb);
    EXPECT_EQ(whole.weight, banded.weight);
  }
}

TEST(Accumulate, ConstantInputGivesConstantPictureForAllFilters) {
  for (const Filter& filter : all_filters())
    for (const auto& [width, height] : {std::pair{1, 1}, {63, 5}, {64, 3}, {65, 33}, {3, 67}}) {
      Samples s = random_samples(width, height, 5);
      for (Rgb& v : s.values) v = {0.25f, 1, 7};
      Sums sums(s);
      sums.add(s, filter);
      for (std::size_t i = 0; i < sums.weight.size(); ++i) {
        ASSERT_NE(sums.weight[i], 0);
        // Double sums of at most a few hundred terms; cancelling lobes cost some digits.
        EXPECT_NEAR(sums.rgb[3 * i] / sums.weight[i], 0.25, 1e-11);
        EXPECT_NEAR(sums.rgb[3 * i + 1] / sums.weight[i], 1, 1e-11);
        EXPECT_NEAR(sums.rgb[3 * i + 2] / sums.weight[i], 7, 1e-10);
      }
    }
}

TEST(Accumulate, EqualsTheDefinitionBitForBit) {
  for (const Filter& filter : all_filters()) {
    const Samples s = random_samples(37, 41, 2);
    Sums sums(s);
    sums.add(s, filter);
    const Sums plain = plain_sums(s, filter);
    EXPECT_EQ(sums.weight, plain.weight);
    EXPECT_EQ(sums.rgb, plain.rgb);
  }
}

TEST(Accumulate, BoxFilterIsTheMeanOfThePixelsSamples) {
  const Samples s = random_samples(13, 9, 4);
  Sums sums(s);
  sums.add(s, {.kind = Kind::box, .radius = 0.5f});
  for (std::size_t i = 0; i < sums.weight.size(); ++i) {
    double mean = 0;
    for (std::size_t k = 4 * i; k < 4 * i + 4; ++k) mean += static_cast<double>(s.values[k].g) / 4;
    EXPECT_EQ(sums.weight[i], 4);
    EXPECT_NEAR(sums.rgb[3 * i + 1] / 4, mean, 1e-15);
  }
}

TEST(Accumulate, SampleOnItsPixelsEdgesCountsOnce) {
  Samples s{4, 1, 2, {}, {}};
  for (int x = 0; x < 4; ++x)  // one sample at the left edge, one that rounding moved onto the right edge
    for (const float offset : {0.0f, 1.0f}) {
      s.position.push_back({static_cast<float>(x) + offset, offset});
      s.values.push_back(gray(1));
    }
  Sums sums(s);
  sums.add(s, {.kind = Kind::box, .radius = 0.5f});
  EXPECT_EQ(sums.weight, std::vector<double>(4, 2.0));
}

TEST(Accumulate, PassesAddUp) {
  const Samples s = random_samples(9, 7, 3);
  const Filter filter{.kind = Kind::gaussian, .radius = 2, .sigma = 0.5f};
  Sums once(s), twice(s);
  once.add(s, filter);
  twice.add(s, filter);
  twice.add(s, filter);
  for (std::size_t i = 0; i < once.weight.size(); ++i) EXPECT_NEAR(twice.weight[i], 2 * once.weight[i], 1e-12);
}

TEST(Accumulate, SameBitsForAnyNumberOfThreads) {
  const Samples s = random_samples(65, 131, 2);
  std::vector<double> first;
  for (const int n_threads : {1, 2, 7}) {
    const ThreadScope scope(n_threads);
    Sums sums(s);
    sums.add(s, {.kind = Kind::mitchell, .radius = 2});
    if (first.empty()) first = sums.rgb;
    EXPECT_EQ(sums.rgb, first);
  }
}

}  // namespace
}  // namespace myrialux
