// Warps of the unit square follow their densities; corners of the square stay inside the domain.
#include "myrialux/math/warp.h"

#include <gtest/gtest.h>

#include "myrialux/base/rng.h"
#include "support/chi_square.h"

namespace myrialux::testing {
namespace {

constexpr int kSamples = 200000;
constexpr float kLast = 0x1.fffffep-1f;  // largest number below 1
const double kLevel = chi_square_level(12);

template <class Map>
ChiSquareResult test_directions(const std::string& name, const Map& map, const std::function<double(Vec3)>& density) {
  Rng rng({11, 0}, Stage::test, 0);
  const auto draw = [&](int) -> std::optional<Vec3> {
    const float x = rng.next(), y = rng.next();
    return map(Vec2{x, y});
  };
  return chi_square_directions(name, kSamples, kLevel, draw, density);
}

/// Chi-square of points whose two coordinates should be uniform on the unit square.
template <class Unwarp>
ChiSquareResult test_uniform_square(const Unwarp& unwarped_sample) {
  constexpr std::size_t kCells = 20;
  Rng rng({12, 0}, Stage::test, 0);
  std::vector<double> observed(kCells * kCells), expected(kCells * kCells, double{kSamples} / (kCells * kCells));
  for (int i = 0; i < kSamples; ++i) {
    const float x = rng.next(), y = rng.next();
    const Vec2 p = unwarped_sample(Vec2{x, y});
    const auto cell = [](float t) {
      return std::min(kCells - 1, static_cast<std::size_t>(std::max(0.0f, t) * kCells));
    };
    observed[cell(p.y) * kCells + cell(p.x)] += 1;
  }
  return chi_square_counts(observed, expected);
}

TEST(Warp, DiscIsUniform) {
  const ChiSquareResult result = test_uniform_square([](Vec2 u) {
    const Vec2 d = sample_disc(u);
    return Vec2{d.x * d.x + d.y * d.y, std::atan2(d.y, d.x) / (2 * kPi) + 0.5f};  // squared radius, angle
  });
  EXPECT_GE(result.p_value, kLevel) << result.message;
}

TEST(Warp, TriangleIsUniform) {
  const ChiSquareResult result = test_uniform_square([](Vec2 u) {
    const Vec2 b = sample_triangle(u);
    const float rest = 1 - b.x;  // share of the area beyond b1 is its square; b2 is uniform along the rest
    return Vec2{rest * rest, rest > 0 ? b.y / rest : 0};
  });
  EXPECT_GE(result.p_value, kLevel) << result.message;
}

TEST(Warp, CosineHemisphereFollowsItsDensity) {
  const ChiSquareResult result = test_directions("cosine_hemisphere", sample_cosine_hemisphere,
                                                 [](Vec3 d) { return cosine_hemisphere_pdf_omega(d.z); });
  EXPECT_GE(result.p_value, kLevel) << result.message;
}

TEST(Warp, SphereFollowsItsDensity) {
  const ChiSquareResult result =
      test_directions("sphere", sample_sphere, [](Vec3) { return 1 / (4 * 3.14159265358979); });
  EXPECT_GE(result.p_value, kLevel) << result.message;
}

TEST(Warp, ConeIsUniform) {
  for (const float cos_max : {-0.5f, 0.0f, 0.7f, 0.99f}) {
    const ChiSquareResult result = test_uniform_square([&](Vec2 u) {
      const Vec3 d = sample_cone(u, cos_max);
      return Vec2{(1 - d.z) / (1 - cos_max), std::atan2(d.y, d.x) / (2 * kPi) + 0.5f};  // share of the area, angle
    });
    EXPECT_GE(result.p_value, kLevel) << cos_max << ": " << result.message;
    EXPECT_NEAR(cone_pdf_omega(cos_max) * 2 * kPi * (1 - cos_max), 1, 1e-6f);
  }
}

TEST(Warp, CornersOfTheSquareStayInside) {
  for (const float x : {0.0f, 0.5f, kLast})
    for (const float y : {0.0f, 0.5f, kLast}) {
      const Vec2 u{x, y}, disc = sample_disc(u), triangle = sample_triangle(u);
      EXPECT_LE(disc.x * disc.x + disc.y * disc.y, 1 + 1e-6f);
      EXPECT_TRUE(triangle.x >= 0 && triangle.y >= 0 && triangle.x + triangle.y <= 1) << x << ' ' << y;
      for (const Vec3 d : {sample_cosine_hemisphere(u), sample_sphere(u), sample_cone(u, 0.3f)})
        EXPECT_NEAR(length(d), 1, 1e-6f);
      EXPECT_GE(sample_cosine_hemisphere(u).z, 0);
      EXPECT_GE(sample_cone(u, 0.3f).z, 0.3f - 1e-6f);
    }
}

}  // namespace
}  // namespace myrialux::testing
