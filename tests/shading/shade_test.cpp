// Sums of slices by kernels against sums of transfer() entry by entry, on every instruction set of this machine.
#include "myrialux/shading/shade.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "myrialux/base/parallel.h"
#include "myrialux/kernels/isa.h"
#include "myrialux/kernels/shade_block.h"
#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

const std::vector<LightKind> kAllKinds = {LightKind::oriented, LightKind::glossy, LightKind::point,
                                          LightKind::directional};

/// A room with every kind of row and light; metals of gold, some rows too smooth for virtual lights.
class Slice {
 public:
  Slice(std::size_t n_rows, std::size_t n_columns, Microfacets distribution, float tilt = 0.2f,
        std::vector<LightKind> kinds = kAllKinds, bool glossy = true)
      : room_(std::make_shared<test::Room>(test::RoomOptions{.n_receivers = n_rows,
                                                             .n_lights = n_columns,
                                                             .kinds = std::move(kinds),
                                                             .glossy = glossy,
                                                             .glass = glossy,
                                                             .blinn_phong = glossy ? 0.2f : 0,
                                                             .shading_tilt = tilt})),
        scene_(room_->world().scene),
        receivers(room_->receivers),
        lights(room_->lights) {
    for (Material& m : scene_.materials) {
      m.distribution = distribution;
      if (m.kind == BsdfKind::rough_conductor) m.eta_metal = {0.18f, 0.42f, 1.37f}, m.k_metal = {3.42f, 2.35f, 1.77f};
    }
    for (std::size_t i = 0; i < n_rows; i += 11) receivers.bsdf[i].alpha = 0.05f;
    turn_glass_lights();
    rows.resize(n_rows);
    for (std::size_t i = 0; i < n_rows; ++i) rows[i] = static_cast<ReceiverId>(i);
    for (std::size_t c = 0; c < n_columns; ++c)
      columns.push_back({.light = static_cast<LightId>(c), .weight = 1 + 0.3f * static_cast<float>(c % 7)});
    // As light_cut orders them
    std::stable_sort(columns.begin(), columns.end(), [&](const Column& a, const Column& b) {
      return lights.kind[index(a.light)] < lights.kind[index(b.light)];
    });
  }

  World world() const {
    const World plain = room_->world();
    return {.scene = scene_, .tracer = plain.tracer, .emitters = plain.emitters};
  }
  std::vector<Rgb> shade(const BitMatrix& visible, float clamp, ShadeResult* result = nullptr) const {
    std::vector<Rgb> radiance(rows.size(), gray(-1));
    const ShadeResult r = shade_slice(world(), receivers, rows, lights, columns, visible, {clamp}, radiance);
    if (result) *result = r;
    return radiance;
  }
  std::vector<Rgb> shade_plain(const BitMatrix& visible, float clamp) const {
    std::vector<Rgb> radiance(rows.size());
    shade_slice_plain(world(), receivers, rows, lights, columns, visible, {clamp}, radiance);
    return radiance;
  }
  /// W T of entry (i, c), and what rounding errors are relative to: the same without cosines and BSDF.
  Rgb entry(std::size_t i, std::size_t c, float clamp) const {
    return columns[c].weight * transfer(world(), receivers, rows[i], lights, columns[c].light, clamp);
  }
  double scale(std::size_t i, std::size_t c, float clamp) const {
    const std::size_t j = index(columns[c].light);
    const double light = double{columns[c].weight} * double{max_component(lights.light[j])};
    if (lights.kind[j] == LightKind::directional) return light;
    const double d2 = double{length_squared(lights.p[j] - receivers.p[i])};
    return light / std::max(d2, double{clamp} * double{clamp});
  }

 private:
  /// Glass lights in turn reflect into the room, refract into it from the outside, or stand the other way round.
  void turn_glass_lights() {
    std::size_t turn = 0;
    for (std::size_t j = 0; j < lights.size(); ++j) {
      if (lights.kind[j] != LightKind::glossy) continue;
      VirtualLights::Glossy& glossy = lights.glossy[lights.extra[j]];
      if (!transmits(world(), glossy.bsdf)) continue;
      if (++turn % 4 != 0) lights.n[j] = -lights.n[j], lights.ng[j] = -lights.ng[j];
      if (turn % 4 != 1) glossy.wi = -glossy.wi;
    }
  }

