// Singular values are thresholded in a subspace that is carried from round to round and grows with the rank.
#include "myrialux/completion/robust_pca.h"

#include <algorithm>
#include <cmath>

#include "myrialux/base/assert.h"
#include "myrialux/base/rng.h"
#include "myrialux/completion/eigen.h"

namespace myrialux {
namespace {

using Eigen::Index;
using Eigen::MatrixXf;

constexpr Index kSpareColumns = 8;      ///< of the subspace beyond the rank expected, for accuracy [halko11, 4.3]
constexpr int kPowerIterations = 1;     ///< a round, besides those of the rounds before
constexpr float kPenaltyGrowth = 1.2f;  ///< 1.5, usual for full matrices, leaves errors where half of D is missing

/// An orthonormal basis of the columns of m.
MatrixXf orthonormal(const MatrixXf& m) {
  return Eigen::HouseholderQR<MatrixXf>(m).householderQ() * MatrixXf::Identity(m.rows(), m.cols());
}

/// Singular value thresholding that remembers its subspace.
class Thresholding {
 public:
  Thresholding(Index n_rows, Index n_columns) : limit_(std::min(n_rows, n_columns)) { widen(kSpareColumns, n_columns); }

  /// sum_k max(s_k - threshold, 0) u_k v_k^T of m; sets the rank that is left.
  MatrixXf operator()(const MatrixXf& m, float threshold) {
    for (;;) {
      for (int k = 0; k < kPowerIterations; ++k) subspace_ = orthonormal(m.transpose() * orthonormal(m * subspace_));
      const MatrixXf left = orthonormal(m * subspace_);
      const Eigen::MatrixXd small = (left.transpose() * m).cast<double>();
      // Squared singular values; in double, so that small ones survive the square.
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(small * small.transpose());
      const Index n = small.rows();
      rank_ = 0;
      while (rank_ < n && eigen.eigenvalues()[n - 1 - rank_] > double{threshold} * threshold) ++rank_;
      if (rank_ + kSpareColumns / 2 > n && n < limit_) {
        widen(2 * n, m.cols());
        continue;
      }
      const Eigen::MatrixXd vectors = eigen.eigenvectors().rightCols(rank_);
      Eigen::VectorXd shrunk(rank_);
      for (Index k = 0; k < rank_; ++k) shrunk[k] = 1 - threshold / std::sqrt(eigen.eigenvalues()[n - rank_ + k]);
      const MatrixXf u = left * vectors.cast<float>();
      const MatrixXf sv = (shrunk.asDiagonal() * (vectors.transpose() * small)).cast<float>();
      return u * sv;
    }
  }
  Index rank() const { return rank_; }

 private:
  /// Random directions join the subspace; the same in every run.
  void widen(Index n, Index n_columns) {
    const Index before = subspace_.cols();
    n = std::min(n, limit_);
    subspace_.conservativeResize(n_columns, n);
    for (Index j = before; j < n; ++j)
      for (Index i = 0; i < n_columns; ++i) subspace_(i, j) = rng_.next() - 0.5f;
  }

  const Index limit_;
  MatrixXf subspace_;  ///< right singular vectors, nearly
  Index rank_ = 0;
  Rng rng_{{0}, Stage::visibility, 0};
};

float spectral_norm(const MatrixXf& m) {
  Eigen::VectorXf v = Eigen::VectorXf::Ones(m.cols());
  for (Index i = 0; i < v.size(); ++i)
    v[i] += 0.01f * static_cast<float>(i % 7);  // not at right angles to anything common
  float norm = 0;
  for (int k = 0; k < 12; ++k) {
    v = m.transpose() * (m * v);
    norm = v.norm();
    if (norm == 0) return 0;
    v /= norm;
  }
  return std::sqrt(norm);
}

}  // namespace

RobustPca robust_pca(std::size_t n_rows, std::size_t n_columns, std::span<const float> values,
                     std::span<const EntryKind> kind, const RobustPcaParams& params) {
  MYRIALUX_ASSERT(values.size() == n_rows * n_columns && (kind.empty() || kind.size() == values.size()));
  fix_eigen_blocks();
  RobustPca result;
  result.low_rank.assign(values.size(), 0);
  if (values.empty()) return result;
  const auto kind_of = [&](Index k) { return kind.empty() ? EntryKind::doubted : kind[static_cast<std::size_t>(k)]; };

  MatrixXf d = Eigen::Map<const MatrixXf>(values.data(), static_cast<Index>(n_rows), static_cast<Index>(n_columns));
  for (Index k = 0; k < d.size(); ++k)
    if (kind_of(k) == EntryKind::missing) d.data()[k] = 0;
  const float norm = d.norm(), largest = spectral_norm(d);
  if (norm == 0) return result;
  const float lambda = params.lambda / std::sqrt(static_cast<float>(std::max(n_rows, n_columns)));
  MatrixXf y = d / std::max(largest, d.cwiseAbs().maxCoeff() / lambda);  // [lin10, eq. 17]
  MatrixXf e = MatrixXf::Zero(d.rows(), d.cols()), a = e;
  float penalty = 1.25f / largest;
  Thresholding threshold_values(d.rows(), d.cols());

  while (result.n_iterations < params.max_iterations && !result.converged) {
    ++result.n_iterations;
    a = threshold_values(d - e + y / penalty, 1 / penalty);
    const float step = lambda / penalty;
    float squares = 0;
    for (Index k = 0; k < d.size(); ++k) {
      const EntryKind what = kind_of(k);
      const float rest = d.data()[k] - a.data()[k], r = rest + y.data()[k] / penalty;
      float& error = e.data()[k];
      if (what == EntryKind::missing)
        error = r;
      else if (what == EntryKind::doubted)
        error = r > step ? r - step : r < -step ? r + step : 0;
      const float z = rest - error;
      y.data()[k] += penalty * z;
      squares += z * z;
    }
    result.converged = std::sqrt(squares) <= params.tolerance * norm;
    penalty *= kPenaltyGrowth;
  }
  result.rank = static_cast<std::size_t>(threshold_values.rank());
  Eigen::Map<MatrixXf>(result.low_rank.data(), a.rows(), a.cols()) = a;
  return result;
}

}  // namespace myrialux
