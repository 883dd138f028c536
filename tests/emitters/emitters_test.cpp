// Emitters: conventions of Mitsuba 3.9.1, powers, and samples that follow the densities they claim.
#include "myrialux/emitters/emitters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "myrialux/base/error.h"
#include "myrialux/base/rng.h"
#include "support/build_scene.h"
#include "support/chi_square.h"
#include "support/statistics.h"

namespace myrialux {
namespace {

using testing::chi_square_counts;
using testing::chi_square_directions;
using testing::chi_square_level;

constexpr std::size_t kChiSquareTests = 24;  ///< in this program
constexpr int kSamples = 100'000;

Vec2 next_2d(Rng& rng) {
  const float x = rng.next(), y = rng.next();
  return {x, y};
}
void expect_near(Rgb found, Rgb expected, float relative) {
  const auto same = [&](float x, float y) { return std::fabs(x - y) <= relative * (std::fabs(y) + 1e-6f); };
  EXPECT_TRUE(same(found.r, expected.r) && same(found.g, expected.g) && same(found.b, expected.b))
      << found.r << ' ' << found.g << ' ' << found.b << " against " << expected.r << ' ' << expected.g << ' '
      << expected.b;
}

/// Points of the unit square must be uniform: counts in 16 x 16 cells.
struct UniformityCheck {
  std::vector<double> counts = std::vector<double>(256);
  double n = 0;
  void add(double x, double y) {
    const auto cell = [](double t) { return static_cast<std::size_t>(std::clamp(t * 16, 0.0, 15.0)); };
    counts[cell(y) * 16 + cell(x)] += 1, ++n;
  }
  void expect_uniform() const {
    const std::vector<double> expected(256, n / 256);
    const auto result = chi_square_counts(counts, expected);
    EXPECT_GT(result.p_value, chi_square_level(kChiSquareTests)) << result.message;
  }
};

double turn(double y, double x) {
  const double phi = std::atan2(y, x) / (2 * M_PI);
  return phi < 0 ? phi + 1 : phi;
}

/// The image of the 8 x 5 map whose values were measured with Mitsuba.
TextureId add_map(Scene& scene, int width = 8, int height = 5) {
  auto image = std::make_shared<Image>();
  image->width = width, image->height = height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const int v : {2 + 2 * x + 20 * y, x * x + 2, 4 + 2 * y * y})
        image->floats.push_back(0.5f * static_cast<float>(v));
  Texture texture;
  texture.name = "map";
  texture.image = image;
  scene.textures.push_back(texture);
  return static_cast<TextureId>(scene.textures.size() - 1);
}

struct Setting {
  test::SceneBuilder b;
  MaterialId material = b.diffuse(gray(0.5f));
  EmitterId add(decltype(Emitter::kind) kind) {
    Emitter e;
    e.kind = kind;
    return b.emitter(e);
  }
  EmitterId add_quadric(Quadric::Kind kind, const Transform& m, Rgb radiance, bool flip = false) {
    const ShapeId shape = b.sphere({0, 0, 0}, 1, material, flip);
    b.scene.shapes[index(shape)].geometry = Quadric{kind, m};
    return b.area_emitter(shape, radiance);
  }
  Emitters emitters() const { return Emitters(b.scene, b.scene.bounds()); }
};

TEST(Emitted, OnTheSideOfTheNormalOnly) {
  Setting w;
  const EmitterId id = w.b.area_emitter(w.b.rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, w.material), {1, 2, 3});
  const Emitters e = w.emitters();
  EXPECT_EQ(e.emitted(id, {0.5f, 0.5f}, {0, 0, 1}, {0, 0, -1}), (Rgb{1, 2, 3}));
  EXPECT_EQ(e.emitted(id, {0.5f, 0.5f}, {0, 0, 1}, {0, 0, 1}), (Rgb{}));
  EXPECT_EQ(e.emitted(id, {0.5f, 0.5f}, {0, 0, 1}, {1, 0, 0}), (Rgb{}));
  EXPECT_FALSE(e.has_environment());
  EXPECT_EQ(e.environment({0, 0, 1}), (Rgb{}));
  EXPECT_FALSE(e.sample_direct({0.3f, 0.2f, -1}, 0.5f, {0.5f, 0.5f}).has_value());
  EXPECT_TRUE(e.sample_direct({0.3f, 0.2f, 1}, 0.5f, {0.5f, 0.5f}).has_value());
}

