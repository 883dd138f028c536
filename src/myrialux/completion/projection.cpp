// Visibility repeats itself: many of the sampled rows are equal, and many of the columns in them; a decomposition's
// cost is cubic in those that differ.
#include "myrialux/completion/projection.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "myrialux/completion/eigen.h"

namespace myrialux {
namespace {

/// Vectors of bits, [n * n_words].
struct BitRows {
  Words words;
  std::size_t n_words;
  Words operator[](std::size_t k) const { return words.subspan(k * n_words, n_words); }
};

/// Numbers equal vectors alike: group_of [n], numbers in the order of first appearance. Returns how many differ.
std::size_t group_equal(const BitRows& rows, std::size_t n, std::vector<std::size_t>& group_of) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto less = [&](std::size_t a, std::size_t b) {
    const Words ra = rows[a], rb = rows[b];
    const auto [ia, ib] = std::mismatch(ra.begin(), ra.end(), rb.begin());
    return ia == ra.end() ? a < b : *ia < *ib;
  };
  std::sort(order.begin(), order.end(), less);
  group_of.assign(n, 0);
  std::vector<std::size_t> first(n);  // the first vector equal to each
  for (std::size_t k = 0; k < n; ++k) {
    const bool same = k > 0 && std::ranges::equal(rows[order[k - 1]], rows[order[k]]);
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  std::size_t n_groups = 0;
  for (std::size_t k = 0; k < n; ++k) group_of[k] = first[k] == k ? n_groups++ : group_of[first[k]];
  return n_groups;
}

}  // namespace

const std::vector<double>& BitProjection::solve(std::size_t n_rows, std::size_t n_columns, Words columns, Words x) {
  fix_eigen_blocks();
  c_.assign(n_columns, 0);
  if (n_columns == 0 || count_bits(x) == 0) return c_;

  const BitRows a{columns, words_for(n_rows)};
  const std::size_t n = group_equal(a, n_columns, column_of_);
  std::vector<double> column_weight(n);
  const std::size_t words = words_for(n);
  transposed_.assign(n_rows * words, 0);
  for (std::size_t j = 0; j < n_columns; ++j) {
    if (column_weight[column_of_[j]]++ > 0) continue;
    for_each_bit(a[j],
                 [&](std::size_t i) { set_bit(MutableWords(transposed_).subspan(i * words, words), column_of_[j]); });
  }
  const BitRows rows{transposed_, words};
  const std::size_t m = group_equal(rows, n_rows, row_of_);
  std::vector<double> row_weight(m), row_sum(m);
  std::vector<std::size_t> row_at(m);
  for (std::size_t i = 0; i < n_rows; ++i) {
    row_weight[row_of_[i]] += 1;
    row_sum[row_of_[i]] += test_bit(x, i) ? 1 : 0;
    row_at[row_of_[i]] = i;
  }

  Eigen::MatrixXd merged = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(n));
  Eigen::VectorXd target(static_cast<Eigen::Index>(m));
  for (std::size_t i = 0; i < m; ++i) {
    const double weight = std::sqrt(row_weight[i]);
    target[static_cast<Eigen::Index>(i)] = row_sum[i] / weight;
    for_each_bit(rows[row_at[i]], [&](std::size_t j) {
      merged(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = weight * std::sqrt(column_weight[j]);
    });
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(1e-10);
  decomposition.compute(merged);
  const Eigen::VectorXd t = decomposition.solve(target);
  for (std::size_t j = 0; j < n_columns; ++j)
    c_[j] = t[static_cast<Eigen::Index>(column_of_[j])] / std::sqrt(column_weight[column_of_[j]]);
  return c_;
}

}  // namespace myrialux
