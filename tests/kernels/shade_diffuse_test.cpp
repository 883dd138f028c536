// The kernel of diffuse rows against its plain twin, on every instruction set of this machine.
#include "myrialux/kernels/shade_diffuse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/kernels/isa.h"

namespace myrialux {
namespace {

constexpr DiffuseLight kKinds[] = {DiffuseLight::oriented, DiffuseLight::point, DiffuseLight::directional};

class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : rng_({seed}, Stage::test, 0) {}
  float between(float a, float b) { return a + (b - a) * rng_.next(); }
  void unit(float* v) {
    const float z = between(-1, 1), r = std::sqrt(1 - z * z), phi = between(0, 6.2831853f);
    v[0] = r * std::cos(phi), v[1] = r * std::sin(phi), v[2] = z;
  }
  std::uint64_t bits() { return rng_.next_uint() | std::uint64_t{rng_.next_uint()} << 32; }

 private:
  Rng rng_;
};

RowBlock random_rows(Numbers& numbers) {
  RowBlock rows;
  for (std::size_t k = 0; k < kBlockRows; ++k) {
    float n[3], ng[3];
    numbers.unit(n), numbers.unit(ng);
    for (int axis = 0; axis < 3; ++axis)
      rows.p[axis][k] = numbers.between(-1, 1), rows.n[axis][k] = n[axis], rows.ng[axis][k] = ng[axis];
  }
  return rows;
}

std::vector<ColumnLight> random_lights(Numbers& numbers, std::size_t n) {
  std::vector<ColumnLight> lights(n);
  for (ColumnLight& light : lights) {
    numbers.unit(light.n), numbers.unit(light.ng);
    for (int k = 0; k < 3; ++k) light.p[k] = numbers.between(-1, 1), light.rgb[k] = numbers.between(0, 1);
  }
  return lights;
}

bool same(const BlockSums& a, const BlockSums& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Largest difference from the twin over the sum of the terms with both cosines 1: rounding of a cosine is relative to
/// 1, not to itself.
double worst_error(const RowBlock& rows, const DiffuseRun& run, const BlockSums& kernel, const BlockSums& plain) {
  double worst = 0;
  for (std::size_t k = 0; k < kBlockRows; ++k) {
    double scale = 1e-30, unclamped_scale = 1e-30;
    for (std::size_t c = 0; c < run.lights.size(); ++c) {
      if (!(run.visible[c] >> k & 1)) continue;
      double d2 = 0;
      for (int axis = 0; axis < 3; ++axis) d2 += std::pow(double{run.lights[c].p[axis]} - double{rows.p[axis][k]}, 2);
      const double bound = double{inverse_squared_clamp(run.clamp_distance)};
      scale += run.kind == DiffuseLight::directional ? 1 : std::min(1 / d2, bound);
      unclamped_scale += 1 / d2;
    }
    for (int axis = 0; axis < 3; ++axis) {
      const double removed = double{kernel.removed[axis][k]} - double{plain.removed[axis][k]};
      worst = std::max({worst, std::fabs(double{kernel.rgb[axis][k]} - double{plain.rgb[axis][k]}) / scale,
                        std::fabs(removed) / unclamped_scale});
    }
  }
  return worst;
}

class ShadeDiffuse : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { force_isa(GetParam()); }
  void TearDown() override { force_isa(0); }
};
INSTANTIATE_TEST_SUITE_P(Isa, ShadeDiffuse, testing::ValuesIn(available_isas()),
                         [](const auto& isa) { return isa_name(isa.param); });

TEST_P(ShadeDiffuse, AgreesWithItsPlainTwinForAllKindsMasksAndClamps) {
  Numbers numbers(1);
  const RowBlock rows = random_rows(numbers);
  for (const std::size_t n : {0u, 1u, 2u, 7u, 63u, 300u})
    for (const DiffuseLight kind : kKinds)
      for (const float clamp : {0.0f, 0.5f})
        for (const int mask : {0, 1, 2}) {
          const std::vector<ColumnLight> lights = random_lights(numbers, n);
          std::vector<std::uint64_t> visible(n);
          for (auto& word : visible) word = mask == 0 ? 0 : mask == 1 ? ~std::uint64_t{0} : numbers.bits();
          const DiffuseRun run{.kind = kind,
                               .lights = lights,
                               .visible = visible,
                               .clamp_distance = clamp,
                               .tracked = 0xffff0000ffffull};
          BlockSums kernel{}, plain{};
          shade_diffuse(rows, run, kernel), shade_diffuse_plain(rows, run, plain);
          // A term has an error of some 16 roundings, the running sum one rounding of the sum a term.
          const double bound = (16 + static_cast<double>(n)) * 6e-8;
          EXPECT_LE(worst_error(rows, run, kernel, plain), bound) << n << " lights, mask " << mask;
          if (mask == 0) {
            EXPECT_TRUE(same(kernel, BlockSums{}));
          }
          EXPECT_EQ(kernel.removed[0][16], 0) << "an untracked row";
        }
}

TEST_P(ShadeDiffuse, FlatSurfacesGiveTheSameWithAndWithoutTheGeometricTest) {
  Numbers numbers(2);
  RowBlock rows = random_rows(numbers);
  std::memcpy(rows.ng, rows.n, sizeof rows.n);
  std::vector<ColumnLight> lights = random_lights(numbers, 100);
  for (ColumnLight& light : lights) std::memcpy(light.ng, light.n, sizeof light.n);
  const std::vector<std::uint64_t> visible(100, ~std::uint64_t{0});
  for (const DiffuseLight kind : kKinds) {
    DiffuseRun run{.kind = kind, .lights = lights, .visible = visible};
    BlockSums flat{}, bumpy{};
    run.bumpy = false, shade_diffuse(rows, run, flat);
    run.bumpy = true, shade_diffuse(rows, run, bumpy);
    EXPECT_LE(worst_error(rows, run, flat, bumpy), 16 * 6e-8);
  }
}

TEST_P(ShadeDiffuse, TwiceTheLightGivesExactlyTwiceTheSum) {
  Numbers numbers(3);
  const RowBlock rows = random_rows(numbers);
  std::vector<ColumnLight> lights = random_lights(numbers, 65);
  std::vector<std::uint64_t> visible(65);
  for (auto& word : visible) word = numbers.bits();
  for (const DiffuseLight kind : kKinds) {
    BlockSums once{}, twice{};
    shade_diffuse(rows, {.kind = kind, .lights = lights, .visible = visible, .clamp_distance = 0.3f}, once);
    std::vector<ColumnLight> doubled = lights;
    for (ColumnLight& light : doubled)
      for (float& x : light.rgb) x *= 2;
    shade_diffuse(rows, {.kind = kind, .lights = doubled, .visible = visible, .clamp_distance = 0.3f}, twice);
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t k = 0; k < kBlockRows; ++k) EXPECT_EQ(twice.rgb[axis][k], 2 * once.rgb[axis][k]);
  }
}