TEST(Environment, LooksUpAsMitsuba) {
  const struct {
    bool turned;
    Vec3 direction;
    Rgb radiance;
  } measured[] = {
      {false, {.363536568f, .864299487f, .347602591f}, {15.2729435f, 6.26803589f, 4.00657272f}},
      {false, {-.790571125f, .549241633f, .270796807f}, {28.0147305f, 20.9085274f, 5.6684985f}},
      {false, {.47329009f, .04573437f, .879718627f}, {34.9335518f, 7.7683053f, 8.7378693f}},
      {false, {-.822690288f, -.181986134f, -.5385738f}, {44.3521805f, 30.8206711f, 10.7475777f}},
      {false, {.896977452f, .05949747f, -.43805422f}, {31.7453613f, 2.19117737f, 8.65890217f}},
      {true, {-.949884545f, -.312444418f, .00989135148f}, {45.3272858f, 29.4562645f, 11.3400841f}},
      {true, {-.165771814f, .778363732f, .605532499f}, {15.5341244f, 17.8646278f, 3.70642042f}},
      {true, {.874541615f, -.459198525f, -.155928397f}, {45.5393181f, 5.32099152f, 14.3554611f}},
      {true, {.910754994f, .288327868f, .295622024f}, {29.1513805f, 6.3660984f, 7.17148208f}},
  };
  for (const auto& m : measured) {
    Setting w;
    w.b.sphere({0, 0, 0}, 1, w.material);
    const Transform to_world = m.turned ? Transform::rotate({1, 2, 0.5f}, 37) : Transform();
    w.add(EnvmapEmitter{add_map(w.b.scene), 1.5f, to_world});
    expect_near(w.emitters().environment(m.direction), m.radiance, 2e-5f);
  }
}

TEST(Spot, FallsOffAsMitsuba) {
  Setting w;
  w.b.sphere({0, 0, 9}, 1, w.material);
  w.add(SpotEmitter{Transform::look_at({0, 0, 0}, {0, 0, 1}, {0, 1, 0}), {3, 2, 1}, 30, 20, kNone<TextureId>});
  const Emitters e = w.emitters();
  const struct {
    float angle_deg, red;
  } measured[] = {{0, .75f}, {10, .75f}, {19, .75f}, {22, .6f}, {25, .375f}, {28, .15f}, {29.9f, .0075f}};
  for (const auto& m : measured) {
    const float a = m.angle_deg * kPi / 180;
    const auto s = e.sample_direct({2 * std::sin(a), 0, 2 * std::cos(a)}, 0.3f, {0.5f, 0.5f});
    ASSERT_TRUE(s);
    EXPECT_TRUE(s->is_delta && !s->is_distant);
    EXPECT_NEAR(s->radiance.r, m.red, 1e-5f);
    EXPECT_EQ(s->pdf_omega, 1);
    EXPECT_NEAR(s->distance, 2, 1e-5f);
  }
  EXPECT_FALSE(e.sample_direct({2 * std::sin(0.55f), 0, 2 * std::cos(0.55f)}, 0.3f, {0.5f, 0.5f}).has_value());
  EXPECT_FALSE(e.sample_direct({0, 0, -1}, 0.3f, {0.5f, 0.5f}).has_value());
}

TEST(Directional, LightsAgainstItsDirectionOfTravel) {
  Setting w;
  w.b.sphere({0, 0, 0}, 1, w.material);
  w.add(DirectionalEmitter{{1, -2, 0.5f}, {1, 2, 3}});
  const auto s = w.emitters().sample_direct({0, 0, 0}, 0.5f, {0.5f, 0.5f});
  ASSERT_TRUE(s);
  EXPECT_LT(length(s->wi - Vec3{-.436436f, .872872f, -.218218f}), 1e-5f);
  EXPECT_EQ(s->radiance, (Rgb{1, 2, 3}));
  EXPECT_TRUE(s->is_delta && s->is_distant);
}

