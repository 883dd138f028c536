// What one pass would err by at some receivers of a slice, estimated from a few lights that are joined with them: the
// variance of another set of lights, and that of another draw of representatives. Ours; docs/clusters_auto.md.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/methods/render.h"

namespace myrialux {

/// Estimates for each of some receivers: luminance towards the camera, beta included.
struct RowEstimates {
  std::vector<double> value;  ///< [rows]
  std::uint64_t rays = 0;     ///< shadow rays it took
};

/// Light of all lights and its variance between light sets.
struct LightSetEstimates {
  std::vector<double> radiance, variance;  ///< [rows]
  std::uint64_t rays = 0;
};

/// Draws of one slice. Keeps references to what they refer to.
class PassErrors {
 public:
  /// @param rows at most 64 @param clamp_distance as CutParams
  PassErrors(const FrameView& frame, const LightTree& tree, std::vector<ReceiverId> rows, float clamp_distance);

  std::size_t n_rows() const { return rows_.size(); }

  /// With x_w the light of walk w, n walks differ from other n by a variance of n / (n - 1) (sum_w x_w^2 - (sum_w
  /// x_w)^2 / n). Of each node of the cut one light is drawn by importance, and its whole walk is traced:
  ///   sum_w x_w^2 = sum_j x_j x_w(j) = E[sum_nodes I_node / I_j x_j x_w(j)].
  /// Unbiased but for (sum x)^2 / n, which is small, from the same draw. @param n_walks count_walks()
  LightSetEstimates light_set(std::span<const std::uint32_t> nodes, double n_walks, Rng rng) const;

  /// A node is stood for by light j with probability I_j / I, times I / I_j; two such draws differ by twice the
  /// variance in the mean of squares. Draws of different nodes are independent: variances add up. Unbiased.
  /// @param most nodes that are drawn from; of a larger cut, evenly spaced ones stand for all
  RowEstimates clusters(std::span<const std::uint32_t> nodes, std::size_t most, Rng rng) const;

 private:
  std::vector<float> join(std::span<const LightId> lights, std::uint64_t& rays) const;

  FrameView frame_;
  const LightTree& tree_;
  std::vector<ReceiverId> rows_;
  float clamp_distance_;
};

}  // namespace myrialux
