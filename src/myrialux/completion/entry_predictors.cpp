// Guesses work on samples in the order of rows.
#include "myrialux/completion/entry_predictors.h"

#include <algorithm>
#include <utility>

#include "myrialux/completion/eigen.h"
#include "myrialux/matrix/bit_ops.h"

namespace myrialux {
namespace {

constexpr std::size_t kNeighbours = 3, kColumnsAside = 3, kBlockRows = 16;

/// Visible and occluded samples, and their odds with one more of each.
struct Tally {
  std::size_t visible = 0, occluded = 0;
  void add(Words bits, Words traced, std::size_t word, std::uint64_t rows) {
    visible += static_cast<std::size_t>(std::popcount(bits[word] & traced[word] & rows));
    occluded += static_cast<std::size_t>(std::popcount(~bits[word] & traced[word] & rows));
  }
  double odds() const { return static_cast<double>(visible + 1) / static_cast<double>(occluded + 1); }
};

}  // namespace

bool predict_by_neighbours(const SampledBits& sampled, std::size_t j, MutableWords bits) {
  const Words visible = sampled.visible.column(j);
  std::vector<std::size_t> rows;
  for_each_bit(sampled.traced.column(j), [&](std::size_t i) { rows.push_back(i); });
  if (rows.empty()) return false;
  std::fill(bits.begin(), bits.end(), 0);
  const std::size_t n_near = std::min(kNeighbours, rows.size());
  std::size_t first = 0;  // of the n_near nearest samples, which are neighbours among the samples
  for (std::size_t i = 0; i < sampled.visible.n_rows(); ++i) {
    while (first + n_near < rows.size() && rows[first + n_near] + rows[first] <= 2 * i) ++first;
    std::size_t n_visible = 0;
    for (std::size_t k = first; k < first + n_near; ++k) n_visible += test_bit(visible, rows[k]);
    if (2 * n_visible >= n_near) set_bit(bits, i);
  }
  return true;
}

bool predict_by_plane(const SampledBits& sampled, std::size_t j, std::span<const RowPoint> points, MutableWords bits) {
  if (points.empty() || count_bits(sampled.traced.column(j)) == 0) return false;
  const Words visible = sampled.visible.column(j);
  // Measured from the first row, so that far from the origin the normal equations keep their digits.
  const auto lifted = [&](std::size_t i) {
    return Eigen::Vector4d(points[i][0] - points[0][0], points[i][1] - points[0][1], points[i][2] - points[0][2], 1);
  };
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for_each_bit(sampled.traced.column(j), [&](std::size_t i) {
    const Eigen::Vector4d p = lifted(i);
    normal += p * p.transpose();
    right += test_bit(visible, i) ? p : Eigen::Vector4d(-p);
  });
  // Rows often lie in a plane: the shortest of the best functions.
  const Eigen::Vector4d function = normal.completeOrthogonalDecomposition().solve(right);
  std::fill(bits.begin(), bits.end(), 0);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (function.dot(lifted(i)) >= 0) set_bit(bits, i);
  return true;
}

bool predict_by_columns(const SampledBits& sampled, std::size_t j, ColumnRange range, MutableWords bits) {
  if (count_bits(sampled.traced.column(j)) == 0) return false;
  const std::size_t n_words = sampled.visible.words_per_column();
  const std::size_t begin = std::max(range.begin, j < kColumnsAside ? 0 : j - kColumnsAside);
  const std::size_t end = std::min(range.end, j + kColumnsAside + 1);
  Tally own, all;
  for (std::size_t w = 0; w < n_words; ++w) {
    own.add(sampled.visible.column(j), sampled.traced.column(j), w, ~std::uint64_t{0});
    for (std::size_t c = begin; c < end; ++c)
      all.add(sampled.visible.column(c), sampled.traced.column(c), w, ~std::uint64_t{0});
  }
  for (std::size_t w = 0; w < n_words; ++w) {
    bits[w] = 0;
    for (std::size_t block = 0; block < 64; block += kBlockRows) {
      const std::uint64_t rows = low_bits(kBlockRows) << block;
      Tally row;
      for (std::size_t c = begin; c < end; ++c) row.add(sampled.visible.column(c), sampled.traced.column(c), w, rows);
      if (own.odds() * row.odds() >= all.odds()) bits[w] |= rows;
    }
  }
  return true;
}

}  // namespace myrialux
