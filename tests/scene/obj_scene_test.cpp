// OBJ files alone as scenes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scene_text.h"

namespace myrialux {
namespace {

using test::TemporaryFolder;

const char* const kRoom =
    "mtllib a room.mtl\nv 0 0 0\nv 2 0 0\nv 2 0 2\nv 0 0 2\nv 0 1 0\n"
    "usemtl floor\nf 1 2 3 4\nusemtl shiny\nf 1 2 5\nusemtl floor\nf 1 3 5\n";

TEST(ObjScene, MaterialsCutTheFileIntoShapes) {
  const TemporaryFolder folder;
  folder.write("a room.mtl",
               "# made by hand\nnewmtl floor\nKd 0.1 0.2 0.3\n\nnewmtl shiny\nKd 0.1 0.1 0.1\nKs 0.9 0.9 0.9\n"
               "Ns 98\nd 0.5\n");
  const Scene scene = load_scene(folder.write("room.obj", kRoom));
  ASSERT_EQ(scene.shapes.size(), 2u);
  EXPECT_EQ(scene.n_triangles(), 4u);
  const Material &floor = scene.materials[0], &shiny = scene.materials[1];
  EXPECT_EQ(floor.name, "floor");
  EXPECT_EQ(floor.kind, BsdfKind::diffuse);
  EXPECT_EQ(floor.reflectance.value, (Rgb{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(shiny.kind, BsdfKind::blinn_phong);
  EXPECT_EQ(shiny.reflectance.value, gray(0.1f));
  EXPECT_FLOAT_EQ(shiny.alpha.value.r, std::sqrt(0.02f));
  EXPECT_EQ(shiny.specular.value, gray(0.9f));
  EXPECT_EQ(shiny.opacity.value, gray(0.5f));
  EXPECT_EQ(std::get<ConstantEmitter>(scene.emitters.at(0).kind).radiance, gray(1));
  EXPECT_THAT(scene.diagnostics, testing::IsEmpty());
}

TEST(ObjScene, WithoutKsOrNsMaterialsAreDiffuse) {
  const TemporaryFolder folder;
  folder.write("a room.mtl", "newmtl floor\nKd 0.7 0.7 0.7\nKs 0.5 0.5 0.5\nNs 0\nnewmtl shiny\nKs 0 0 0\nNs 1000\n");
  const Scene scene = load_scene(folder.write("room.obj", kRoom));
  for (const Material& m : scene.materials) EXPECT_EQ(m.kind, BsdfKind::diffuse) << m.name;
  EXPECT_THAT(scene.diagnostics, testing::IsEmpty());
}

TEST(ObjScene, ColoursThatReflectMoreThanOneAreScaledWithAWarning) {
  const TemporaryFolder folder;
  folder.write("a room.mtl",
               "newmtl floor\nKd 0.6 0.2 0\nKs 0.4 0.8 0.1\nNs 10\n"
               "newmtl shiny\nNs 1000\nKd 0.75 0.25 0\nKs 0.5 0.25 1\nnewmtl unused\nKd 1 1 1\nKs 1 1 1\nNs 2\n");
  const Scene scene = load_scene(folder.write("room.obj", kRoom));
  const Material &floor = scene.materials[0], &shiny = scene.materials[1];
  EXPECT_EQ(floor.reflectance.value, (Rgb{0.6f, 0.2f, 0})) << "0.6 + 0.4 is 1 but for rounding";
  EXPECT_FLOAT_EQ(shiny.reflectance.value.r, 0.6f);
  EXPECT_FLOAT_EQ(shiny.specular.value.b, 0.8f);
  EXPECT_FLOAT_EQ(shiny.alpha.value.r, std::sqrt(2 / 1002.0f));
  ASSERT_EQ(scene.diagnostics.size(), 1u);
  EXPECT_EQ(scene.diagnostics[0].at.line, 8u);
  EXPECT_EQ(scene.diagnostics[0].message, "Kd and Ks together reflect 1.25: both are divided by it");
}

TEST(ObjScene, MappedColoursAreScaledWhereTheyReflectTooMuch) {
  const TemporaryFolder folder;
  folder.write("white.ppm", std::string("P6 1 1 255\n\xff\xff\xff"));
  folder.write("a room.mtl", "newmtl floor\nnewmtl shiny\nmap_Kd white.ppm\nKd 0 0 0\nNs 40\nKs 0.25 0.25 0.25\n");
  const Scene scene = load_scene(folder.write("room.obj", kRoom));
  EXPECT_EQ(scene.materials[1].reflectance.value, gray(1)) << "black maps must not be darkened";
  EXPECT_EQ(scene.materials[1].specular.value, gray(0.25f));
  ASSERT_EQ(scene.diagnostics.size(), 1u);
  EXPECT_EQ(scene.diagnostics[0].at.line, 6u);
  EXPECT_EQ(
      scene.diagnostics[0].message,
      "Kd and Ks together reflect up to 1.25 where map_Kd is white; points that reflect more than 1 are scaled down "
      "to 1");
}

TEST(ObjScene, EmittingMaterialsReplaceTheSky) {
  const TemporaryFolder folder;
  folder.write("a room.mtl", "newmtl floor\nnewmtl shiny\nKe 5 4 3\n");
  const Scene scene = load_scene(folder.write("room.obj", kRoom));
  ASSERT_EQ(scene.emitters.size(), 1u);
  EXPECT_EQ(std::get<AreaEmitter>(scene.emitters[0].kind).radiance.value, (Rgb{5, 4, 3}));
  EXPECT_EQ(scene.shapes[1].emitter, EmitterId{0});
}

TEST(ObjScene, CameraSeesTheWholeBox) {
  const TemporaryFolder folder;
  folder.write("a room.mtl", "newmtl floor\nnewmtl shiny\n");
  const Scene scene = load_scene(folder.write("room.obj", kRoom));
  const Box3 box = scene.bounds();
  const Transform to_camera = scene.camera.to_world.inverse();
  const float half_x = std::tan(scene.camera.fov_x_deg * kPi / 360);
  const float half_y = half_x * static_cast<float>(scene.film.height) / static_cast<float>(scene.film.width);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p = to_camera.point({corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y,
                                    corner & 4 ? box.upper.z : box.lower.z});
    EXPECT_GT(p.z, scene.camera.near_clip);
    EXPECT_LT(std::abs(p.x / p.z), half_x);
    EXPECT_LT(std::abs(p.y / p.z), half_y);
  }
}

TEST(ObjScene, MistakesInMaterialsHaveTheirLine) {
  const TemporaryFolder folder;
  folder.write("a room.mtl", "newmtl floor\nKd 0.1 x 0\nnewmtl shiny\nNs -3\nmap_Kd no.png\n");
  EXPECT_EQ(test::complaint(folder, folder.write("room.obj", kRoom)),
            "a room.mtl:2: \"0.1 x 0\"; allowed: one or three numbers from 0 to 1\n"
            "a room.mtl:4: \"-3\"; allowed: a number from 0 to 1000000\n"
            "a room.mtl:5: image no.png does not exist");
  folder.write("room.obj", "mtllib none.mtl\n");
  EXPECT_EQ(test::complaint(folder, folder.file("room.obj")), "room.obj:1: material file \"none.mtl\" does not exist");
  folder.write("room.obj", "v 0 0 0\n");
  EXPECT_EQ(test::complaint(folder, folder.file("room.obj")), "room.obj: holds no faces; allowed: at least one");
}

}  // namespace
}  // namespace myrialux
