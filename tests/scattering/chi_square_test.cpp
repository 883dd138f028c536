// Samples of every BSDF follow the density that pdf_omega() gives for them: kinds, roughnesses, angles, lobe choices.
#include <gtest/gtest.h>

#include "bsdf_cases.h"
#include "myrialux/base/rng.h"
#include "myrialux/scattering/fresnel.h"
#include "support/chi_square.h"

namespace myrialux::testing {
namespace {

constexpr int kSamples = 40000;
// wo from normal incidence to grazing, and from inside for glass
const std::vector<float> kAngles{0, 30, 60, 80, 88.5f, 110, 150, 179};

struct Selection {
  std::string name;
  Lobes lobes;
  float sharp_alpha;  ///< 0: gloss is wide; 2: gloss is sharp
};
/// Ways to ask that leave a density: the base and the gloss of a coat can be had together or each alone.
std::vector<Selection> selections(BsdfKind kind) {
  if (kind == BsdfKind::plastic) return {{"wide", Lobes::wide, 0}};
  if (kind != BsdfKind::rough_plastic && kind != BsdfKind::blinn_phong) return {{"all", Lobes::all, 0}};
  return {{"all", Lobes::all, 0}, {"diffuse", Lobes::wide, 2}, {"gloss", Lobes::sharp, 2}};
}

class BsdfChiSquare : public ::testing::TestWithParam<BsdfCase> {};

TEST_P(BsdfChiSquare, SamplesFollowTheirDensity) {
  const BsdfCase& c = GetParam();
  const double level = chi_square_level(all_cases().size() * kAngles.size() * 3);
  for (const Selection& selection : selections(c.material.kind)) {
    const Bsdf bsdf = c.bsdf(selection.sharp_alpha);
    for (const float angle : kAngles) {
      const Vec3 wo = direction(angle, 25);
      if (wo.z < 0 && !is_dielectric(c.material.kind)) continue;
      Rng rng({1, 0}, Stage::test, static_cast<std::uint64_t>(angle));
      const auto draw = [&](int) -> std::optional<Vec3> {
        const float u_lobe = rng.next(), x = rng.next(), y = rng.next();
        const BsdfSample s = sample(bsdf, wo, u_lobe, {x, y}, selection.lobes, TransportMode::radiance);
        if (s.pdf_omega > 0) return s.wi;
        return std::nullopt;
      };
      const auto density = [&](Vec3 wi) { return static_cast<double>(pdf_omega(bsdf, wi, wo, selection.lobes)); };
      const std::string name = c.name + "_" + selection.name + "_" + std::to_string(static_cast<int>(angle));
      const ChiSquareResult result = chi_square_directions(name, kSamples, level, draw, density);
      EXPECT_GE(result.p_value, level) << name << ": " << result.message;
      EXPECT_GE(result.degrees_of_freedom, 1) << name;
    }
  }
}

std::vector<BsdfCase> smooth_density_cases() {
  std::vector<BsdfCase> cases;
  for (const BsdfCase& c : all_cases())
    if (is_rough(c.material.kind) || c.material.kind == BsdfKind::plastic || c.material.kind == BsdfKind::diffuse)
      cases.push_back(c);
  return cases;
}

INSTANTIATE_TEST_SUITE_P(All, BsdfChiSquare, ::testing::ValuesIn(smooth_density_cases()),
                         [](const auto& i) { return i.param.name; });

TEST(BsdfDelta, ReflectionIsChosenAsOftenAsItReflects) {
  for (const BsdfKind kind : {BsdfKind::plastic, BsdfKind::dielectric, BsdfKind::thin_dielectric})
    for (const float angle : kAngles) {
      const Vec3 wo = direction(angle, 25);
      if (wo.z < 0 && !is_dielectric(kind)) continue;
      const Bsdf bsdf = make_case(kind, Microfacets::ggx, 0).bsdf();
      double p_reflection = 0, reflected = 0;
      constexpr int kSteps = 100000;
      for (int i = 0; i < kSteps; ++i) {
        const float u_lobe = (static_cast<float>(i) + 0.5f) / kSteps;
        const BsdfSample s = sample(bsdf, wo, u_lobe, {0.3f, 0.7f}, Lobes::all, TransportMode::radiance);
        if (!s.is_delta || s.is_transmission) continue;
        p_reflection += 1.0 / kSteps;
        reflected += s.weight.r / kSteps;
      }
      const float r =
          fresnel_dielectric(kind == BsdfKind::thin_dielectric ? std::fabs(wo.z) : wo.z, 1.5046f).reflectance;
      // Thin: r + t r t + t r r r t + ..., summed
      double expected = r;
      if (kind == BsdfKind::thin_dielectric)
        for (int k = 1; k < 400; ++k) expected += (1 - r) * (1 - r) * std::pow(r, 2 * k - 1);
      EXPECT_NEAR(reflected, expected * bsdf.specular.r, 1e-3 * expected + 2e-5) << name_of(kind) << ' ' << angle;
      if (kind != BsdfKind::plastic) {
        EXPECT_NEAR(p_reflection, expected, 2e-5) << name_of(kind) << ' ' << angle;
      }
    }
}

}  // namespace
}  // namespace myrialux::testing
