// Weighs camera samples into pixels by a separable reconstruction filter.
#include <algorithm>
#include <cmath>

#include "myrialux/base/assert.h"
#include "myrialux/base/parallel.h"
#include "myrialux/film/film.h"

namespace myrialux {
namespace {

/// Weights of one sample along one axis for the pixels around its own, centre to centre distance up to `reach`.
/// Positions are kept inside their pixel (rounding may have moved one to the next), so that no sample is lost.
/// @param weight [2 * reach + 1], for pixels pixel - reach, ..., pixel + reach
void axis_weights(const Filter& filter, float position, int pixel, int reach, float* weight) {
  const float low = static_cast<float>(pixel), high = std::nextafter(low + 1, low);
  const float x = std::clamp(position, low, high);
  for (int d = -reach; d <= reach; ++d) weight[d + reach] = filter.evaluate(x - (low + static_cast<float>(d) + 0.5f));
}

std::size_t index_of(int k) { return static_cast<std::size_t>(k); }

}  // namespace

void accumulate(std::span<const Vec2> position, std::span<const Rgb> values, int width, int height, int spp,
                const Filter& filter, std::vector<double>& sum_rgb, std::vector<double>& weight, int first_row) {
  const std::size_t n_pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const std::size_t samples_a_row = static_cast<std::size_t>(width) * static_cast<std::size_t>(spp);
  const std::size_t first_sample = static_cast<std::size_t>(first_row) * samples_a_row;
  const int end_row = first_row + static_cast<int>(position.size() / samples_a_row);
  MYRIALUX_ASSERT(position.size() == values.size() && position.size() % samples_a_row == 0 && end_row <= height);
  MYRIALUX_ASSERT(sum_rgb.size() == 3 * n_pixels && weight.size() == n_pixels);
  // A sample anywhere in its pixel reaches at most this many pixels further.
  const int reach = std::max(0, static_cast<int>(std::ceil(filter.radius + 0.5f)) - 1);
  const std::size_t taps = 2 * static_cast<std::size_t>(reach) + 1;

  // A block of rows gathers from its own samples and from those of `reach` rows around; each pixel receives them in the
  // order of their indices, however rows are shared out.
  constexpr int kRows = 32;
  const int y_first = std::max(0, first_row - reach), y_last = std::min(height, end_row + reach);
  const std::size_t n_blocks = static_cast<std::size_t>((y_last - y_first + kRows - 1) / kRows);
  parallel_for(n_blocks, [&](std::size_t block) {
    const int y_begin = y_first + static_cast<int>(block) * kRows, y_end = std::min(y_last, y_begin + kRows);
    std::vector<float> weight_x(taps), weight_y(taps);
    for (int sy = std::max(first_row, y_begin - reach); sy < std::min(end_row, y_end + reach); ++sy)
      for (int sx = 0; sx < width; ++sx)
        for (int k = 0; k < spp; ++k) {
          const std::size_t s =
              (static_cast<std::size_t>(sy) * static_cast<std::size_t>(width) + static_cast<std::size_t>(sx)) *
                  static_cast<std::size_t>(spp) +
              static_cast<std::size_t>(k) - first_sample;
          axis_weights(filter, position[s].x, sx, reach, weight_x.data());
          axis_weights(filter, position[s].y, sy, reach, weight_y.data());
          const Rgb value = values[s];
          for (int y = std::max(y_begin, sy - reach); y <= std::min(y_end - 1, sy + reach); ++y) {
            const double fy = weight_y[index_of(y - sy + reach)];
            if (fy == 0) continue;
            for (int x = std::max(0, sx - reach); x <= std::min(width - 1, sx + reach); ++x) {
              const double f = fy * static_cast<double>(weight_x[index_of(x - sx + reach)]);
              const std::size_t pixel =
                  static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
              weight[pixel] += f;
              sum_rgb[3 * pixel] += f * static_cast<double>(value.r);
              sum_rgb[3 * pixel + 1] += f * static_cast<double>(value.g);
              sum_rgb[3 * pixel + 2] += f * static_cast<double>(value.b);
            }
          }
        }
  });
}

}  // namespace myrialux
