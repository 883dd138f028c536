// Textures against hand values: texel grid, wrapping, filtering, colour curves.
#include "myrialux/scene/texture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace myrialux {
namespace {

/// 4 x 4: top row red, bottom row green, left column blue on top of that.
Texture corners() {
  Image image;
  image.width = image.height = 4;
  image.floats.assign(48, 0);
  for (int x = 0; x < 4; ++x) image.floats[3 * x] = 1, image.floats[3 * (12 + x) + 1] = 1;
  for (int y = 0; y < 4; ++y) image.floats[3 * (4 * y) + 2] = 1;
  Texture texture;
  texture.image = std::make_shared<Image>(image);
  return texture;
}

void expect_color(Rgb got, Rgb want, float tolerance = 1e-5f) {
  EXPECT_NEAR(got.r, want.r, tolerance);
  EXPECT_NEAR(got.g, want.g, tolerance);
  EXPECT_NEAR(got.b, want.b, tolerance);
}

// All colours below were measured with Mitsuba 3.9.1 on the same pixels.
TEST(Texture, BilinearLookupsAreThoseOfMitsuba) {
  const Texture t = corners();
  expect_color(evaluate(t, {0, 0}), {0.5f, 0.5f, 0.5f});
  expect_color(evaluate(t, {0.125f, 0.125f}), {1, 0, 1});
  expect_color(evaluate(t, {0.3f, 0.2f}), {0.7f, 0, 0.3f});
  expect_color(evaluate(t, {0.99f, 0.01f}), {0.54f, 0.46f, 0.46f});
  expect_color(evaluate(t, {-0.3f, 1.2f}), {0.7f, 0, 0});
}

TEST(Texture, WrapModesAreThoseOfMitsuba) {
  Texture t = corners();
  expect_color(evaluate(t, {2.3f, -0.9f}), {0.9f, 0.1f, 0.3f});
  t.wrap = Texture::Wrap::mirror;
  expect_color(evaluate(t, {0, 0}), {1, 0, 1});
  expect_color(evaluate(t, {-0.3f, 1.2f}), {0, 0.7f, 0.3f});
  expect_color(evaluate(t, {2.3f, -0.9f}), {0, 1, 0.3f});
  t.wrap = Texture::Wrap::clamp;
  expect_color(evaluate(t, {0, 0}), {1, 0, 1});
  expect_color(evaluate(t, {-0.3f, 1.2f}), {0, 1, 1});
  expect_color(evaluate(t, {2.3f, -0.9f}), {1, 0, 0});
}

TEST(Texture, TransformsOfUvAreThoseOfMitsuba) {
  Texture t = corners();
  t.filter = Texture::Filter::nearest;
  t.to_uv = Transform::scale({2, 3, 1}) * Transform::translate({0.1f, 0.2f, 0});
  expect_color(evaluate(t, {0.05f, 0.05f}), {0, 1, 0});
  expect_color(evaluate(t, {0.3f, 0.2f}), {1, 0, 0});
  expect_color(evaluate(t, {0.1f, 0.9f}), {0, 0, 0});
}

TEST(Texture, CheckerboardFieldsAreThoseOfMitsuba) {
  Texture t;
  t.kind = Texture::Kind::checkerboard;
  expect_color(evaluate(t, {0.25f, 0.25f}), gray(0.4f));
  expect_color(evaluate(t, {0.75f, 0.25f}), gray(0.2f));
  expect_color(evaluate(t, {0.75f, 0.75f}), gray(0.4f));
  expect_color(average(t), gray(0.3f));
  t.to_uv = Transform::scale({4, 2, 1});
  expect_color(evaluate(t, {0.05f, 0.05f}), gray(0.4f));
  expect_color(evaluate(t, {0.15f, 0.05f}), gray(0.2f));
}

TEST(Texture, AverageIsTheMeanOfTheTexels) { expect_color(average(corners()), gray(0.25f)); }

TEST(Texture, HugeAndNonFiniteCoordinatesGiveSomeTexel) {
  Texture t = corners();
  for (const auto wrap : {Texture::Wrap::repeat, Texture::Wrap::mirror, Texture::Wrap::clamp}) {
    t.wrap = wrap;
    for (const float u : {1e30f, -1e30f, kInfinity, std::nanf(""), 1e9f})
      EXPECT_TRUE(is_finite(evaluate(t, {u, -u}))) << u;
  }
}

TEST(Texture, BytesCarryTheSrgbCurveOnlyWhenSaidSo) {
  Image image;
  image.width = image.height = 1, image.channels = 4;
  image.bytes = {0, 128, 255, 51};
  expect_color(image.texel(0, 0), {0, 128 / 255.0f, 1});
  image.srgb = true;
  expect_color(image.texel(0, 0), {0, 0.2158605f, 1}, 1e-6f);  // IEC 61966-2-1: 128 -> 0.2158605
  EXPECT_FLOAT_EQ(image.alpha(0, 0), 0.2f);
}

}  // namespace
}  // namespace myrialux
