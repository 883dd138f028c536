// Cuts the receivers into slices by a 6-D kd-tree over position and scaled normal. [wang20, 4.2]
// Deviations: the largest dimension is the one of largest variance, without strays; split points are rounded to whole
// slices (inside a slice: blocks), so that slices and blocks are full.
#include "myrialux/clusters/slices.h"

#include <algorithm>
#include <array>

#include "myrialux/base/assert.h"
#include "myrialux/base/parallel.h"

namespace myrialux {
namespace {

constexpr int kDimensions = 6;
constexpr std::size_t kSpreadSamples = 1024;
constexpr std::size_t kSerialRows = 1 << 14;  ///< below this a task costs more than it gains

/// A receiver as the tree sees it, 28 bytes; moved around whole so that every level reads memory in order.
struct Row {
  std::array<float, kDimensions> x;
  std::uint32_t index;
};

/// Where to cut n > unit rows: the multiple of `unit` nearest to the middle, never 0 nor n.
std::size_t rounded_middle(std::size_t n, std::size_t unit) {
  const std::size_t units = std::max<std::size_t>(1, (n / unit + 1) / 2);
  return units * unit;
}

/// The two dimensions of largest spread: variance with deviations cut at two standard deviations. (Between extremes, a
/// few stray rows would make a flat wall be split across its thickness.) From at most kSpreadSamples evenly spaced
/// rows.
std::array<int, 2> widest_dimensions(std::span<const Row> rows) {
  const std::size_t n = std::min(rows.size(), kSpreadSamples);
  const auto sample = [&](std::size_t s) -> const Row& { return rows[s * rows.size() / n]; };
  const float share = 1 / static_cast<float>(n);
  std::array<float, kDimensions> sum{}, sum2{}, spread{};
  for (std::size_t s = 0; s < n; ++s)
    for (int k = 0; k < kDimensions; ++k) {
      const float x = sample(s).x[k] - rows[0].x[k];
      sum[k] += x, sum2[k] += x * x;
    }
  std::array<float, kDimensions> mean{}, cut2{};
  for (int k = 0; k < kDimensions; ++k) {
    mean[k] = rows[0].x[k] + sum[k] * share;
    cut2[k] = 4 * std::max(0.0f, sum2[k] * share - sum[k] * sum[k] * share * share);
  }
  for (std::size_t s = 0; s < n; ++s)
    for (int k = 0; k < kDimensions; ++k) {
      const float d = sample(s).x[k] - mean[k];
      spread[k] += std::min(d * d, cut2[k]);
    }
  std::array<int, kDimensions> order{0, 1, 2, 3, 4, 5};
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return spread[a] > spread[b]; });
  return {order[0], order[1]};
}

void sort_into_slices(std::span<Row> rows, const SliceParams& params) {
  if (rows.size() <= params.block_rows) return;
  const std::size_t unit = rows.size() > params.max_rows ? params.max_rows : params.block_rows;
  const std::size_t middle = rounded_middle(rows.size(), unit);
  const auto [k, next] = widest_dimensions(rows);
  std::nth_element(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(middle), rows.end(),
                   [k = k, next = next](const Row& a, const Row& b) {
                     if (a.x[k] != b.x[k]) return a.x[k] < b.x[k];
                     return a.x[next] < b.x[next] || (a.x[next] == b.x[next] && a.index < b.index);
                   });
  const auto lower = [&] { sort_into_slices(rows.first(middle), params); };
  const auto upper = [&] { sort_into_slices(rows.subspan(middle), params); };
  if (rows.size() > kSerialRows) {
    parallel_invoke(lower, upper);
  } else {
    lower();
    upper();
  }
}

}  // namespace

Slices make_slices(const Receivers& receivers, float scene_radius, const SliceParams& params) {
  MYRIALUX_ASSERT(params.max_rows > 0 && params.block_rows > 0 && params.max_rows % params.block_rows == 0);
  const std::size_t n = receivers.size();
  const float scale = params.normal_weight * scene_radius;
  std::vector<Row> rows(n);
  parallel_for(
      n,
      [&](std::size_t i) {
        const Vec3 p = receivers.p[i], m = receivers.n[i] * scale;
        rows[i] = {{p.x, p.y, p.z, m.x, m.y, m.z}, static_cast<std::uint32_t>(i)};
      },
      kSerialRows);
  sort_into_slices(rows, params);

  // All slices are full but the last: cuts fall on multiples of max_rows.
  Slices slices;
  slices.order.resize(n);
  parallel_for(
      n, [&](std::size_t k) { slices.order[k] = static_cast<ReceiverId>(rows[k].index); }, kSerialRows);
  for (std::size_t begin = 0; begin < n; begin += params.max_rows)
    slices.begin.push_back(static_cast<std::uint32_t>(begin));
  slices.begin.push_back(static_cast<std::uint32_t>(n));
  return slices;
}

}  // namespace myrialux
