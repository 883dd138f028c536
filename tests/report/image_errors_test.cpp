// Each measure of difference against values computed by hand on tiny pictures.
#include "myrialux/report/image_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace myrialux {
namespace {

/// The weights of luminance sum to 1 only to a float's precision.
constexpr double kTolerance = 2e-6;

std::vector<Rgb> grays(std::initializer_list<float> values) {
  std::vector<Rgb> pixels;
  for (const float v : values) pixels.push_back(gray(v));
  return pixels;
}

TEST(ImageErrors, OfEqualPicturesAreZero) {
  const std::vector<Rgb> picture = {{1, 2, 3}, {0, 0.5f, 7}, {-1, 0, 2}};
  for (const ErrorMeasures& m : {image_errors(picture, picture).luminance, image_errors(picture, picture).rgb}) {
    for (const MeasureInfo& info : measure_table()) {
      const bool is_ratio = info.key == "psnr_db";
      EXPECT_TRUE(is_ratio || info.value(m) == 0) << info.key;
    }
    EXPECT_EQ(m.psnr_db, std::numeric_limits<double>::infinity());
    EXPECT_EQ(m.mean, m.mean_reference);
  }
}

TEST(ImageErrors, OfGrayPixelsAreAsByHand) {
  const ImageErrors e = image_errors(grays({1, 2, 3, 2}), grays({1, 3, 2, 2.08f}));
  for (const ErrorMeasures& m : {e.luminance, e.rgb}) {  // grey: the same on both
    EXPECT_NEAR(m.mean_reference, 2, kTolerance);
    EXPECT_NEAR(m.mean, 2.02, kTolerance);
    EXPECT_NEAR(m.bias, 0.01, kTolerance);
    EXPECT_NEAR(m.rmse, std::sqrt((1 + 1 + 0.0064) / 4), kTolerance);
    EXPECT_NEAR(m.relative_rmse, std::sqrt(2.0064 / 4) / 2, kTolerance);
    EXPECT_NEAR(m.mae, 2.08 / 4, kTolerance);
    EXPECT_NEAR(m.relmse, (1 / 4.01 + 1 / 9.01 + 0.0064 / 4.01) / 4, kTolerance);
    EXPECT_EQ(m.differing_pixels, 2u) << "0.08 is less than 5 % of 2";
    EXPECT_EQ(m.differing_share, 0.5);
    EXPECT_EQ(m.relative_rmse_without_worst, m.relative_rmse) << "0.1 % of 4 pixels is none";
    EXPECT_EQ(m.relative_rmse_room, m.relative_rmse) << "no pixel is 10 times as bright as the median";
  }
}

TEST(ImageErrors, OfColoursRunOverPixelsAndChannels) {
  const std::vector<Rgb> reference = {{1, 2, 3}, {1, 2, 3}}, image = {{2, 2, 3}, {1, 2, 1}};
  const ImageErrors e = image_errors(reference, image);
  EXPECT_NEAR(e.rgb.mean_reference, 2, kTolerance);
  EXPECT_NEAR(e.rgb.mean, 11.0 / 6, kTolerance);
  EXPECT_NEAR(e.rgb.rmse, std::sqrt(5.0 / 6), kTolerance);
  EXPECT_NEAR(e.rgb.mae, 3.0 / 6, kTolerance);
  EXPECT_NEAR(e.rgb.relmse, (1 / 1.01 + 4 / 9.01) / 6, kTolerance);
  EXPECT_EQ(e.rgb.differing_pixels, 2u) << "pixels are counted, not channels";
  EXPECT_NEAR(e.luminance.mae, (0.212671 + 2 * 0.072169) / 2, kTolerance);
  EXPECT_THAT(e.mean_rgb_reference, testing::ElementsAre(1, 2, 3));
  EXPECT_THAT(e.mean_rgb, testing::ElementsAre(1.5, 2, 2));
}

TEST(ImageErrors, WithoutTheWorstForgetsOnePixelInAThousand) {
  std::vector<Rgb> reference(2999, gray(1)), image(2999, gray(1.5f));
  image[7] = image[2000] = gray(100);  // 2999 / 1000 rounded down: two pixels
  EXPECT_NEAR(image_errors(reference, image).luminance.relative_rmse_without_worst, 0.5, kTolerance);
  EXPECT_GT(image_errors(reference, image).luminance.relative_rmse, 2);
  image[2998] = gray(100);
  EXPECT_NEAR(image_errors(reference, image).rgb.relative_rmse_without_worst,
              std::sqrt((99.0 * 99 + 2996 * 0.25) / 2997), kTolerance);
}

TEST(ImageErrors, OfTheRoomLeavesOutWhatIsTenTimesTheMedian) {
  // Median 2; 20 is still part of the room, 21 is not.
  const std::vector<Rgb> reference = grays({2, 2, 2, 20, 21}), image = grays({3, 2, 2, 20, 42});
  const ImageErrors e = image_errors(reference, image);
  EXPECT_NEAR(e.luminance.relative_rmse_room, std::sqrt(1.0 / 4) / (26.0 / 4), kTolerance);
  EXPECT_NEAR(e.rgb.relative_rmse_room, std::sqrt(1.0 / 4) / (26.0 / 4), kTolerance);
}

TEST(ImageErrors, PsnrIsThatOfThePicturesAsShown) {
  const auto psnr = [](float reference, float image, double exposure) {
    return image_errors(grays({reference}), grays({image}), exposure).rgb.psnr_db;
  };
  EXPECT_NEAR(psnr(1, 0, 0), 0, 1e-6);
  EXPECT_NEAR(psnr(1, 0.21404114f, 0), 20 * std::log10(2.0), 1e-5) << "0.214 is a half on the sRGB curve";
  EXPECT_NEAR(psnr(2, 2 * 0.21404114f, -1), 20 * std::log10(2.0), 1e-5) << "one stop darker";
  EXPECT_EQ(psnr(3, 5, 0), std::numeric_limits<double>::infinity()) << "both are white";
  EXPECT_EQ(psnr(0, -1, 0), std::numeric_limits<double>::infinity()) << "both are black";
  EXPECT_NEAR(psnr(0.001f, 0, 0), -20 * std::log10(0.01292), 1e-4) << "the straight part of the curve";
}

TEST(ImageErrors, RelativeToABlackReferenceAreUndefined) {
  const ErrorMeasures m = image_errors(grays({0, 0}), grays({1, 3})).rgb;
  for (const double v : {m.bias, m.relative_rmse, m.relative_rmse_without_worst, m.relative_rmse_room})
    EXPECT_TRUE(std::isnan(v));
  EXPECT_NEAR(m.rmse, std::sqrt(5.0), kTolerance);
  EXPECT_NEAR(m.relmse, 5 / 0.01, 1e-3);
  EXPECT_EQ(m.differing_pixels, 2u);
}

TEST(ImageErrors, TableNamesEachMeasureOnceAndSaysWhatItMeans) {
  std::set<std::string> keys, names;
  for (const MeasureInfo& m : measure_table()) {
    EXPECT_TRUE(keys.insert(m.key).second && names.insert(m.name).second) << m.key;
    EXPECT_TRUE(m.meaning.ends_with('.')) << m.key;
    EXPECT_LE(m.name.size(), 19u) << "a column of the table on the terminal";
  }
}

}  // namespace
}  // namespace myrialux