TEST(Power, EqualsTheAnalyticValue) {
  const Rgb L{1, 2, 3};
  Setting w;
  const Transform scaled = Transform::scale({2, 2, 2});
  std::vector<std::pair<EmitterId, float>> expected;  // power / L
  expected.emplace_back(w.b.area_emitter(w.b.rectangle({-1, -1, 5}, {2, 0, 0}, {0, 3, 0}, w.material), L), kPi * 6);
  expected.emplace_back(w.add_quadric(Quadric::Kind::sphere, scaled, L), kPi * 16 * kPi);
  expected.emplace_back(w.add_quadric(Quadric::Kind::disk, Transform::scale({2, 1, 1}), L), kPi * 2 * kPi);
  expected.emplace_back(w.add_quadric(Quadric::Kind::cylinder, Transform::scale({2, 2, 3}), L), kPi * 12 * kPi);
  expected.emplace_back(w.add(PointEmitter{{0, 0, 0}, L}), 4 * kPi);
  const float cut = 30 * kPi / 180, beam = 20 * kPi / 180;
  const float fall = (-std::sin(cut) + (cut - beam) * std::cos(beam) + std::sin(beam)) / (cut - beam);
  expected.emplace_back(w.add(SpotEmitter{Transform(), L, 30, 20, kNone<TextureId>}),
                        2 * kPi * (1 - std::cos(beam) + fall));
  const float radius = 0.5f * w.b.scene.bounds().diagonal() * (1 + 0x1p-10f);
  expected.emplace_back(w.add(DirectionalEmitter{{0, 0, 1}, L}), kPi * radius * radius);
  expected.emplace_back(w.add(ConstantEmitter{L}), 4 * kPi * kPi * radius * radius);
  const Emitters e = w.emitters();
  Rgb sum;
  for (const auto& [id, factor] : expected) {
    expect_near(e.power(id), L * factor, 2e-4f);
    sum += L * factor;
  }
  expect_near(e.power(), sum, 2e-4f);
  for (const auto& [id, factor] : expected)
    EXPECT_NEAR(e.probability(id), luminance(L * factor) / luminance(sum), 1e-4f);
}

TEST(Power, OfATexturedLampIsItsMean) {
  Setting w;
  Texture checks;
  checks.kind = Texture::Kind::checkerboard;
  checks.color0 = gray(1), checks.color1 = gray(3);
  w.b.scene.textures.push_back(checks);
  const EmitterId id = w.b.area_emitter(w.b.rectangle({0, 0, 0}, {2, 0, 0}, {0, 1, 0}, w.material), gray(1));
  std::get<AreaEmitter>(w.b.scene.emitters[0].kind).radiance.texture = static_cast<TextureId>(0);
  EXPECT_NEAR(w.emitters().power(id).g, kPi * 2 * 2, 0.02f);
}

/// One emitter of every kind, one world each.
std::vector<Setting> one_of_each() {
  std::vector<Setting> worlds(9);
  const Rgb L{1, 2, 3};
  const Transform place = Transform::translate({0.2f, -0.1f, 0.4f}) * Transform::rotate({1, 2, 3}, 50);
  worlds[0].b.area_emitter(
      worlds[0].b.mesh({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0.5f}}, {0, 1, 2, 0, 2, 3}, worlds[0].material), L);
  worlds[1].add_quadric(Quadric::Kind::sphere, place * Transform::scale({0.7f, 0.7f, 0.7f}), L);
  worlds[2].add_quadric(Quadric::Kind::disk, place * Transform::scale({0.7f, 0.4f, 0.7f}), L);
  worlds[3].add_quadric(Quadric::Kind::cylinder, place * Transform::scale({0.7f, 0.7f, 2}), L);
  worlds[4].add(PointEmitter{{1, 2, 3}, L});
  worlds[5].add(SpotEmitter{place, L, 30, 20, kNone<TextureId>});
  worlds[6].add(DirectionalEmitter{{1, -2, 0.5f}, L});
  worlds[7].add(ConstantEmitter{L});
  worlds[8].add(EnvmapEmitter{add_map(worlds[8].b.scene, 16, 9), 1, place});
  for (std::size_t k = 4; k < worlds.size(); ++k) worlds[k].b.sphere({0.5f, 0, 0}, 1.5f, worlds[k].material);
  return worlds;
}

