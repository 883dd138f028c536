// Some receivers of a slice joined with some light walks, by true visibility: what the variances of a pass can be
// estimated from, that of another set of lights and that of another draw of representatives. Ours;
// docs/clusters_auto.md has the derivation.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/lights/walks.h"
#include "myrialux/methods/render.h"

namespace myrialux {

/// All walks dealt into classes of equal size, each of them as good a sample as any: walk w is in class
/// w mod n_classes. Two numbers a light.
struct WalkClasses {
  Walks walks;
  std::uint32_t n_classes = 1;
  std::vector<std::uint32_t> places;  ///< of LightTree::order, class after class, rising within each
  std::vector<std::size_t> begin;     ///< [n_classes + 1]
  std::span<const std::uint32_t> places_of(std::uint32_t c) const {
    return std::span(places).subspan(begin[c], begin[c + 1] - begin[c]);
  }
  /// Walks that left lights, in class c.
  std::uint32_t walks_of(std::uint32_t c) const { return (walks.n_found - c + n_classes - 1) / n_classes; }
};

/// @param n_lights that a class should have; it has more where a walk leaves more than a 64th of them, and all where
/// there are no more
WalkClasses deal_walks(const VirtualLights& lights, const LightTree& tree, std::uint32_t n_lights);

/// Luminance that `rows` (at most 64) send to the camera because of the lights of one class of walks; beta included.
class LightSample {
 public:
  /// Traces every active entry. Keeps references to `classes` and `tree`. @param clamp_distance as CutParams
  LightSample(const FrameView& frame, const LightTree& tree, const WalkClasses& classes, std::uint32_t sampled_class,
              std::span<const ReceiverId> rows, float clamp_distance);

  std::size_t n_rows() const { return n_rows_; }
  std::uint64_t rays() const { return rays_; }

  /// Of all lights, summed over the rows: an unbiased estimate.
  double radiance() const { return radiance_; }
  /// Unbiased estimate of the variance that another set of as many walks would bring, summed over the rows. Needs two
  /// walks; else 0.
  double light_set_variance() const { return light_set_variance_; }
  /// Variance over draws of representatives for these disjoint nodes, summed over the rows: of a node with lights j of
  /// importance I_j and radiance X_j it is  1/2 sum_jk I_j I_k (X_j / I_j - X_k / I_k)^2  [pairs of the sample stand
  /// for all]. Unbiased but for pairs from the same walk within a node, which count too often.
  double cluster_variance(std::span<const std::uint32_t> nodes) const;

 private:
  void sum_walks(std::span<const std::uint32_t> places);

  const LightTree& tree_;
  const WalkClasses& classes_;
  std::uint32_t class_;
  std::size_t n_rows_;
  std::vector<float> x_;  ///< [places of the class x n_rows_]
  std::uint64_t rays_ = 0;
  double radiance_ = 0, light_set_variance_ = 0;
};

}  // namespace myrialux
