// Discrete and piecewise-constant distributions over one and two dimensions, by inverted cumulative sums.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/math/vec.h"

namespace myrialux {

/// Picks index i with probability weight[i] / sum. Weights >= 0, not all 0.
class Distribution1D {
 public:
  Distribution1D() = default;
  explicit Distribution1D(std::span<const float> weights);
  struct Sample {
    std::size_t index;
    float probability;  ///< of that index
    float reused;       ///< u stretched to [0, 1) within the index
  };
  Sample sample(float u) const;
  float probability(std::size_t i) const {
    return static_cast<float>((cumulative_[i + 1] - cumulative_[i]) / cumulative_.back());
  }
  std::size_t size() const { return cumulative_.empty() ? 0 : cumulative_.size() - 1; }
  double sum() const { return cumulative_.empty() ? 0 : cumulative_.back(); }

 private:
  std::vector<double> cumulative_;  ///< [n + 1], from 0
  /// Where in `cumulative_` the search for u in [k / m, (k + 1) / m] begins and ends: [m + 1], m a power of two.
  std::vector<std::uint32_t> guide_;
};

/// Piecewise-constant density over the unit square, rows of cells; density per unit area.
class Distribution2D {
 public:
  Distribution2D() = default;
  Distribution2D(std::span<const float> weights, std::size_t width, std::size_t height);
  struct Sample {
    Vec2 uv;
    float pdf_uv;  ///< per unit area of the square
  };
  Sample sample(Vec2 u) const;
  float pdf_uv(Vec2 uv) const;
  double sum() const { return rows_.sum(); }

 private:
  std::size_t width_ = 0, height_ = 0;
  std::vector<Distribution1D> columns_;
  Distribution1D rows_;
};

}  // namespace myrialux