  std::shared_ptr<test::Room> room_;
  Scene scene_;

 public:
  Receivers receivers;
  VirtualLights lights;
  std::vector<ReceiverId> rows;
  std::vector<Column> columns;
};

enum class Mask { none, all, random };
BitMatrix make_mask(std::size_t n_rows, std::size_t n_columns, Mask mask) {
  BitMatrix visible(n_rows, n_columns);
  Rng rng({5}, Stage::test, n_rows * 1000 + n_columns);
  for (std::size_t c = 0; c < n_columns; ++c)
    for (std::size_t i = 0; i < n_rows; ++i)
      if (mask == Mask::all || (mask == Mask::random && rng.below(2))) visible.set(i, c);
  return visible;
}

double largest_difference(Rgb a, Rgb b) {
  return std::max({std::fabs(double{a.r} - double{b.r}), std::fabs(double{a.g} - double{b.g}),
                   std::fabs(double{a.b} - double{b.b})});
}

/// Bound of the relative error of one entry. Directions carry errors of some 4 roundings, half vectors of refraction
/// up to 1 / (eta - 1) = 2 times more; lobes of alpha >= 0.11 change by at most 4 / alpha = 36 times the angle.
/// 4 * 2 * 36 * 6e-8 = 1.7e-5; measured 1.6e-5.
constexpr double kEntryError = 3e-5;