TEST_P(ShadeDiffuse, RowsOnALightStayFinite) {
  Numbers numbers(4);
  RowBlock rows = random_rows(numbers);
  std::vector<ColumnLight> lights = random_lights(numbers, kBlockRows);
  for (std::size_t k = 0; k < kBlockRows; ++k)
    for (int axis = 0; axis < 3; ++axis) {
      // Every row sits on its light, or one float beside it.
      lights[k].p[axis] = k % 2 ? rows.p[axis][k] : std::nextafter(rows.p[axis][k], 2.0f);
      rows.ng[axis][k] = rows.n[axis][k];
    }
  const std::vector<std::uint64_t> visible(kBlockRows, ~std::uint64_t{0});
  for (const float clamp : {0.0f, 0.1f})
    for (const DiffuseLight kind : kKinds) {
      const DiffuseRun run{
          .kind = kind, .lights = lights, .visible = visible, .clamp_distance = clamp, .tracked = ~std::uint64_t{0}};
      BlockSums sums{};
      shade_diffuse(rows, run, sums);
      for (int axis = 0; axis < 3; ++axis)
        for (std::size_t k = 0; k < kBlockRows; ++k) {
          EXPECT_TRUE(std::isfinite(sums.rgb[axis][k]) && std::isfinite(sums.removed[axis][k]));
          if (clamp > 0 && kind != DiffuseLight::directional) {
            EXPECT_LE(sums.rgb[axis][k], 64 * 100 * 1.001f);
          }
        }
    }
}

}  // namespace
}  // namespace myrialux
