// Rows said to be in a triangle's shadow, against the exact answer in double precision, on every instruction set.
#include "myrialux/kernels/shadow_planes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/kernels/isa.h"

namespace myrialux {
namespace {

struct alignas(64) Rows {
  BlockFloats p[3];
};

/// Everything within `size` of a point `away` from the origin.
struct Setting {
  Setting(Rng& rng, float size, float away, bool distant) {
    const auto coordinate = [&] { return away + size * (2 * rng.next() - 1); };
    for (std::size_t t = 0; t < kOccluders; ++t) {
      const float extent = size * std::pow(10.0f, -2 * rng.next());
      for (int a = 0; a < 3; ++a) {
        corners.v[0][a][t] = coordinate();
        for (int k = 1; k < 3; ++k) corners.v[k][a][t] = corners.v[0][a][t] + extent * (2 * rng.next() - 1);
      }
    }
    for (int a = 0; a < 3; ++a) {
      end.p[a] = distant ? rng.next() - 0.5f : coordinate();
      bound.centre[a] = coordinate();
      for (float& x : rows.p[a]) x = bound.centre[a] + 0.3f * size * (2 * rng.next() - 1);
    }
    end.distant = distant;
    bound.radius = 0.3f * size * std::sqrt(3.0f);
    bound.largest = 3 * (std::abs(away) + 1.3f * size);
  }
  OccluderCorners corners{};
  KnownEnd end{};
  RowsBound bound{};
  Rows rows{};
};

/// Least of the barycentric coordinates where the segment from a row to the end meets the triangle's plane, and of its
/// distances to both of its own ends; negative: it does not meet it.
double depth_in_shadow(const Setting& s, std::size_t t, std::size_t row) {
  double v[3][3], o[3], d[3];
  for (int a = 0; a < 3; ++a) {
    for (int k = 0; k < 3; ++k) v[k][a] = s.corners.v[k][a][t];
    o[a] = s.rows.p[a][row];
    d[a] = s.end.distant ? s.end.p[a] : s.end.p[a] - o[a];
  }
  const auto cross = [](const double* x, const double* y, double* z) {
    for (int a = 0; a < 3; ++a) z[a] = x[(a + 1) % 3] * y[(a + 2) % 3] - x[(a + 2) % 3] * y[(a + 1) % 3];
  };
  const auto dot = [](const double* x, const double* y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
  double e1[3], e2[3], from[3], p[3], q[3];
  for (int a = 0; a < 3; ++a) e1[a] = v[1][a] - v[0][a], e2[a] = v[2][a] - v[0][a], from[a] = o[a] - v[0][a];
  cross(d, e2, p), cross(from, e1, q);
  const double det = dot(e1, p), b1 = dot(from, p) / det, b2 = dot(d, q) / det, at = dot(e2, q) / det;
  const double least = std::min({b1, b2, 1 - b1 - b2, at});
  return s.end.distant ? least : std::min(least, 1 - at);
}

std::uint64_t shadowed(const Setting& s, const ShadowPlanes& planes, std::uint8_t t, std::uint64_t of) {
  std::uint32_t counts[kOccluders] = {};
  const float* const p[3] = {s.rows.p[0], s.rows.p[1], s.rows.p[2]};
  const std::uint64_t found = shadowed_rows(p, of, planes, std::span(&t, 1), counts);
  EXPECT_EQ(counts[t], static_cast<std::uint32_t>(std::popcount(found)));
  return found;
}

TEST(ShadowPlanes, HoldNoRowWhoseRayIsFreeAndMostOfTheOthers) {
  std::vector<std::uint64_t> expected;  // of the first instruction set
  for (const std::int64_t isa : available_isas()) {
    force_isa(isa);
    std::vector<std::uint64_t> got;
    Rng rng({1}, Stage::test, 0);
    std::size_t n_in = 0, n_deep = 0, n_missed = 0, n_near = 0;
    for (int round = 0; round < 4000; ++round) {
      const float away = round % 3 == 0 ? 0.0f : round % 3 == 1 ? 30.0f : -2000.0f;
      const Setting s(rng, round % 5 == 0 ? 100.0f : 1.0f, away, round % 4 == 0);
      ShadowPlanes planes;
      const std::uint32_t near = shadow_planes(s.corners, s.end, s.bound, planes);
      for (std::uint8_t t = 0; t < kOccluders; ++t) {
        const std::uint64_t found = shadowed(s, planes, t, ~std::uint64_t{0});
        got.push_back(found);
        EXPECT_TRUE(found == 0 || near >> t & 1) << "triangles left out reach no row";
        for (std::size_t row = 0; row < kBlockRows; ++row) {
          const double depth = depth_in_shadow(s, t, row);
          const bool in = found >> row & 1;
          n_near += in && !(depth > 1e-6);
          n_in += in, n_deep += depth > 0.05, n_missed += depth > 0.05 && !in;
        }
      }
    }
    if (expected.empty()) expected = got;
    EXPECT_TRUE(got == expected) << isa_name(isa);
    EXPECT_EQ(n_near, 0u) << "strictly inside, " << isa_name(isa);
    EXPECT_GT(n_in, 3000u) << isa_name(isa);
    EXPECT_LT(n_missed, n_deep / 10) << isa_name(isa) << ", of " << n_deep;
  }
  force_isa(0);
}

TEST(ShadowPlanes, OnlyRowsAskedForAndUsefulTrianglesCount) {
  Setting s = [] {
    Rng rng({2}, Stage::test, 0);
    return Setting(rng, 1, 0, false);
  }();
  // All triangles but the first two are points; those two cover all rows from above.
  s.corners = {};
  for (std::size_t t : {0u, 1u}) {
    const float x[3] = {-9, 9, 0}, y[3] = {-9, -9, 9};
    for (int k = 0; k < 3; ++k) s.corners.v[k][0][t] = x[k], s.corners.v[k][1][t] = y[k], s.corners.v[k][2][t] = 3;
  }
  s.end = {{0, 0, 5}, false};
  for (int a = 0; a < 3; ++a) s.bound.centre[a] = 0;
  for (std::size_t row = 0; row < kBlockRows; ++row)
    for (int a = 0; a < 3; ++a) s.rows.p[a][row] = 0.01f * static_cast<float>(row);
  s.bound.radius = 2, s.bound.largest = 6;
  ShadowPlanes planes;
  EXPECT_EQ(shadow_planes(s.corners, s.end, s.bound, planes), 3u);
  const std::uint64_t asked = 0x8000f00000000123;
  std::uint32_t counts[kOccluders] = {};
  const std::vector<std::uint8_t> order{5, 1, 0};
  const float* const p[3] = {s.rows.p[0], s.rows.p[1], s.rows.p[2]};
  EXPECT_EQ(shadowed_rows(p, asked, planes, order, counts), asked);
  EXPECT_EQ(counts[1], static_cast<std::uint32_t>(std::popcount(asked)));
  EXPECT_EQ(counts[0] + counts[5], 0u) << "settled before";
  s.end.p[2] = 3;  // in the triangles' own plane
  EXPECT_EQ(shadow_planes(s.corners, s.end, s.bound, planes), 0u);
  EXPECT_EQ(shadowed_rows(p, asked, planes, order, counts), 0u);
}

}  // namespace
}  // namespace myrialux