/// @param slack relative error that is not noise
void expect_mean_power(const Setting& w, double slack) {
  const Emitters e = w.emitters();
  test::Sample green;
  for (int i = 0; i < 20'000; ++i) {
    Rng rng({1, 0}, Stage::test, static_cast<std::uint64_t>(i));
    const float pick = rng.next();
    const Vec2 a = next_2d(rng), b = next_2d(rng);
    const EmissionSample s = e.sample_emission(pick, a, b);
    green.add(s.power.g);
    ASSERT_NEAR(length(s.ray.direction), 1, 1e-5f);
    if (s.kind == EmissionSample::Kind::area) {
      ASSERT_GE(dot(s.ray.direction, s.n), 0);
      ASSERT_NEAR(s.power.g, s.light.g * kPi, 1e-3f * s.power.g);
      ASSERT_GT(s.offset, 0);
    }
    if (s.kind == EmissionSample::Kind::distant) {
      ASSERT_LT(length(s.n - s.ray.direction), 1e-5f);
    }
  }
  const double expected = e.power().g;
  EXPECT_NEAR(green.mean, expected, slack * expected + 4 * std::sqrt(green.variance_of_mean()));
}

TEST(Emission, MeanPowerIsTheEmittersPower) {
  // constant weights leave only rounding; the table of an environment map takes patches' means (1 %)
  for (const Setting& w : one_of_each()) expect_mean_power(w, w.b.scene.emitters[0].kind.index() == 2 ? 0.01 : 2e-4);
}

TEST(Emission, MeanPowerOfSeveralEmittersIsTheirSum) {
  const Rgb red{3, 1, 0.5f}, blue{0.5f, 1, 3};
  std::vector<Setting> pairs(4);  // a disc beside one of each way to start
  for (Setting& w : pairs) w.add_quadric(Quadric::Kind::disk, Transform::translate({0, 0, -1}), red);
  pairs[0].add_quadric(Quadric::Kind::sphere, Transform::translate({0, 0, 2}), blue);
  pairs[1].add(PointEmitter{{0, 0, 2}, blue});
  pairs[2].add(DirectionalEmitter{{0, 0, -1}, blue});
  pairs[3].add(ConstantEmitter{blue});
  for (const Setting& w : pairs) expect_mean_power(w, 2e-4);
}

TEST(Emission, AreaPointsAreUniformAndDirectionsFollowTheCosine) {
  const std::vector<Setting> worlds = one_of_each();
  for (std::size_t k = 0; k < 4; ++k) {
    const Setting& w = worlds[k];
    const Emitters e = w.emitters();
    UniformityCheck places, directions;
    Rng rng({2, 0}, Stage::test, k);
    for (int i = 0; i < kSamples; ++i) {
      const float pick = rng.next();
      const Vec2 a = next_2d(rng), b = next_2d(rng);
      const EmissionSample s = e.sample_emission(pick, a, b);
      const Vec3 d = Frame(s.n).to_local(s.ray.direction);
      directions.add(d.x * d.x + d.y * d.y, turn(d.y, d.x));
      if (k == 0) continue;
      const auto& q = std::get<Quadric>(w.b.scene.shapes[0].geometry);
      const Vec3 o = q.to_world.inverse().point(s.p);
      if (k == 1) places.add(0.5 * (o.z + 1), turn(o.y, o.x));
      if (k == 2) places.add(double(o.x) * o.x + double(o.y) * o.y, turn(o.y, o.x));
      if (k == 3) places.add(o.z, turn(o.y, o.x));
    }
    directions.expect_uniform();
    if (k > 0) places.expect_uniform();
  }
}

