// Looks up bitmaps and checkerboards; the texel grid, wrapping and filtering are those of Mitsuba 3.
#include "myrialux/scene/texture.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "myrialux/base/assert.h"
#include "myrialux/math/srgb.h"

namespace myrialux {

namespace {

const std::array<float, 256>& srgb_table();
int wrap_index(int i, int n, Texture::Wrap wrap);
Vec2 apply(const Transform& to_uv, Vec2 uv);
Rgb bitmap(const Texture& texture, Vec2 uv);
Rgb image_mean(const Image& image);

}  // namespace

Rgb Image::texel(int x, int y) const {
  MYRIALUX_ASSERT(x >= 0 && x < width && y >= 0 && y < height);
  const std::size_t at = (static_cast<std::size_t>(y) * width + x) * channels;
  const auto from = [&](const auto& channel) {
    return channels < 3 ? gray(channel(0)) : Rgb{channel(0), channel(1), channel(2)};
  };
  if (!floats.empty()) return from([p = &floats[at]](std::size_t c) { return p[c]; });
  const std::uint8_t* const p = &bytes[at];
  if (!srgb) return from([p](std::size_t c) { return p[c] * (1.0f / 255); });
  return from([p, &linear = srgb_table()](std::size_t c) { return linear[p[c]]; });
}

float Image::alpha(int x, int y) const {
  MYRIALUX_ASSERT(x >= 0 && x < width && y >= 0 && y < height);
  if (channels != 4) return 1;
  const std::size_t at = (static_cast<std::size_t>(y) * width + x) * 4 + 3;
  return floats.empty() ? bytes[at] * (1.0f / 255) : floats[at];
}

Rgb evaluate(const Texture& texture, Vec2 uv) {
  const Vec2 p = apply(texture.to_uv, uv);
  if (texture.kind == Texture::Kind::bitmap) return bitmap(texture, p);
  const bool right = p.x - std::floor(p.x) > 0.5f, upper = p.y - std::floor(p.y) > 0.5f;
  return right == upper ? texture.color0 : texture.color1;
}

Rgb average(const Texture& texture) {
  if (texture.kind == Texture::Kind::checkerboard) return (texture.color0 + texture.color1) * 0.5f;
  return image_mean(*texture.image);
}

namespace {

/// Linear value of each sRGB byte. Source: IEC 61966-2-1
const std::array<float, 256>& srgb_table() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t{};
    for (int i = 0; i < 256; ++i) {
      t[i] = decode_srgb(static_cast<float>(i) / 255);
    }
    return t;
  }();
  return table;
}

int wrap_index(int i, int n, Texture::Wrap wrap) {
  if (i >= 0 && i < n) return i;  // most of all, and a division less
  if (wrap == Texture::Wrap::clamp) return i < 0 ? 0 : i >= n ? n - 1 : i;
  const int period = wrap == Texture::Wrap::mirror ? 2 * n : n;
  int k = i % period;
  if (k < 0) k += period;
  return k < n ? k : 2 * n - 1 - k;
}

Vec2 apply(const Transform& to_uv, Vec2 uv) {
  const auto& m = to_uv.rows();
  return {static_cast<float>(m[0] * uv.x + m[1] * uv.y + m[3]), static_cast<float>(m[4] * uv.x + m[5] * uv.y + m[7])};
}

/// Reduces a coordinate to one period, so that it can become an integer; non-finite input gives 0.
float reduce(float t, Texture::Wrap wrap) {
  if (!std::isfinite(t)) return 0;
  if (wrap == Texture::Wrap::clamp) return std::fmin(std::fmax(t, -1.0f), 2.0f);
  return std::fabs(t) < 1024 ? t : t - 2 * std::floor(t / 2);
}

Rgb bitmap(const Texture& texture, Vec2 uv) {
  const Image& image = *texture.image;
  const auto column = [&](int x) { return wrap_index(x, image.width, texture.wrap); };
  const auto row = [&](int y) { return wrap_index(y, image.height, texture.wrap); };
  const float x = reduce(uv.x, texture.wrap) * static_cast<float>(image.width);
  const float y = reduce(uv.y, texture.wrap) * static_cast<float>(image.height);
  if (texture.filter == Texture::Filter::nearest)
    return image.texel(column(static_cast<int>(std::floor(x))), row(static_cast<int>(std::floor(y))));
  const float fx = std::floor(x - 0.5f), fy = std::floor(y - 0.5f);
  const float wx = x - 0.5f - fx, wy = y - 0.5f - fy;
  const int x0 = static_cast<int>(fx), y0 = static_cast<int>(fy);
  const int left = column(x0), right = column(x0 + 1), low = row(y0), high = row(y0 + 1);
  const Rgb lower = image.texel(left, low) * (1 - wx) + image.texel(right, low) * wx;
  const Rgb upper = image.texel(left, high) * (1 - wx) + image.texel(right, high) * wx;
  return lower * (1 - wy) + upper * wy;
}

Rgb image_mean(const Image& image) {
  double sum[3] = {0, 0, 0};  // rows one after the other: fixed order
  for (int y = 0; y < image.height; ++y) {
    double row[3] = {0, 0, 0};
    for (int x = 0; x < image.width; ++x) {
      const Rgb c = image.texel(x, y);
      row[0] += c.r, row[1] += c.g, row[2] += c.b;
    }
    for (int c = 0; c < 3; ++c) sum[c] += row[c];
  }
  const double scale = 1.0 / (static_cast<double>(image.width) * image.height);
  return {static_cast<float>(sum[0] * scale), static_cast<float>(sum[1] * scale), static_cast<float>(sum[2] * scale)};
}

}  // namespace

}  // namespace myrialux
