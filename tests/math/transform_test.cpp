// Affine maps: known maps, inverses, normals, mirrors, singular input.
#include "myrialux/math/transform.h"

#include <gtest/gtest.h>

#include "myrialux/base/error.h"

namespace myrialux {
namespace {

void expect_near(Vec3 a, Vec3 b, float tolerance = 1e-6f) {
  EXPECT_TRUE(length(a - b) <= tolerance)
      << a.x << ' ' << a.y << ' ' << a.z << " against " << b.x << ' ' << b.y << ' ' << b.z;
}

Transform mixed() {
  return Transform::translate({1, -2, 3}) * Transform::rotate({1, 2, -0.5f}, 37) * Transform::scale({2, 0.5f, -3});
}

TEST(Transform, BasicMapsDoWhatTheirNamesSay) {
  expect_near(Transform().point({1, 2, 3}), {1, 2, 3});
  expect_near(Transform::translate({1, 2, 3}).point({1, 1, 1}), {2, 3, 4});
  expect_near(Transform::translate({1, 2, 3}).vector({1, 1, 1}), {1, 1, 1});
  expect_near(Transform::scale({2, 3, 4}).point({1, 1, 1}), {2, 3, 4});
  expect_near(Transform::rotate({0, 0, 5}, 90).point({1, 0, 0}), {0, 1, 0});
  expect_near(Transform::rotate({1, 0, 0}, 90).point({0, 1, 0}), {0, 0, 1});
  expect_near(Transform::rotate({1, 1, 1}, 120).point({1, 0, 0}), {0, 1, 0});
}

TEST(Transform, ProductsApplyTheRightFactorFirst) {
  const Transform m = Transform::translate({1, 0, 0}) * Transform::scale({2, 2, 2});
  expect_near(m.point({1, 1, 1}), {3, 2, 2});
}

TEST(Transform, LookAtFacesTheTargetWithXToTheLeft) {
  const Transform m = Transform::look_at({1, 2, 3}, {1, 2, 10}, {0, 1, 0});
  expect_near(m.point({0, 0, 0}), {1, 2, 3});
  expect_near(m.vector({0, 0, 1}), {0, 0, 1});
  expect_near(m.vector({0, 1, 0}), {0, 1, 0});
  expect_near(m.vector({1, 0, 0}), {1, 0, 0});  // looking along +z with y up, +x is on the left
  EXPECT_NEAR(Transform::look_at({3, 1, 4}, {1, 5, 9}, {0.3f, 1, 0.2f}).determinant3(), 1, 1e-6);
}

TEST(Transform, InverseUndoes) {
  const Transform m = mixed(), inverse = m.inverse();
  for (const Vec3 p : {Vec3{1, 2, 3}, Vec3{-4, 0, 100}}) expect_near(inverse.point(m.point(p)), p, 2e-5f);
  const Transform product = m * inverse;
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(product.rows()[static_cast<std::size_t>(i)], i % 5 == 0 ? 1 : 0, 1e-14) << i;
  EXPECT_TRUE(inverse.is_affine());
  EXPECT_NEAR(m.determinant3() * inverse.determinant3(), 1, 1e-14);
}

TEST(Transform, SmallScalesCanBeInverted) {
  const Transform m = Transform::scale({1e-20f, 1e-20f, 1e-20f});
  expect_near(m.inverse().point(m.point({1, 2, 3})), {1, 2, 3}, 1e-5f);
}

TEST(Transform, NormalsStayPerpendicular) {
  const Transform m = mixed();
  const Vec3 u{1, 0.2f, -0.7f}, v{0.3f, 2, 0.1f}, n = cross(u, v);
  const Vec3 mapped = m.normal(n);
  EXPECT_NEAR(dot(normalize(mapped), normalize(m.vector(u))), 0, 1e-6f);
  EXPECT_NEAR(dot(normalize(mapped), normalize(m.vector(v))), 0, 1e-6f);
  // Inverse transpose = cross product of mapped edges / determinant; mirrors turn the cross product around
  const Vec3 expected = cross(m.vector(u), m.vector(v)) / static_cast<float>(m.determinant3());
  expect_near(mapped, expected, 1e-5f);
  expect_near(m.normal_transform().vector(n), mapped);
}

TEST(Transform, MirrorsHaveNegativeDeterminant) {
  EXPECT_LT(Transform::scale({-1, 1, 1}).determinant3(), 0);
  EXPECT_NEAR(mixed().determinant3(), -3, 1e-12);
}

TEST(Transform, SingularMapsAreRefused) {
  for (const Transform& m : {Transform::scale({1, 0, 1}), Transform::scale({NAN, 1, 1})}) {
    try {
      (void)m.inverse();
      ADD_FAILURE() << "no error";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::input);
    }
  }
}

TEST(Transform, AffineMeansLastRowIsThatOfTheIdentity) {
  EXPECT_TRUE(mixed().is_affine());
  EXPECT_FALSE(Transform({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0}).is_affine());
}

}  // namespace
}  // namespace myrialux