TEST(Emission, PointsOnAMeshAreUniformByArea) {
  Setting w;
  // a square cut unevenly into triangles
  const ShapeId shape = w.b.mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.2f, 0.3f, 0}},
                                 {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4}, w.material);
  w.b.area_emitter(shape, gray(1));
  const Emitters e = w.emitters();
  UniformityCheck places;
  Rng rng({3, 0}, Stage::test, 0);
  for (int i = 0; i < kSamples; ++i) {
    const float pick = rng.next();
    const Vec2 a = next_2d(rng), b = next_2d(rng);
    const EmissionSample s = e.sample_emission(pick, a, b);
    places.add(s.p.x, s.p.y);
  }
  places.expect_uniform();
}

TEST(Emission, DistantLightStartsOnADiscOutsideTheScene) {
  const std::vector<Setting> worlds = one_of_each();
  for (std::size_t k = 6; k < 9; ++k) {
    const Setting& w = worlds[k];
    const Emitters e = w.emitters();
    const Box3 bounds = w.b.scene.bounds();
    const float radius = 0.5f * bounds.diagonal() * (1 + 0x1p-10f);
    UniformityCheck places;
    Rng rng({4, 0}, Stage::test, k);
    for (int i = 0; i < kSamples; ++i) {
      const float pick = rng.next();
      const Vec2 a = next_2d(rng), b = next_2d(rng);
      const EmissionSample s = e.sample_emission(pick, a, b);
      const Vec3 d = Frame(s.n).to_local(s.p - bounds.centre()) / radius;
      ASSERT_NEAR(d.z, -1, 1e-4f);
      places.add(double(d.x) * d.x + double(d.y) * d.y, turn(d.y, d.x));
    }
    places.expect_uniform();
  }
}

TEST(Direct, EnvironmentSamplesFollowTheirDensity) {
  const std::vector<Setting> worlds = one_of_each();
  for (std::size_t k = 7; k < 9; ++k) {
    const Emitters e = worlds[k].emitters();
    Rng rng({5, 0}, Stage::test, k);
    double worst_pdf = 0, worst_ratio = 0;
    const auto result = chi_square_directions(
        k == 7 ? "constant" : "envmap", kSamples, chi_square_level(kChiSquareTests),
        [&](int) -> std::optional<Vec3> {
          const float pick = rng.next();
          const auto s = e.sample_direct({0.3f, 0.1f, 0}, pick, next_2d(rng));
          if (!s) return std::nullopt;
          worst_pdf = std::max(worst_pdf, std::fabs(e.environment_pdf_omega(s->wi) / double(s->pdf_omega) - 1));
          worst_ratio = std::max(worst_ratio, luminance(s->radiance) / double(s->pdf_omega));
          return s->wi;
        },
        [&](Vec3 d) { return e.environment_pdf_omega(d); });
    EXPECT_GT(result.p_value, chi_square_level(kChiSquareTests)) << result.message;
    if (k == 7) {
      EXPECT_LT(worst_pdf, 1e-4);
    }
    // radiance / density stays bounded: at most 4 corners / mean, twice for the slope of the sine
    const Rgb flux = e.power();
    const float radius = 0.5f * worlds[k].b.scene.bounds().diagonal();
    EXPECT_LT(worst_ratio, 8 * luminance(flux) / (kPi * radius * radius));
  }
}

