// Which rows lie in the shadow that one of a few triangles casts away from a light: by planes, without a ray.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "myrialux/kernels/shade_block.h"
#include "myrialux/kernels/shadow_ends.h"

namespace myrialux {

/// Triangles that are looked at together.
inline constexpr std::size_t kOccluders = 16;
using OccluderFloats = float[kOccluders];

/// Corners of triangles, side by side; those that do not exist have all corners in one point.
struct alignas(64) OccluderCorners {
  OccluderFloats v[3][3];  ///< [corner][axis]
};

/// A point p is in the shadow of triangle t if dot(n[k][.][t], p) + d[k][t] > 0 for all four planes k: three through
/// the light and an edge, and the triangle's own.
struct alignas(64) ShadowPlanes {
  OccluderFloats n[4][3];
  OccluderFloats d[4];
};

/// Where the rows are, as far as errors of rounding hang on it.
struct RowsBound {
  float centre[3];
  float radius;   ///< of a ball that holds all rows
  float largest;  ///< sum of the largest |x|, |y|, |z| of its points
};

/// Planes of all triangles for one end of shadow rays. They are moved inwards by about twenty times the error that a
/// tracer in single precision makes (its sums are products of an edge, a ray's length and a corner's distance), so that
/// a row in the shadow is one whose ray it finds blocked. Triangles seen edge-on and those close to the light get
/// planes that no row is within. Returns a bit for each triangle whose shadow may reach any row.
std::uint32_t shadow_planes(const OccluderCorners& corners, const KnownEnd& end, const RowsBound& rows,
                            ShadowPlanes& planes);

/// Rows of `rows` in the shadow of one of the triangles `order`, which are tried one after the other. Adds to
/// `counts` how many each has settled. Cost: 30 operations a triangle and vector of rows. Both
/// functions give the same bits on every instruction set.
/// @param p positions of 64 rows, aligned as in RowBlock
std::uint64_t shadowed_rows(const float* const p[3], std::uint64_t rows, const ShadowPlanes& planes,
                            std::span<const std::uint8_t> order, std::span<std::uint32_t, kOccluders> counts);

}  // namespace myrialux
