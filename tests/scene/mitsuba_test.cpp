// What the Mitsuba reader makes of well-formed scenes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "scene_text.h"

namespace myrialux {
namespace {

using test::load_body;
using test::load_text;
using test::TemporaryFolder;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Material material_of(const std::string& bsdf, const std::string& version = "3.0.0") {
  return load_body(bsdf, version).materials.at(0);
}

std::vector<std::string> messages(const Scene& scene) {
  std::vector<std::string> all;
  for (const Diagnostic& d : scene.diagnostics)
    all.push_back(std::to_string(d.at.line) + ":" + std::to_string(d.at.column) + " " + d.message);
  return all;
}

TEST(Mitsuba, OldAndNewSpellingGiveTheSameMaterial) {
  const Material old_one = material_of(
      "<bsdf type=\"roughplastic\"><float name=\"intIOR\" value=\"1.9\"/><float name=\"extIOR\" value=\"1.2\"/>"
      "<rgb name=\"diffuseReflectance\" value=\"0.1 0.2 0.3\"/><boolean name=\"nonlinear\" value=\"true\"/></bsdf>",
      "0.5.0");
  const Material new_one = material_of(
      "<bsdf type=\"roughplastic\"><float name=\"int_ior\" value=\"1.9\"/><float name=\"ext_ior\" value=\"1.2\"/>"
      "<rgb name=\"diffuse_reflectance\" value=\"0.1 0.2 0.3\"/><boolean name=\"nonlinear\" value=\"true\"/></bsdf>");
  for (const Material& m : {old_one, new_one}) {
    EXPECT_EQ(m.kind, BsdfKind::rough_plastic);
    EXPECT_FLOAT_EQ(m.eta, 1.9f / 1.2f);
    EXPECT_EQ(m.reflectance.value, (Rgb{0.1f, 0.2f, 0.3f}));
    EXPECT_TRUE(m.nonlinear);
  }
}

TEST(Mitsuba, DefaultsOfMaterialsAreThoseOfItsPlugins) {  // measured with Mitsuba 3.9.1
  EXPECT_FLOAT_EQ(material_of("<bsdf type=\"plastic\"/>").eta, 1.48958730f);
  EXPECT_FLOAT_EQ(material_of("<bsdf type=\"dielectric\"/>").eta, 1.50418329f);
  EXPECT_FLOAT_EQ(material_of("<bsdf type=\"thindielectric\"/>").eta, 1.50418329f);
  const Material rough = material_of("<bsdf type=\"roughplastic\"/>");
  EXPECT_EQ(rough.alpha.value, gray(0.1f));
  EXPECT_EQ(rough.distribution, Microfacets::beckmann);
  EXPECT_EQ(rough.reflectance.value, gray(0.5f));
  const Material metal = material_of("<bsdf type=\"roughconductor\"/>");
  EXPECT_EQ(metal.eta_metal, gray(0));
  EXPECT_EQ(metal.k_metal, gray(1));
  EXPECT_EQ(material_of("<bsdf type=\"mask\"><bsdf type=\"diffuse\"/></bsdf>").opacity.value, gray(0.5f));
}

TEST(Mitsuba, ConductorsAreRelativeToTheirSurroundings) {
  const Material m = material_of(
      "<bsdf type=\"conductor\"><rgb name=\"eta\" value=\"1 2 3\"/><rgb name=\"k\" value=\"4 5 6\"/>"
      "<float name=\"ext_eta\" value=\"2\"/></bsdf>");
  EXPECT_EQ(m.eta_metal, (Rgb{0.5f, 1, 1.5f}));
  EXPECT_EQ(m.k_metal, (Rgb{2, 2.5f, 3}));
}

TEST(Mitsuba, AdaptersAreFlattened) {
  const Scene scene = load_body(
      "<bsdf type=\"mask\" id=\"leaf\"><float name=\"opacity\" value=\"0.25\"/><bsdf type=\"twosided\">"
      "<bsdf type=\"bumpmap\"><texture name=\"map\" type=\"checkerboard\"/><bsdf type=\"diffuse\"/></bsdf>"
      "<bsdf type=\"plastic\"/></bsdf></bsdf>");
  ASSERT_EQ(scene.materials.size(), 2u);
  const Material& leaf = scene.materials[1];
  EXPECT_EQ(leaf.name, "leaf");
  EXPECT_EQ(leaf.opacity.value, gray(0.25f));
  EXPECT_EQ(leaf.kind, BsdfKind::diffuse);
  EXPECT_TRUE(leaf.two_sided);
  EXPECT_EQ(scene.materials[index(leaf.back)].kind, BsdfKind::plastic);
  EXPECT_NE(leaf.bump, kNone<TextureId>);
  EXPECT_THAT(messages(scene), testing::ElementsAre(HasSubstr("bsdf \"bumpmap\" is shaded without its bumps")));
}

TEST(Mitsuba, DifferentRoughnessesAlongBothAxesAreAveragedWithAWarning) {
  const Scene scene = load_body(
      "<bsdf type=\"roughconductor\"><float name=\"alpha_u\" value=\"0.1\"/><float name=\"alpha_v\" "
      "value=\"0.4\"/></bsdf>");
  EXPECT_FLOAT_EQ(scene.materials[0].alpha.value.r, 0.2f);
  EXPECT_THAT(messages(scene), testing::ElementsAre(HasSubstr("alpha_u and alpha_v differ: rendered with 0.2")));
}

TEST(Mitsuba, ShapesWithoutMaterialAreGreyAndBlackIfTheyEmit) {
  const Scene scene = load_body("<shape type=\"cube\"/><shape type=\"rectangle\"><emitter type=\"area\"/></shape>");
  EXPECT_EQ(scene.materials[index(scene.shapes[0].material)].reflectance.value, gray(0.5f));
  EXPECT_EQ(scene.materials[index(scene.shapes[1].material)].reflectance.value, gray(0));
  const Emitter& light = scene.emitters[index(scene.shapes[1].emitter)];
  EXPECT_EQ(std::get<AreaEmitter>(light.kind).shape, ShapeId{1});
  EXPECT_EQ(std::get<AreaEmitter>(light.kind).radiance.value, gray(1));
}

TEST(Mitsuba, TransformsApplyInTheOrderOfTheFile) {
  const Scene scene = load_body(
      "<shape type=\"sphere\"><transform name=\"to_world\"><scale value=\"2\"/><rotate z=\"1\" angle=\"90\"/>"
      "<translate x=\"1\" y=\"2\"/></transform><point name=\"center\" value=\"1 0 0\"/>"
      "<float name=\"radius\" value=\"3\"/></shape>");
  const Transform& m = std::get<Quadric>(scene.shapes[0].geometry).to_world;
  const Vec3 centre = m.point({0, 0, 0});
  EXPECT_NEAR(centre.x, 1, 1e-6f);
  EXPECT_NEAR(centre.y, 4, 1e-6f);
  EXPECT_NEAR(length(m.vector({1, 0, 0})), 6, 1e-5f);
  const Box3 box = scene.bounds();
  EXPECT_NEAR(box.lower.x, -5, 1e-5f);
  EXPECT_NEAR(box.upper.y, 10, 1e-5f);
}

TEST(Mitsuba, MatricesOfNineNumbersAreLinearMaps) {
  const Scene scene = load_body(
      "<shape type=\"disk\"><transform name=\"to_world\"><matrix value=\"2 0 0 0 3 0 0 0 4\"/></transform></shape>");
  EXPECT_EQ(std::get<Quadric>(scene.shapes[0].geometry).to_world, Transform::scale({2, 3, 4}));
}

TEST(Mitsuba, CylindersRunFromTheirFirstToTheirSecondPoint) {
  const Scene scene = load_body(
      "<shape type=\"cylinder\"><point name=\"p0\" x=\"1\" y=\"2\" z=\"3\"/><point name=\"p1\" x=\"1\" y=\"5\" "
      "z=\"3\"/>"
      "<float name=\"radius\" value=\"0.5\"/></shape>");
  const Transform& m = std::get<Quadric>(scene.shapes[0].geometry).to_world;
  EXPECT_EQ(m.point({0, 0, 0}), (Vec3{1, 2, 3}));
  EXPECT_EQ(m.point({0, 0, 1}), (Vec3{1, 5, 3}));
  EXPECT_NEAR(length(m.vector({1, 0, 0})), 0.5f, 1e-6f);
  const Box3 box = scene.bounds();
  EXPECT_NEAR(box.lower.y, 2, 1e-6f);
  EXPECT_NEAR(box.upper.x, 1.5f, 1e-6f);
}

TEST(Mitsuba, InstancesPlaceAGroupAndCountItsTriangles) {
  const Scene scene = load_body(
      "<shape type=\"instance\"><ref id=\"g\"/><transform name=\"to_world\"><translate x=\"10\"/></transform></shape>"
      "<shape type=\"instance\"><ref id=\"g\"/></shape>"
      "<shape type=\"shapegroup\" id=\"g\"><shape type=\"cube\"/><shape type=\"sphere\"/></shape>");
  EXPECT_EQ(scene.groups.size(), 1u);
  EXPECT_EQ(scene.instances.size(), 2u);
  EXPECT_THAT(scene.placed, IsEmpty());
  EXPECT_EQ(scene.n_triangles(), 24u);
  EXPECT_FLOAT_EQ(scene.bounds().upper.x, 11);
  EXPECT_FLOAT_EQ(scene.bounds().lower.x, -1);
}

struct FovCase {
  const char* properties;
  float fov_x_deg;
};
class FieldOfView : public testing::TestWithParam<FovCase> {};
TEST_P(FieldOfView, HorizontalAngleIsThatOfMitsuba) {  // measured with Mitsuba 3.9.1, film 640 x 360
  const TemporaryFolder folder;
  const Scene scene = load_text(
      folder,
      std::string("<scene version=\"3.0.0\"><emitter type=\"constant\"/><sensor type=\"perspective\">") +
          GetParam().properties +
          "<film type=\"hdrfilm\"><integer name=\"width\" value=\"640\"/><integer name=\"height\" value=\"360\"/>"
          "</film></sensor></scene>");
  EXPECT_NEAR(scene.camera.fov_x_deg, GetParam().fov_x_deg, 1e-4f);
}
#define FOV40(axis) "<float name=\"fov\" value=\"40\"/><string name=\"fov_axis\" value=\"" axis "\"/>"
INSTANTIATE_TEST_SUITE_P(Axes, FieldOfView,
                         testing::Values(FovCase{FOV40("x"), 40}, FovCase{FOV40("y"), 65.81043243f},
                                         FovCase{FOV40("diagonal"), 35.20092392f},
                                         FovCase{FOV40("smaller"), 65.81043243f}, FovCase{FOV40("larger"), 40},
                                         FovCase{"", 41.32304382f},
                                         FovCase{"<string name=\"focal_length\" value=\"35mm\"/>", 56.62411880f}));

TEST(Mitsuba, CameraFilmFilterSamplerAndIntegratorAreRead) {
  const TemporaryFolder folder;
  const Scene scene = load_text(folder, R"(<scene version="0.6.0">
  <integrator type="path"><integer name="maxDepth" value="7"/><integer name="rrDepth" value="3"/>
    <boolean name="hideEmitters" value="true"/></integrator>
  <sensor type="perspective">
    <float name="fov" value="39"/><float name="nearClip" value="0.5"/><float name="farClip" value="77"/>
    <float name="principalPointOffsetX" value="0.1"/>
    <transform name="toWorld"><lookAt origin="1, 2, 3" target="1, 2, 8" up="0, 1, 0"/></transform>
    <sampler type="ldsampler"><integer name="sampleCount" value="33"/></sampler>
    <film type="ldrfilm"><integer name="width" value="31"/><integer name="height" value="17"/>
      <float name="gamma" value="2.2"/><rfilter type="mitchell"><float name="B" value="0.25"/></rfilter></film>
  </sensor>
  <luminaire type="constant"/>
</scene>)");
  EXPECT_THAT(messages(scene), IsEmpty());
  EXPECT_EQ(scene.max_depth, 7);
  EXPECT_EQ(scene.rr_depth, 3);
  EXPECT_TRUE(scene.hide_emitters);
  EXPECT_EQ(scene.film.width, 31);
  EXPECT_EQ(scene.film.height, 17);
  EXPECT_EQ(scene.film.spp, 33);
  EXPECT_EQ(scene.film.filter.kind, Filter::Kind::mitchell);
  EXPECT_FLOAT_EQ(scene.film.filter.b, 0.25f);
  EXPECT_FLOAT_EQ(scene.film.filter.c, 1.0f / 3);
  EXPECT_FLOAT_EQ(scene.camera.near_clip, 0.5f);
  EXPECT_FLOAT_EQ(scene.camera.far_clip, 77);
  EXPECT_FLOAT_EQ(scene.camera.principal_x, 0.1f);
  EXPECT_EQ(scene.camera.to_world.vector({0, 0, 1}), (Vec3{0, 0, 1}));
  EXPECT_EQ(scene.camera.to_world.point({0, 0, 0}), (Vec3{1, 2, 3}));
}

TEST(Mitsuba, LensesOfBothDialectsAreReadAndFocusAtTheFarPlaneIfNotTold) {
  const auto lens = [](const std::string& version, const std::string& parameters) {
    const TemporaryFolder folder;
    const Scene scene = load_text(folder, "<scene version=\"" + version + "\"><sensor type=\"thinlens\">" + parameters +
                                              "</sensor>" + test::kLight + "</scene>");
    EXPECT_THAT(messages(scene), IsEmpty());
    return scene.camera;
  };
  const Camera old_one = lens("0.6.0",
                              "<float name=\"apertureRadius\" value=\"0.25\"/><float name=\"focusDistance\" "
                              "value=\"3\"/>"),
               new_one = lens("3.0.0",
                              "<float name=\"aperture_radius\" value=\"0.25\"/><float name=\"focus_distance\" "
                              "value=\"3\"/>");
  for (const Camera& camera : {old_one, new_one}) {
    EXPECT_EQ(camera.aperture_radius, 0.25f);
    EXPECT_EQ(camera.focus_distance, 3);
  }
  const Camera far_away =
      lens("3.0.0", "<float name=\"aperture_radius\" value=\"1\"/><float name=\"far_clip\" value=\"50\"/>");
  EXPECT_EQ(far_away.focus_distance, 50);
}

/// A camera that moves from (0, 0, 0) to (4, 0, 0) and turns by 90 degrees, between the times 1 and 3.
Scene moving_camera(const std::string& shutter) {
  const TemporaryFolder folder;
  return load_text(
      folder, "<scene version=\"0.6.0\"><default name=\"far\" value=\"4\"/><sensor type=\"perspective\">" + shutter +
                  "<animation name=\"toWorld\"><transform time=\"1\"/><transform time=\"3\">"
                  "<rotate y=\"1\" angle=\"90\"/><translate x=\"$far\"/></transform></animation></sensor>" +
                  test::kLight + "</scene>");
}

TEST(Mitsuba, CamerasMoveFromKeyframeToKeyframe) {
  const Scene scene =
      moving_camera("<float name=\"shutterOpen\" value=\"1\"/><float name=\"shutterClose\" value=\"2\"/>");
  EXPECT_THAT(messages(scene), IsEmpty());
  const Camera& camera = scene.camera;
  EXPECT_TRUE(camera.moves());
  ASSERT_EQ(camera.motion.size(), 2u);
  for (const CameraKey& key : camera.motion) EXPECT_EQ(camera.at(key.time), key.to_world);  // exact at their times
  EXPECT_EQ(camera.at(0.5), camera.at(1)) << "stands still before the first";
  EXPECT_EQ(camera.at(77), camera.at(3)) << "and after the last";
  const Vec3 place = camera.at(2).point({0, 0, 0}), view = camera.at(2).vector({0, 0, 1});
  EXPECT_EQ(place, (Vec3{2, 0, 0}));
  EXPECT_NEAR(view.x, std::sqrt(0.5f), 1e-6f);
  EXPECT_NEAR(view.z, std::sqrt(0.5f), 1e-6f);
  EXPECT_EQ(camera.to_world, camera.at(1.5)) << "the middle of what the shutter shows";
}

TEST(Mitsuba, AClosedShutterShowsAMovingCameraAtOneTimeWithAWarning) {
  const Scene scene =
      moving_camera("<float name=\"shutterOpen\" value=\"2\"/><float name=\"shutterClose\" value=\"2\"/>");
  EXPECT_FALSE(scene.camera.moves());
  EXPECT_EQ(scene.camera.to_world.point({0, 0, 0}), (Vec3{2, 0, 0}));
  EXPECT_THAT(messages(scene), testing::ElementsAre(HasSubstr("seen where it stands at time 2 only")));
}

TEST(Mitsuba, OnlyCamerasMove) {
  const Scene scene = load_body(
      "\n<shape type=\"cube\"><animation name=\"to_world\"><transform time=\"0\"><translate x=\"5\"/></transform>"
      "<transform time=\"1\"/></animation></shape>");
  EXPECT_THAT(messages(scene),
              testing::ElementsAre("2:20 a moving shape cannot be rendered yet; allowed: <animation> in a sensor"));
  EXPECT_THROW(require_renderable(scene), Error);
  EXPECT_EQ(scene.bounds().upper.x, 6) << "shown where it begins";
}

TEST(Mitsuba, EmittersAreReadWithTheirParameters) {
  const TemporaryFolder folder;
  const Scene scene = load_text(folder, std::string("<scene version=\"3.0.0\">") + test::kCamera + R"(
    <emitter type="point"><point name="position" x="1" y="2" z="3"/><rgb name="intensity" value="4 5 6"/></emitter>
    <emitter type="spot"><rgb name="intensity" value="7"/><float name="cutoff_angle" value="40"/>
      <transform name="to_world"><translate x="9"/></transform></emitter>
    <emitter type="directional"><vector name="direction" x="0" y="0" z="-2"/><rgb name="irradiance" value="8"/></emitter>
  </scene>)");
  ASSERT_EQ(scene.emitters.size(), 3u);
  EXPECT_EQ(std::get<PointEmitter>(scene.emitters[0].kind).position, (Vec3{1, 2, 3}));
  EXPECT_EQ(std::get<PointEmitter>(scene.emitters[0].kind).intensity, (Rgb{4, 5, 6}));
  const SpotEmitter& spot = std::get<SpotEmitter>(scene.emitters[1].kind);
  EXPECT_FLOAT_EQ(spot.cutoff_deg, 40);
  EXPECT_FLOAT_EQ(spot.beam_deg, 30);
  EXPECT_EQ(spot.to_world.point({}), (Vec3{9, 0, 0}));
  EXPECT_EQ(std::get<DirectionalEmitter>(scene.emitters[2].kind).direction, (Vec3{0, 0, -1}));
}

TEST(Mitsuba, DefaultsSubstituteAndCommandLineOverrides) {
  const TemporaryFolder folder;
  const std::string text =
      std::string("<scene version=\"3.0.0\"><default name=\"r\" value=\"2\"/><default name=\"rest\" value=\"5\"/>") +
      test::kCamera + test::kLight +
      "<shape type=\"sphere\"><float name=\"radius\" value=\"$rest\"/></shape>"
      "<shape type=\"sphere\"><float name=\"radius\" value=\"1$r\"/></shape></scene>";
  EXPECT_FLOAT_EQ(load_text(folder, text).bounds().upper.x, 12);
  EXPECT_FLOAT_EQ(load_text(folder, text, {.defines = {{"r", "3"}}}).bounds().upper.x, 13);
  EXPECT_THAT(messages(load_text(folder, text, {.defines = {{"rst", "3"}}})),
              testing::ElementsAre(HasSubstr("-D rst=3: the scene has no $rst; did you mean \"rest\"?")));
}

TEST(Mitsuba, IncludesAliasesAndReferencesInAnyOrder) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "parts here");
  folder.write("parts here/materials.xml",
               "<scene version=\"3.0.0\"><alias id=\"a\" as=\"b\"/><bsdf type=\"diffuse\" id=\"a\"/>"
               "<shape type=\"obj\"><string name=\"filename\" value=\"t 1.obj\"/><ref id=\"b\"/></shape></scene>");
  folder.write("parts here/t 1.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Scene scene = load_text(folder, test::scene_with("<shape type=\"cube\"><ref id=\"b\"/></shape>"
                                                         "<include filename=\"parts here/materials.xml\"/>"));
  ASSERT_EQ(scene.shapes.size(), 2u);
  EXPECT_EQ(scene.shapes[0].material, scene.shapes[1].material);
  EXPECT_EQ(scene.shapes[1].name, "t 1.obj");
  EXPECT_EQ(scene.n_triangles(), 13u);
}