/// Where a ray from p along w meets the lit side of the only emitter; by plain quadratics in the unit shape's space.
struct Met {
  bool met = false;
  Vec3 p, ng;
};
Met meet(const Quadric& q, Vec3 p, Vec3 w) {
  const Transform back = q.to_world.inverse();
  const Vec3 o = back.point(p), d = back.vector(w);
  const float k = q.kind == Quadric::Kind::sphere ? 1 : 0;
  double t = -1;
  if (q.kind == Quadric::Kind::disk) {
    t = -o.z / double(d.z);
    const double x = o.x + t * d.x, y = o.y + t * d.y;
    if (x * x + y * y > 1 || d.z >= 0) t = -1;
  } else {
    const double a = double(d.x) * d.x + double(d.y) * d.y + k * double(d.z) * d.z,
                 b = double(o.x) * d.x + double(o.y) * d.y + k * double(o.z) * d.z,
                 c = double(o.x) * o.x + double(o.y) * o.y + k * double(o.z) * o.z - 1, disc = b * b - a * c;
    if (disc > 0) t = (-b - std::sqrt(disc)) / a;
    const double z = o.z + t * d.z;
    if (q.kind == Quadric::Kind::cylinder && (z < 0 || z > 1)) t = -1;
  }
  if (!(t > 0)) return {};
  const Vec3 at = o + d * static_cast<float>(t);
  const Vec3 n = q.kind == Quadric::Kind::disk ? Vec3{0, 0, 1} : Vec3{at.x, at.y, k * at.z};
  return {true, q.to_world.point(at), normalize(q.to_world.normal(n))};
}

TEST(Direct, SamplesOfQuadricsFollowTheirDensity) {
  const std::vector<Setting> worlds = one_of_each();
  for (std::size_t k = 1; k < 4; ++k) {
    const Setting& w = worlds[k];
    const Emitters e = w.emitters();
    const auto& q = std::get<Quadric>(w.b.scene.shapes[0].geometry);
    const Vec3 from = q.to_world.point({1.5f, 1, 1.5f});
    Rng rng({6, 0}, Stage::test, k);
    double worst = 0;
    const auto result = chi_square_directions(
        "quadric" + std::to_string(k), kSamples, chi_square_level(kChiSquareTests),
        [&](int) -> std::optional<Vec3> {
          const float pick = rng.next();
          const auto s = e.sample_direct(from, pick, next_2d(rng));
          if (!s) return std::nullopt;
          const Met at = meet(q, from, s->wi);
          EXPECT_NEAR(length(s->wi), 1, 1e-5f);
          if (at.met) {
            const double claimed = e.direct_pdf_omega(from, static_cast<EmitterId>(0), at.p, at.ng, 0);
            const double cosine = -dot(at.ng, s->wi);
            if (cosine > 0.05) worst = std::max(worst, std::fabs(claimed / double(s->pdf_omega) - 1));
            EXPECT_NEAR(s->distance, length(at.p - from), 1e-3f);
          }
          return s->wi;
        },
        [&](Vec3 d) {
          const Met at = meet(q, from, d);
          return at.met ? double(e.direct_pdf_omega(from, static_cast<EmitterId>(0), at.p, at.ng, 0)) : 0.0;
        });
    EXPECT_GT(result.p_value, chi_square_level(kChiSquareTests)) << result.message;
    EXPECT_LT(worst, 1e-3) << k;
  }
}

TEST(Direct, ARectangleIsSampledByAreaAndItsDensityIsKnown) {
  Setting w;
  const EmitterId id = w.b.area_emitter(w.b.rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, w.material), {1, 2, 3});
  const EmitterId other = w.add(PointEmitter{{5, 5, 5}, gray(0.5f)});
  const Emitters e = w.emitters();
  EXPECT_NEAR(e.probability(id) + e.probability(other), 1, 1e-6f);
  const Vec3 from{0.8f, 0.3f, 1.2f};
  UniformityCheck places;
  test::Sample irradiance;
  Rng rng({7, 0}, Stage::test, 0);
  for (int i = 0; i < kSamples; ++i) {
    const float pick = rng.next();
    const auto s = e.sample_direct(from, pick, next_2d(rng));
    ASSERT_TRUE(s);
    if (s->is_delta) {
      ASSERT_NEAR(s->pdf_omega, e.probability(other), 1e-6f);
      irradiance.add(0);
      continue;
    }
    const Vec3 at = from + s->wi * s->distance;
    places.add(at.x, at.y);
    ASSERT_NEAR(e.direct_pdf_omega(from, id, at, {0, 0, 1}, 0), s->pdf_omega, 1e-4f * s->pdf_omega);
    ASSERT_GT(s->to.z, 0);
    ASSERT_LT(s->to.z, 1e-5f);
    irradiance.add(s->radiance.r * std::max(0.0f, -s->wi.z) / s->pdf_omega);  // on a plane that faces down
  }
  places.expect_uniform();
  // the same integral by the midpoint rule
  double expected = 0;
  constexpr int kGrid = 400;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double x = (i + 0.5) / kGrid - from.x, y = (j + 0.5) / kGrid - from.y, d2 = x * x + y * y + from.z * from.z;
      expected += from.z * from.z / (d2 * d2) / (kGrid * kGrid);
    }
  EXPECT_LT(std::fabs(test::z_score(irradiance, expected)), 4);
  EXPECT_EQ(e.direct_pdf_omega(from, id, {0.5f, 0.5f, 0}, {0, 0, -1}, 0), 0);
}

