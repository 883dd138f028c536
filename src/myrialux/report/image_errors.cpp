// Measures of difference between two pictures, by direct sums over the pixels.
#include "myrialux/report/image_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "myrialux/base/assert.h"
#include "myrialux/math/srgb.h"

namespace myrialux {
namespace {

constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

/// The pixels of a picture as c numbers each.
struct Values {
  std::size_t c;
  std::vector<double> all;  ///< [n_pixels * c]
  std::size_t n_pixels() const { return all.size() / c; }
};

Values luminances(std::span<const Rgb> pixels) {
  Values v{1, {}};
  for (const Rgb& p : pixels) v.all.push_back(luminance(p));
  return v;
}

Values channels(std::span<const Rgb> pixels) {
  Values v{3, {}};
  for (const Rgb& p : pixels) v.all.insert(v.all.end(), {p.r, p.g, p.b});
  return v;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double over_mean(double value, double mean) { return mean > 0 ? value / mean : kUndefined; }

/// Pixels of the room, as opposed to windows and lamps.
std::vector<std::size_t> room_pixels(const Values& reference_luminance) {
  std::vector<double> sorted = reference_luminance.all;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  std::vector<std::size_t> room;
  for (std::size_t i = 0; i < reference_luminance.n_pixels(); ++i)
    if (reference_luminance.all[i] <= kRoomTimesMedian * *middle) room.push_back(i);
  return room;
}

/// Mean of the squares without the n / kWorstOneIn largest.
double mean_without_worst(std::vector<double> squares) {
  std::sort(squares.begin(), squares.end());
  squares.resize(squares.size() - squares.size() / kWorstOneIn);
  return mean_of(squares);
}

/// relative_rmse_without_worst of some pixels.
double room_error(const Values& reference, const std::vector<double>& square_of_pixel,
                  const std::vector<std::size_t>& room) {
  if (room.empty()) return kUndefined;
  std::vector<double> squares, values;
  for (const std::size_t i : room) {
    squares.push_back(square_of_pixel[i]);
    for (std::size_t k = 0; k < reference.c; ++k) values.push_back(reference.all[reference.c * i + k]);
  }
  return over_mean(std::sqrt(mean_without_worst(std::move(squares))), mean_of(values));
}

/// What an 8-bit picture would hold, not rounded.
double shown(double linear, double factor) {
  return encode_srgb(static_cast<float>(std::clamp(linear * factor, 0.0, 1.0)));
}

ErrorMeasures measure(const Values& reference, const Values& image, const std::vector<std::size_t>& room,
                      double exposure) {
  const std::size_t c = reference.c, n = reference.n_pixels();
  ErrorMeasures m;
  m.mean_reference = mean_of(reference.all);
  m.mean = mean_of(image.all);
  m.bias = over_mean(m.mean - m.mean_reference, m.mean_reference);

  const double factor = std::exp2(exposure), n_values = static_cast<double>(reference.all.size());
  std::vector<double> square_of_pixel(n);
  double absolute = 0, relative_squares = 0, shown_squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    double largest = 0;
    for (std::size_t k = c * i; k < c * (i + 1); ++k) {
      const double r = reference.all[k], difference = image.all[k] - r;
      square_of_pixel[i] += difference * difference / static_cast<double>(c);
      relative_squares += difference * difference / (r * r + kRelmseEpsilon);
      absolute += std::abs(difference);
      largest = std::max(largest, std::abs(difference));
      const double seen = shown(image.all[k], factor) - shown(r, factor);
      shown_squares += seen * seen;
    }
    if (largest > kDiffersFromShare * m.mean_reference) ++m.differing_pixels;
  }
  m.mae = absolute / n_values;
  m.relmse = relative_squares / n_values;
  m.rmse = std::sqrt(mean_of(square_of_pixel));
  m.relative_rmse = over_mean(m.rmse, m.mean_reference);
  m.relative_rmse_without_worst = over_mean(std::sqrt(mean_without_worst(square_of_pixel)), m.mean_reference);
  m.relative_rmse_room = room_error(reference, square_of_pixel, room);
  m.differing_share = static_cast<double>(m.differing_pixels) / static_cast<double>(n);
  m.psnr_db = shown_squares > 0 ? -10 * std::log10(shown_squares / n_values) : std::numeric_limits<double>::infinity();
  return m;
}

std::array<double, 3> mean_rgb(const Values& rgb) {
  std::array<double, 3> sum{};
  for (std::size_t k = 0; k < rgb.all.size(); ++k) sum[k % 3] += rgb.all[k];
  for (double& s : sum) s /= static_cast<double>(rgb.n_pixels());
  return sum;
}

}  // namespace

ImageErrors image_errors(std::span<const Rgb> reference, std::span<const Rgb> image, double exposure) {
  MYRIALUX_ASSERT(reference.size() == image.size() && !image.empty());
  const Values y_reference = luminances(reference), rgb_reference = channels(reference), rgb_image = channels(image);
  const std::vector<std::size_t> room = room_pixels(y_reference);
  return {.luminance = measure(y_reference, luminances(image), room, exposure),
          .rgb = measure(rgb_reference, rgb_image, room, exposure),
          .mean_rgb_reference = mean_rgb(rgb_reference),
          .mean_rgb = mean_rgb(rgb_image)};
}

const std::vector<MeasureInfo>& measure_table() {
  using M = ErrorMeasures;
  static const std::vector<MeasureInfo> table = {
      {"relative_rmse", "relative RMSE", "%", "Root-mean-square difference over the mean of the reference.", true,
       [](const M& m) { return m.relative_rmse; }},
      {"relative_rmse_without_worst", "without worst 0.1 %", "%",
       "Relative RMSE without the worst 0.1 % of the pixels: what is left once a few white dots are forgiven.", true,
       [](const M& m) { return m.relative_rmse_without_worst; }},
      {"relative_rmse_room", "of the room", "%",
       "The same over pixels at most 10 times as bright as the reference's median, over their mean: windows and lamps "
       "do not count.",
       true, [](const M& m) { return m.relative_rmse_room; }},
      {"relmse", "relMSE", "",
       "Mean of squared difference / (squared reference + 0.01): every pixel by its own brightness, dark corners "
       "count.",
       true, [](const M& m) { return m.relmse; }},
      {"rmse", "RMSE", "", "Root-mean-square difference, in the pictures' own unit.", true,
       [](const M& m) { return m.rmse; }},
      {"mae", "MAE", "", "Mean absolute difference, in the pictures' own unit.", true,
       [](const M& m) { return m.mae; }},
      {"bias",
       "bias",
       "%",
       "Mean of the picture minus mean of the reference, over the latter: too bright or too dark.",
       {},
       [](const M& m) { return m.bias; }},
      {"differing_share", "pixels off by 5 %", "%",
       "Share of the pixels that differ by more than 5 % of the reference's mean (in any channel).", true,
       [](const M& m) { return m.differing_share; }},
      {"differing_pixels", "their number", "", "Number of these pixels.", true,
       [](const M& m) { return static_cast<double>(m.differing_pixels); }},
      {"psnr_db", "PSNR", "dB",
       "Peak signal-to-noise ratio as shown: after exposure, cut to 0 to 1 and sRGB curve. Higher is better.", false,
       [](const M& m) { return m.psnr_db; }},
  };
  return table;
}

}  // namespace myrialux