TEST(Mitsuba, ObjTextureCoordinatesAreTurnedUnlessToldOtherwise) {
  const TemporaryFolder folder;
  folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nf 1/1 2/1 3/1\n");
  const auto v_of = [&](const std::string& more) {
    const Scene scene = load_text(
        folder,
        test::scene_with("<shape type=\"obj\"><string name=\"filename\" value=\"t.obj\"/>" + more + "</shape>"));
    return scene.meshes[0].uvs[0].y;
  };
  EXPECT_EQ(v_of(""), 0.75f);
  EXPECT_EQ(v_of("<boolean name=\"flip_tex_coords\" value=\"false\"/>"), 0.25f);
}

TEST(Mitsuba, AMissingObjIsReplacedByThePlyBesideItWithAWarning) {
  const TemporaryFolder folder;
  folder.write("t.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
               "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const Scene scene =
      load_text(folder, test::scene_with("<shape type=\"obj\"><string name=\"filename\" value=\"t.obj\"/></shape>"));
  EXPECT_EQ(scene.n_triangles(), 1u);
  EXPECT_THAT(messages(scene), testing::ElementsAre(HasSubstr("t.ply is read instead")));
}

TEST(Mitsuba, TextureParametersOfBothDialectsAreRead) {
  const Scene scene = load_body(
      "<bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\"><rgb name=\"color0\" value=\"1\"/>"
      "<float name=\"uscale\" value=\"4\"/><float name=\"voffset\" value=\"0.5\"/></texture></bsdf>",
      "0.6.0");
  ASSERT_EQ(scene.textures.size(), 1u);
  EXPECT_EQ(scene.materials[0].reflectance.texture, TextureId{0});
  EXPECT_EQ(scene.materials[0].reflectance.value, gray(1));
  EXPECT_EQ(scene.textures[0].color0, gray(1));
  EXPECT_EQ(evaluate(scene.textures[0], {0.03125f, 0.25f}), gray(0.2f));  // (0.125, 0.75)
}

TEST(Mitsuba, WhatIsKnownButNotRenderedIsToldAndStopsARenderOnly) {
  const Scene scene = load_body(
      "<medium type=\"homogeneous\" id=\"m\"><rgb name=\"sigma_t\" value=\"1\"/></medium>\n"
      "<shape type=\"cube\"><ref name=\"interior\" id=\"m\"/></shape>\n<bsdf type=\"principled\"/>");
  EXPECT_EQ(scene.shapes.size(), 1u);
  EXPECT_THAT(messages(scene),
              testing::ElementsAre(HasSubstr("medium \"homogeneous\" cannot be rendered yet"),
                                   HasSubstr("bsdf \"principled\" cannot be rendered yet; allowed: diffuse")));
  EXPECT_THROW(require_renderable(scene), Error);
  EXPECT_NO_THROW(require_renderable(load_body("")));
}

TEST(Mitsuba, UnknownParametersAreWarnedOfWithTheNearestName) {
  const Scene scene = load_body("\n <bsdf type=\"diffuse\">\n  <rgb name=\"reflectanse\" value=\"1\"/></bsdf>");
  EXPECT_THAT(messages(scene),
              testing::ElementsAre(
                  "3:3 bsdf \"diffuse\" does not know the parameter \"reflectanse\"; did you mean \"reflectance\"?"));
}

TEST(Mitsuba, StrictTurnsWarningsIntoErrors) {
  const TemporaryFolder folder;
  const std::string text = test::scene_with("<bsdf type=\"diffuse\"><float name=\"shine\" value=\"1\"/></bsdf>");
  EXPECT_NO_THROW(load_text(folder, text));
  EXPECT_THROW(load_text(folder, text, {.defines = {}, .strict = true}), Error);
}

TEST(Mitsuba, IntegratorsWithAnotherMeaningAreWarnedOf) {
  EXPECT_THAT(messages(load_body("<integrator type=\"ptracer\"/>")),
              testing::ElementsAre(HasSubstr("integrator \"ptracer\" is not followed: --method chooses")));
  EXPECT_EQ(load_body("<integrator type=\"moment\"><integrator type=\"path\"><integer name=\"max_depth\" value=\"6\"/>"
                      "</integrator></integrator>")
                .max_depth,
            6);
}

TEST(Mitsuba, HashFollowsTextAndFiles) {
  const TemporaryFolder folder;
  folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string text = test::scene_with("<shape type=\"obj\"><string name=\"filename\" value=\"t.obj\"/></shape>");
  const std::string first = load_text(folder, text).sha256;
  EXPECT_EQ(first.size(), 64u);
  EXPECT_EQ(load_text(folder, text).sha256, first);
  EXPECT_NE(load_text(folder, text + " ").sha256, first);
  folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 \n");
  EXPECT_NE(load_text(folder, text).sha256, first);
}

}  // namespace
}  // namespace myrialux
