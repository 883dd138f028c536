// Colours of the loader against values measured with Mitsuba 3.9.1 (scalar_rgb).
#include <gtest/gtest.h>

#include <string>

#include "myrialux/scene/ior.h"
#include "myrialux/scene/spectrum.h"
#include "scene_text.h"

namespace myrialux {
namespace {

using test::load_body;

/// Relative to the larger channel: Mitsuba sums in single precision.
void expect_color(Rgb got, Rgb want, float relative = 2e-4f) {
  const float tolerance = relative * std::max(max_component(want), 1e-6f);
  EXPECT_NEAR(got.r, want.r, tolerance);
  EXPECT_NEAR(got.g, want.g, tolerance);
  EXPECT_NEAR(got.b, want.b, tolerance);
}

Rgb emitted(const std::string& radiance) {
  const test::TemporaryFolder folder;
  const Scene scene = test::load_text(folder, std::string("<scene version=\"3.0.0\">") + test::kCamera +
                                                  "<emitter type=\"constant\">" + radiance + "</emitter></scene>");
  return std::get<ConstantEmitter>(scene.emitters[0].kind).radiance;
}

Rgb reflected(const std::string& reflectance) {
  return load_body("<bsdf type=\"diffuse\">" + reflectance + "</bsdf>").materials[0].reflectance.value;
}

TEST(Color, EmissionIsThatOfMitsuba) {
  expect_color(emitted("<spectrum name=\"radiance\" value=\"16\"/>"), {19.2767f, 15.1727f, 14.5427f});
  expect_color(emitted("<spectrum name=\"radiance\" value=\"400:0.1,500:0.5,600:1,700:2\"/>"),
               {1.5381f, 0.66864f, 0.218035f});
  expect_color(emitted("<spectrum name=\"radiance\" value=\"400:0, 500:8, 600:15.6, 700:18.4\"/>"),
               {20.7108f, 10.8546f, 2.77115f});
  expect_color(emitted("<spectrum name=\"radiance\" value=\"500:1 600:1\"/>"), {0.273065f, 0.987913f, 0});
  expect_color(emitted("<rgb name=\"radiance\" value=\"3\"/>"), gray(3));
  expect_color(emitted("<float name=\"radiance\" value=\"3\"/>"), gray(3));
  expect_color(emitted("<spectrum name=\"radiance\" type=\"d65\"><float name=\"scale\" value=\"2\"/></spectrum>"),
               gray(2));
}

TEST(Color, ReflectanceIsThatOfMitsuba) {
  expect_color(reflected("<spectrum name=\"reflectance\" value=\"0.3\"/>"), gray(0.3f));
  expect_color(reflected("<spectrum name=\"reflectance\" value=\"400:0.1,500:0.5,600:0.7,700:0.2\"/>"),
               {0.628604f, 0.604581f, 0.278625f});
  expect_color(reflected("<spectrum name=\"reflectance\" value=\"400:0.78, 500:0.78, 600:0.78, 700:0.78\"/>"),
               {0.776367f, 0.77981f, 0.776029f});
  expect_color(reflected("<spectrum name=\"reflectance\" value=\"500:.5,600:.9\"/>"), {0.262775f, 0.689586f, 0});
  expect_color(reflected("<rgb name=\"reflectance\" value=\"0.1 0.2, 0.3\"/>"), {0.1f, 0.2f, 0.3f});
  expect_color(reflected("<float name=\"reflectance\" value=\".4\"/>"), gray(0.4f));
}

TEST(Color, HexadecimalAndSrgbColoursAreMadeLinear) {
  const Rgb want{1, 0.2158605f, 0.0512695f};  // ff, 80, 40 by IEC 61966-2-1
  expect_color(reflected("<rgb name=\"reflectance\" value=\"#ff8040\"/>"), want, 1e-5f);
  expect_color(reflected("<srgb name=\"reflectance\" value=\"#ff8040\"/>"), want, 1e-5f);
  expect_color(reflected("<srgb name=\"reflectance\" value=\"1 0.501960784 0.250980392\"/>"), want, 1e-5f);
}

TEST(Color, IndicesOfMetalsFromSpectraAreThoseOfMitsuba) {
  const Material m = load_body(
                         "<bsdf type=\"conductor\"><spectrum name=\"eta\" value=\"400:1.5,500:1.2,600:1,700:.8\"/>"
                         "<spectrum name=\"k\" value=\"400:3,700:5\"/></bsdf>")
                         .materials[0];
  expect_color(m.eta_metal, {0.913833f, 1.10993f, 1.36278f});
  expect_color(m.k_metal, {4.59432f, 3.95218f, 3.25681f});
}

TEST(Color, NamedMetalsAreThoseOfMitsuba) {
  const Material gold =
      load_body("<bsdf type=\"conductor\"><string name=\"material\" value=\"Au\"/></bsdf>").materials[0];
  expect_color(gold.eta_metal, {0.143036f, 0.375307f, 1.44205f}, 1e-5f);
  expect_color(gold.k_metal, {3.983f, 2.38556f, 1.60336f}, 1e-5f);
  EXPECT_GE(conductor_names().size(), 37u);
  const ConductorIndex mirror = *conductor_index("none");
  EXPECT_EQ(mirror.eta, gray(0));
  EXPECT_EQ(mirror.k, gray(1));
}

TEST(Color, NamedDielectricsAreThoseOfMitsuba) {
  EXPECT_FLOAT_EQ(*dielectric_ior("bk7"), 1.5046f);
  EXPECT_FLOAT_EQ(*dielectric_ior("diamond"), 2.419f);
  EXPECT_FLOAT_EQ(*dielectric_ior("carbon dioxide"), 1.00045f);
  EXPECT_EQ(dielectric_names().size(), 23u);
}

/// Mitsuba's RGB mode has no blackbody; the law of Stefan and Boltzmann and the locus of Planck bind ours instead.
TEST(Color, BlackbodiesRiseWithTemperatureAndTurnBlue) {
  double before = 0;
  for (const double kelvin : {1500.0, 3000.0, 5000.0, 6500.0, 10000.0}) {
    const Rgb c = blackbody_rgb(kelvin);
    EXPECT_GT(luminance(c), before);
    before = luminance(c);
    EXPECT_EQ(c.r > c.b, kelvin < 7000) << kelvin;
  }
  // Planck's law at 5000 K and 560 nm, W m^-2 sr^-1 nm^-1, times white: within the curvature of the spectrum
  EXPECT_NEAR(luminance(blackbody_rgb(5000)) / 12.75e3, 1, 0.05);
  expect_color(emitted("<spectrum name=\"radiance\" type=\"blackbody\"><float name=\"temperature\" value=\"5000\"/>"
                       "<float name=\"scale\" value=\"2\"/></spectrum>"),
               blackbody_rgb(5000) * 2);
  expect_color(emitted("<blackbody name=\"radiance\" temperature=\"5000K\" scale=\"2\"/>"), blackbody_rgb(5000) * 2);
}

}  // namespace
}  // namespace myrialux
