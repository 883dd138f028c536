// Cumulative sums and their inversion, in one and two dimensions.
#include "myrialux/math/distribution.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "myrialux/base/assert.h"

namespace myrialux {
namespace {

/// Index of the cell of width 1 / n that holds t; t = 1 belongs to the last.
std::size_t cell_of(float t, std::size_t n) {
  return std::min(static_cast<std::size_t>(std::max(0.0f, t) * static_cast<float>(n)), n - 1);
}

/// Coordinate at share `reused` in [0, 1) of cell i: kept off the neighbours, into which rounding may push it.
float place_in_cell(std::size_t i, float reused, std::size_t n) {
  float t = (static_cast<float>(i) + reused) / static_cast<float>(n);
  while (t >= 1 || cell_of(t, n) > i) t = std::nextafter(t, 0.0f);
  while (cell_of(t, n) < i) t = std::nextafter(t, 1.0f);
  return t;
}

}  // namespace

Distribution1D::Distribution1D(std::span<const float> weights) : cumulative_(weights.size() + 1) {
  for (std::size_t i = 0; i < weights.size(); ++i) {
    MYRIALUX_ASSERT(weights[i] >= 0);
    cumulative_[i + 1] = cumulative_[i] + weights[i];
  }
  // Some eight weights an interval: one or two cache lines a search, which are mostly not at hand.
  const std::size_t m = std::bit_ceil(std::max<std::size_t>(1, weights.size() / 8));
  guide_.resize(m + 1);
  std::size_t above = 1;
  for (std::size_t k = 0; k <= m; ++k) {
    const double target = static_cast<float>(k) / static_cast<float>(m) * sum();
    while (above < cumulative_.size() && cumulative_[above] <= target) ++above;
    guide_[k] = static_cast<std::uint32_t>(above);
  }
}

Distribution1D::Sample Distribution1D::sample(float u) const {
  MYRIALUX_ASSERT(sum() > 0);
  const double target = u * cumulative_.back();
  const std::size_t m = guide_.size() - 1, k = std::min(static_cast<std::size_t>(u * static_cast<float>(m)), m - 1);
  // upper_bound skips entries of weight 0, which end where they begin
  const auto it = std::upper_bound(cumulative_.begin() + guide_[k], cumulative_.begin() + guide_[k + 1], target);
  std::size_t i = static_cast<std::size_t>(std::min(it, cumulative_.end() - 1) - cumulative_.begin()) - 1;
  while (cumulative_[i + 1] == cumulative_[i] && i > 0) --i;
  const double width = cumulative_[i + 1] - cumulative_[i];
  const double reused = std::clamp((target - cumulative_[i]) / width, 0.0, 0x1.fffffep-1);
  return {i, probability(i), static_cast<float>(reused)};
}

Distribution2D::Distribution2D(std::span<const float> weights, std::size_t width, std::size_t height)
    : width_(width), height_(height) {
  MYRIALUX_ASSERT(weights.size() == width * height);
  std::vector<float> row_sums(height);
  columns_.reserve(height);
  for (std::size_t y = 0; y < height; ++y) {
    columns_.emplace_back(weights.subspan(y * width, width));
    row_sums[y] = static_cast<float>(columns_.back().sum());
  }
  rows_ = Distribution1D(row_sums);
}

Distribution2D::Sample Distribution2D::sample(Vec2 u) const {
  const Distribution1D::Sample row = rows_.sample(u.y);
  const Distribution1D::Sample column = columns_[row.index].sample(u.x);
  const float w = static_cast<float>(width_), h = static_cast<float>(height_);
  return {{place_in_cell(column.index, column.reused, width_), place_in_cell(row.index, row.reused, height_)},
          row.probability * column.probability * w * h};
}

float Distribution2D::pdf_uv(Vec2 uv) const {
  const std::size_t x = cell_of(uv.x, width_), y = cell_of(uv.y, height_);
  if (columns_[y].sum() == 0) return 0;
  return rows_.probability(y) * columns_[y].probability(x) * static_cast<float>(width_ * height_);
}

}  // namespace myrialux
