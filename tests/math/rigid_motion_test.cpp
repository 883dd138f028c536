// Rigid motion between placements: ends, rigidity, even speed, the shorter way.
#include "myrialux/math/rigid_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "myrialux/base/rng.h"

namespace myrialux {
namespace {

Transform random_placement(Rng& rng, bool mirrored) {
  const Vec3 axis{rng.next() - 0.5f, rng.next() - 0.5f, rng.next() - 0.5f};
  const Transform rotation = Transform::rotate(axis, 720 * rng.next() - 360);
  const Transform mirror = Transform::scale({mirrored ? -1.0f : 1.0f, 1, 1});
  return Transform::translate({9 * rng.next(), 9 * rng.next(), -9 * rng.next()}) * rotation * mirror;
}

double largest_difference(const Transform& a, const Transform& b) {
  double worst = 0;
  for (std::size_t k = 0; k < 16; ++k) worst = std::max(worst, std::fabs(a.rows()[k] - b.rows()[k]));
  return worst;
}

TEST(RigidMotion, BeginsAndEndsAtItsPlacementsAndIsRigidBetween) {
  Rng rng({5, 0}, Stage::test, 0);
  for (int n = 0; n < 2000; ++n) {
    const bool mirrored = n % 3 == 0;
    const Transform a = random_placement(rng, mirrored), b = random_placement(rng, mirrored);
    EXPECT_LT(largest_difference(rigid_between(a, b, 0), a), 1e-12);
    EXPECT_LT(largest_difference(rigid_between(a, b, 1), b), 1e-12);
    const double share = static_cast<double>(rng.next());
    const Transform m = rigid_between(a, b, share);
    EXPECT_LT(rigidity_error(m), 1e-14);
    EXPECT_EQ(m.determinant3() < 0, mirrored);
    for (std::size_t r = 0; r < 3; ++r)
      EXPECT_NEAR(m.rows()[4 * r + 3], a.rows()[4 * r + 3] + share * (b.rows()[4 * r + 3] - a.rows()[4 * r + 3]),
                  1e-14);
  }
}

TEST(RigidMotion, TurnsEvenlyByTheShorterWay) {
  const Vec3 axis{1, -2, 0.5f};
  for (const float degrees : {1e-6f, 10.0f, 90.0f, 179.0f, 181.0f, 359.0f, -120.0f}) {
    const Transform a = Transform::rotate({0, 1, 1}, 70), b = Transform::rotate(axis, degrees) * a;
    const float turn = degrees > 180 ? degrees - 360 : degrees;
    for (const float share : {0.25f, 0.5f, 0.9f})
      EXPECT_LT(largest_difference(rigid_between(a, b, double(share)), Transform::rotate(axis, share * turn) * a), 1e-6)
          << degrees << " degrees at " << share;  // angles are floats
  }
}

TEST(RigidMotion, ScaledAndShearedPlacementsAreTold) {
  EXPECT_LT(rigidity_error(Transform::rotate({1, 2, 3}, 40) * Transform::scale({1, -1, 1})), 1e-14);
  EXPECT_NEAR(rigidity_error(Transform::scale({1, 1.1f, 1})), 0.21, 1e-6);
  EXPECT_NEAR(rigidity_error(Transform({1, 0.3, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1})), 0.3, 1e-15);
}

}  // namespace
}  // namespace myrialux