class ShadeSlice : public testing::TestWithParam<std::tuple<std::int64_t, Microfacets>> {
 protected:
  void SetUp() override { force_isa(std::get<0>(GetParam())); }
  void TearDown() override { force_isa(0); }
  static Microfacets distribution() { return std::get<1>(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Isa, ShadeSlice,
                         testing::Combine(testing::ValuesIn(available_isas()),
                                          testing::Values(Microfacets::ggx, Microfacets::beckmann)),
                         [](const auto& p) {
                           return isa_name(std::get<0>(p.param)) +
                                  (std::get<1>(p.param) == Microfacets::ggx ? "Ggx" : "Beckmann");
                         });

TEST_P(ShadeSlice, EveryEntryEqualsTransferForAllBsdfsAndLights) {
  for (const float tilt : {0.0f, 0.3f}) {
    const Slice slice(1024, 100, distribution(), tilt);
    for (const float clamp : {0.0f, 0.3f})
      for (std::size_t c = 0; c < slice.columns.size(); ++c) {
        BitMatrix one(1024, slice.columns.size());
        for (std::size_t i = 0; i < 1024; ++i) one.set(i, c);
        const std::vector<Rgb> radiance = slice.shade(one, clamp);
        for (std::size_t i = 0; i < 1024; ++i) {
          const Rgb expected = slice.entry(i, c, clamp);
          const double bound = kEntryError * (double{max_component(expected)} + slice.scale(i, c, clamp));
          ASSERT_LE(largest_difference(radiance[i], expected), bound)
              << "row " << i << " of material " << index(slice.receivers.bsdf[i].material) << ", column " << c
              << " of kind " << static_cast<int>(slice.lights.kind[index(slice.columns[c].light)]);
        }
      }
  }
}

TEST_P(ShadeSlice, EqualsThePlainSumAtOddSizesForAllMasks) {
  const std::size_t row_counts[] = {1, 15, 16, 17, 63, 64, 65, 1000, 1024}, column_counts[] = {1, 2, 9, 61, 300};
  const Slice all(1024, 300, distribution());
  for (const float clamp : {0.0f, 0.3f}) {
    for (const std::size_t n_columns : column_counts) {
      // Rows and columns from the middle, so that kinds begin at other places.
      Slice slice = all;
      const auto first_column = slice.columns.begin() + static_cast<std::ptrdiff_t>((300 - n_columns) / 2);
      slice.columns = {first_column, first_column + static_cast<std::ptrdiff_t>(n_columns)};
      std::vector<Rgb> entries(1024 * n_columns);
      std::vector<double> scales(entries.size());
      for (std::size_t i = 0; i < 1024; ++i)
        for (std::size_t c = 0; c < n_columns; ++c)
          entries[i * n_columns + c] = slice.entry(i, c, clamp), scales[i * n_columns + c] = slice.scale(i, c, clamp);
      for (const std::size_t n_rows : row_counts) {
        const std::size_t first = (1024 - n_rows) / 3;
        slice.rows.assign(all.rows.begin() + static_cast<std::ptrdiff_t>(first),
                          all.rows.begin() + static_cast<std::ptrdiff_t>(first + n_rows));
        for (const Mask mask : {Mask::none, Mask::all, Mask::random}) {
          const BitMatrix visible = make_mask(n_rows, n_columns, mask);
          ShadeResult result;
          const std::vector<Rgb> radiance = slice.shade(visible, clamp, &result);
          double luminance_sum = 0;
          for (std::size_t i = 0; i < n_rows; ++i) {
            Rgb expected;
            double scale = 0;
            for (std::size_t c = 0; c < n_columns; ++c)
              if (visible.test(i, c)) {
                expected += entries[(first + i) * n_columns + c];
                scale += double{max_component(entries[(first + i) * n_columns + c])};
                scale += scales[(first + i) * n_columns + c];
              }
            // Both running sums round once a term.
            const double bound = (kEntryError + static_cast<double>(n_columns) * 1.2e-7) * scale;
            ASSERT_LE(largest_difference(radiance[i], expected), bound) << n_rows << " x " << n_columns;
            luminance_sum += double{luminance(radiance[i])};
          }
          EXPECT_NEAR(result.radiance_sum, luminance_sum, 1e-6 * luminance_sum);
          if (mask == Mask::none) {
            EXPECT_EQ(result.radiance_sum, 0);
          }
        }
      }
    }
  }
}

TEST_P(ShadeSlice, PlainTwinSumsTransfer) {
  const Slice slice(65, 37, distribution());
  const BitMatrix visible = make_mask(65, 37, Mask::random);
  const std::vector<Rgb> plain = slice.shade_plain(visible, 0.2f), kernels = slice.shade(visible, 0.2f);
  for (std::size_t i = 0; i < 65; ++i) {
    Rgb expected;
    double scale = 0;
    for (std::size_t c = 0; c < 37; ++c)
      if (visible.test(i, c)) {
        expected += slice.entry(i, c, 0.2f);
        scale += double{max_component(slice.entry(i, c, 0.2f))} + slice.scale(i, c, 0.2f);
      }
    EXPECT_EQ(plain[i], expected);
    EXPECT_LE(largest_difference(kernels[i], plain[i]), (kEntryError + 37 * 1.2e-7) * scale);
  }
}

TEST_P(ShadeSlice, TwiceTheWeightsGiveExactlyTwiceTheLight) {
  Slice slice(200, 90, distribution());
  const BitMatrix visible = make_mask(200, 90, Mask::random);
  ShadeResult once_result, twice_result;
  const std::vector<Rgb> once = slice.shade(visible, 0.2f, &once_result);
  for (Column& column : slice.columns) column.weight *= 2;
  const std::vector<Rgb> twice = slice.shade(visible, 0.2f, &twice_result);
  for (std::size_t i = 0; i < 200; ++i) EXPECT_EQ(twice[i], 2 * once[i]);
  EXPECT_EQ(twice_result.radiance_sum, 2 * once_result.radiance_sum);
  EXPECT_EQ(twice_result.clamped_away_sum, 2 * once_result.clamped_away_sum);
}

TEST_P(ShadeSlice, ClampedAwayLightIsTheDifferenceOnTrackedRows) {
  const std::size_t n = 300;
  const Slice slice(n, 80, distribution());
  const BitMatrix visible = make_mask(n, 80, Mask::random);
  ShadeResult result, unclamped;
  slice.shade(visible, 0.5f, &result);
  slice.shade(visible, 0, &unclamped);
  double removed = 0, whole = 0, n_tracked = 0;
  for (std::size_t i = 0; i < n; ++i)
    if (is_tracked_row(i)) {
      n_tracked += 1;
      for (std::size_t c = 0; c < 80; ++c)
        if (visible.test(i, c)) {
          whole += double{luminance(slice.entry(i, c, 0))};
          removed += double{luminance(slice.entry(i, c, 0))} - double{luminance(slice.entry(i, c, 0.5f))};
        }
    }
  ASSERT_GT(n_tracked, 0);
  ASSERT_GT(removed, 0.01 * whole);
  EXPECT_NEAR(result.clamped_away_sum, removed * static_cast<double>(n) / n_tracked,
              1e-4 * whole * static_cast<double>(n) / n_tracked);
  EXPECT_EQ(unclamped.clamped_away_sum, 0);
}

TEST_P(ShadeSlice, ReceiversOnLightsStayFinite) {
  Slice slice(256, 64, distribution());
  for (std::size_t i = 0; i < 256; ++i) {
    // Every row sits on a light or one float beside it, some with the light's own normal.
    const Vec3 p = slice.lights.p[i % 64];
    slice.receivers.p[i] = i % 2 ? p : Vec3{std::nextafter(p.x, 9.0f), p.y, std::nextafter(p.z, -9.0f)};
  }
  for (const float clamp : {0.0f, 1e-3f, 0.5f}) {
    ShadeResult result;
    const std::vector<Rgb> radiance = slice.shade(make_mask(256, 64, Mask::all), clamp, &result);
    for (const Rgb& c : radiance) {
      EXPECT_TRUE(is_finite(c));
      EXPECT_GE(std::min({c.r, c.g, c.b}), 0);
    }
    EXPECT_TRUE(std::isfinite(result.radiance_sum) && std::isfinite(result.clamped_away_sum));
    EXPECT_GE(result.clamped_away_sum, 0);
  }
}

TEST_P(ShadeSlice, SameBitsForAnyNumberOfThreads) {
  const Slice slice(130, 70, distribution());
  const BitMatrix visible = make_mask(130, 70, Mask::random);
  const std::vector<Rgb> alone = slice.shade(visible, 0.2f);
  for (const int n_threads : {1, 2, 7}) {
    const ThreadScope scope(n_threads);
    std::vector<std::vector<Rgb>> radiance(20);
    parallel_for(20, [&](std::size_t k) { radiance[k] = slice.shade(visible, 0.2f); });
    for (const std::vector<Rgb>& r : radiance) EXPECT_EQ(r, alone);
  }
}

TEST_P(ShadeSlice, ARowGivesTheSameBitsAloneAsAmongOthers) {
  const Slice slice(130, 70, distribution());
  const std::vector<Rgb> together = slice.shade(make_mask(130, 70, Mask::all), 0.2f);
  for (const std::size_t i : {0u, 5u, 63u, 64u, 129u}) {
    Slice one = slice;
    one.rows = {slice.rows[i]};
    EXPECT_EQ(one.shade(make_mask(1, 70, Mask::all), 0.2f)[0], together[i]);
  }
}

TEST_P(ShadeSlice, DiffuseSlicesNeedNoOtherKernel) {
  const Slice slice(100, 50, distribution(), 0, {LightKind::oriented}, false);
  const BitMatrix visible = make_mask(100, 50, Mask::random);
  const std::vector<Rgb> radiance = slice.shade(visible, 0.1f), plain = slice.shade_plain(visible, 0.1f);
  for (std::size_t i = 0; i < 100; ++i) {
    double scale = 0;
    for (std::size_t c = 0; c < 50; ++c) scale += visible.test(i, c) ? slice.scale(i, c, 0.1f) : 0;
    EXPECT_LE(largest_difference(radiance[i], plain[i]), 66 * 6e-8 * scale);
  }
}

TEST_P(ShadeSlice, NothingLitIsBlack) {
  Slice slice(20, 3, distribution());
  slice.columns.clear();
  for (const Rgb& c : slice.shade(BitMatrix(20, 0), 0.1f)) EXPECT_EQ(c, Rgb{});
  // The back of a one-sided opaque surface
  Slice back(64, 8, distribution(), 0, kAllKinds, false);
  std::fill(back.receivers.inside.begin(), back.receivers.inside.end(), std::uint8_t{1});
  for (const Rgb& c : back.shade(make_mask(64, 8, Mask::all), 0.1f)) EXPECT_EQ(c, Rgb{});
}

}  // namespace
}  // namespace myrialux
