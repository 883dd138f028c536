// Distances of all pairs; the nearest are kept in order by insertion.
#include "myrialux/completion/block_neighbours.h"

#include <algorithm>
#include <limits>

namespace myrialux {
namespace {

/// Means of the rows of each block; blocks beyond the rows lie at their number.
std::vector<RowPoint> middles_of_blocks(const EntrySource& source, std::size_t n_blocks) {
  const std::span<const RowPoint> points = source.row_points();
  std::vector<RowPoint> middles(n_blocks);
  for (std::size_t b = 0; b < n_blocks; ++b) {
    const std::size_t first = std::min(b * kRowsInBlock, source.n_rows()),
                      end = std::min(first + kRowsInBlock, source.n_rows());
    if (points.empty() || first == end) {
      middles[b] = {static_cast<float>(b), 0, 0};
      continue;
    }
    for (std::size_t i = first; i < end; ++i)
      for (std::size_t a = 0; a < 3; ++a) middles[b][a] += points[i][a] / static_cast<float>(end - first);
  }
  return middles;
}

float squared_distance(const RowPoint& p, const RowPoint& q) {
  const float x = p[0] - q[0], y = p[1] - q[1], z = p[2] - q[2];
  return x * x + y * y + z * z;
}

}  // namespace

BlockNeighbours::BlockNeighbours(const EntrySource& source, std::size_t n_blocks, std::size_t count)
    : words_((n_blocks + 63) / 64), near_(n_blocks * words_) {
  if (count == 0) return;
  const std::vector<RowPoint> middles = middles_of_blocks(source, n_blocks);
  struct Near {
    float distance;
    std::size_t block;
  };
  std::vector<Near> nearest(count);  // ascending
  for (std::size_t b = 0; b < n_blocks; ++b) {
    std::fill(nearest.begin(), nearest.end(), Near{std::numeric_limits<float>::infinity(), n_blocks});
    for (std::size_t o = 0; o < n_blocks; ++o) {
      const float distance = squared_distance(middles[b], middles[o]);
      if (o == b || !(distance < nearest.back().distance)) continue;
      std::size_t k = count - 1;
      for (; k > 0 && distance < nearest[k - 1].distance; --k) nearest[k] = nearest[k - 1];
      nearest[k] = {distance, o};
    }
    for (const Near& near : nearest)
      if (near.block < n_blocks) near_[b * words_ + near.block / 64] |= std::uint64_t{1} << near.block % 64;
  }
}

}  // namespace myrialux