TEST(Direct, ASphereFarAwayIsSampledWithinItsNarrowCone) {
  Setting w;
  w.add_quadric(Quadric::Kind::sphere, Transform::translate({0, 0, 3000}) * Transform::scale({2, 2, 2}), {1, 2, 3});
  const Emitters e = w.emitters();
  test::Sample irradiance;
  Rng rng({8, 0}, Stage::test, 0);
  for (int i = 0; i < 20'000; ++i) {
    const auto s = e.sample_direct({0, 0, 0}, 0.5f, next_2d(rng));
    ASSERT_TRUE(s);
    irradiance.add(s->radiance.g * s->wi.z / s->pdf_omega);
  }
  EXPECT_NEAR(irradiance.mean, 2 * kPi * 4 / 9e6, 1e-5 * irradiance.mean);
}

TEST(Direct, InsideAGlowingSphereIrradianceIsPi) {
  Setting w;
  w.add_quadric(Quadric::Kind::sphere, Transform(), gray(1), true);
  const Emitters e = w.emitters();
  for (const Vec3 from : {Vec3{0, 0, 0}, Vec3{0.5f, -0.3f, 0.2f}, Vec3{0, 0, -0.95f}}) {
    test::Sample irradiance;
    Rng rng({9, 0}, Stage::test, 0);
    for (int i = 0; i < kSamples; ++i) {
      const float pick = rng.next();
      const auto s = e.sample_direct(from, pick, next_2d(rng));
      ASSERT_TRUE(s);
      irradiance.add(s->radiance.g * std::max(0.0f, s->wi.z) / s->pdf_omega);
    }
    EXPECT_LT(std::fabs(test::z_score(irradiance, M_PI)), 4);
  }
  EXPECT_FALSE(e.sample_direct({0, 0, 3}, 0.5f, {0.5f, 0.5f}).has_value());
  Setting outwards;
  outwards.add_quadric(Quadric::Kind::sphere, Transform(), gray(1));
  EXPECT_FALSE(outwards.emitters().sample_direct({0.2f, 0, 0}, 0.5f, {0.5f, 0.5f}).has_value());
}

std::string message_of(const Setting& w) {
  try {
    w.emitters();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
    return error.what();
  }
  return "no error";
}

TEST(Emitters, RefuseScenesWithoutLight) {
  using ::testing::HasSubstr;
  Setting none, black, two;
  none.b.sphere({0, 0, 0}, 1, none.material);
  EXPECT_THAT(message_of(none), HasSubstr("no emitter"));
  black.add(PointEmitter{{0, 0, 0}, {}});
  EXPECT_THAT(message_of(black), HasSubstr("black"));
  two.add(ConstantEmitter{gray(1)}), two.add(ConstantEmitter{gray(1)});
  EXPECT_THAT(message_of(two), HasSubstr("only one"));
  Setting negative;
  negative.add(PointEmitter{{0, 0, 0}, {-1, 1, 1}});
  EXPECT_THAT(message_of(negative), HasSubstr("negative"));
}

}  // namespace
}  // namespace myrialux
