// Cuts the receivers into slices by a 6-D kd-tree over position and scaled normal. [wang20, 4.2]
// Deviations: the largest dimension is the one of largest variance, without strays; split points are rounded to whole
// slices (inside a slice: blocks), so that slices and blocks are full.
#include "myrialux/clusters/slices.h"

#include <algorithm>
#include <array>

#include "myrialux/base/assert.h"
#include "myrialux/base/parallel.h"
#include "myrialux/base/ranks.h"

namespace myrialux {
namespace {

constexpr int kDimensions = 6;
constexpr std::size_t kSpreadSamples = 1024;
constexpr std::size_t kSerialRows = 1 << 14;   ///< below this a task costs more than it gains
constexpr std::size_t kSerialSplit = 1 << 18;  ///< more rows are split by all threads
constexpr std::size_t kSplitBlock = 1 << 14;   ///< rows of a task then

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

/// By the first dimension; ties by the second, then by index, so that no two rows are alike.
struct RowOrder {
  std::array<int, 2> dimension;
  bool operator()(const Row& a, const Row& b) const {
    const auto [k, next] = dimension;
    if (a.x[k] != b.x[k]) return a.x[k] < b.x[k];
    return a.x[next] < b.x[next] || (a.x[next] == b.x[next] && a.index < b.index);
  }
};

/// Rows [begin, end) that lie on the wrong side of the middle, and how many do before them.
struct Misplaced {
  std::size_t begin, end, before;
};

/// Moves the `middle` lowest rows to the front, as std::nth_element does, but by all threads and without other memory:
/// blocks are parted on their own, then what lies on the wrong side changes places.
void split_by_all(std::span<Row> rows, std::size_t middle, const RowOrder& order) {
  const std::size_t n = rows.size(), n_blocks = (n + kSplitBlock - 1) / kSplitBlock;
  const auto x = [&](std::size_t i) { return rows[i].x[order.dimension[0]] + 0.0f; };  // -0 is 0 for the order
  const RankBin bin = rank_bins(n, std::array{middle}, x)[0];
  Array<Row> near = select<Row>(
      n, [&](std::size_t i) { return upper_bits(x(i)) == bin.upper; }, [&](std::size_t i) { return rows[i]; });
  const auto place = near.begin() + static_cast<std::ptrdiff_t>(middle - bin.before);
  std::nth_element(near.begin(), place, near.end(), order);
  const Row pivot = *place;

  std::vector<std::size_t> parted(n_blocks);  // where the rows of a block from the pivot on begin
  parallel_for(n_blocks, [&](std::size_t b) {
    const auto begin = rows.begin() + static_cast<std::ptrdiff_t>(b * kSplitBlock);
    const auto end = rows.begin() + static_cast<std::ptrdiff_t>(std::min(n, (b + 1) * kSplitBlock));
    const auto upper = std::partition(begin, end, [&](const Row& row) { return order(row, pivot); });
    parted[b] = static_cast<std::size_t>(upper - rows.begin());
  });
  std::vector<Misplaced> high, low;  // rows from the pivot on below the middle; lower rows above it
  const auto add = [](std::vector<Misplaced>& list, std::size_t begin, std::size_t end) {
    if (begin >= end) return;
    list.push_back({begin, end, list.empty() ? 0 : list.back().before + list.back().end - list.back().begin});
  };
  for (std::size_t b = 0; b < n_blocks; ++b) {
    add(high, parted[b], std::min({n, middle, (b + 1) * kSplitBlock}));
    add(low, std::max(middle, b * kSplitBlock), parted[b]);
  }
  const std::size_t n_swaps = low.empty() ? 0 : low.back().before + low.back().end - low.back().begin;
  const auto list_at = [](const std::vector<Misplaced>& list, std::size_t k) {
    return std::upper_bound(list.begin(), list.end(), k,
                            [](std::size_t i, const Misplaced& m) { return i < m.before; }) -
           1;
  };
  parallel_for((n_swaps + kSplitBlock - 1) / kSplitBlock, [&](std::size_t b) {
    const std::size_t end = std::min(n_swaps, (b + 1) * kSplitBlock);
    auto h = list_at(high, b * kSplitBlock), l = list_at(low, b * kSplitBlock);
    for (std::size_t k = b * kSplitBlock; k < end;) {
      const std::size_t from_h = k - h->before + h->begin, from_l = k - l->before + l->begin;
      const std::size_t count = std::min({end - k, h->end - from_h, l->end - from_l});
      std::swap_ranges(&rows[from_h], &rows[from_h] + count, &rows[from_l]);
      k += count;
      if (from_h + count == h->end) ++h;
      if (from_l + count == l->end) ++l;
    }
  });
}

void sort_into_slices(std::span<Row> rows, const SliceParams& params) {
  if (rows.size() <= params.block_rows) return;
  const std::size_t unit = rows.size() > params.max_rows ? params.max_rows : params.block_rows;
  const std::size_t middle = rounded_middle(rows.size(), unit);
  const RowOrder order{widest_dimensions(rows)};
  if (rows.size() > kSerialSplit)
    split_by_all(rows, middle, order);
  else
    std::nth_element(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(middle), rows.end(), order);
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
  Array<Row> rows;
  rows.resize(n);
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
