// The triangles that blocked rays of a slice lately: many of its next rays are blocked by them, too.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "myrialux/kernels/shadow_planes.h"
#include "myrialux/math/vec.h"

namespace myrialux {

/// Of one slice. Says "blocked" only of rows whose ray a tracer finds blocked, too (see shadow_planes()).
class OccluderCache {
 public:
  /// @param starts box of the points where shadow rays of the slice begin
  explicit OccluderCache(const Box3& starts);

  /// Rows are asked about with this end from here on. Cost: some 200 operations on vectors.
  void aim(const KnownEnd& end);
  /// Whether no triangle's shadow reaches the slice: nothing is blocked.
  bool is_clear() const { return n_near_ == 0; }
  /// Rows that are known to be blocked. @param p starts of 64 rows
  std::uint64_t blocked(const float* const p[3], std::uint64_t rows) {
    return shadowed_rows(p, rows, planes_, std::span(near_).first(n_near_), counts_);
  }
  /// Replaces the triangle that settled least of late. @param corners world space
  void add(const std::array<Vec3, 3>& corners);

 private:
  void find_near();

  RowsBound rows_{};
  KnownEnd end_{};
  std::size_t size_ = 0, n_near_ = 0;
  OccluderCorners corners_{};
  ShadowPlanes planes_{};
  std::array<std::uint8_t, kOccluders> order_{};    ///< [size_] the most useful first
  std::array<std::uint8_t, kOccluders> near_{};     ///< [n_near_] those whose shadow may reach the slice
  std::array<std::uint32_t, kOccluders> counts_{};  ///< rows settled, older ones counting less
};

}  // namespace myrialux
