// Virtual lights on disk: every bit comes back, foreign files load, damaged files are refused by line or byte.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "myrialux/lights/virtual_lights.h"
#include "support/build_scene.h"
#include "support/temporary_folder.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

using test::TemporaryFolder;
using test::TestWorld;
using ::testing::HasSubstr;

template <class T>
void expect_same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_TRUE(a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same(const VirtualLights& a, const VirtualLights& b) {
  expect_same_bits(a.p, b.p), expect_same_bits(a.n, b.n), expect_same_bits(a.ng, b.ng);
  expect_same_bits(a.offset, b.offset), expect_same_bits(a.light, b.light), expect_same_bits(a.kind, b.kind);
  expect_same_bits(a.bounce, b.bounce), expect_same_bits(a.extra, b.extra);
  expect_same_bits(a.glossy, b.glossy), expect_same_bits(a.spots, b.spots);
}

/// Lights of all kinds over two glossy materials.
Scene all_kinds() {
  Material metal;
  metal.name = "brushed metal";
  metal.kind = BsdfKind::rough_conductor;
  metal.alpha = metal.alpha_v = {gray(0.3f)};
  test::CornellOptions options;
  options.floor = &metal;
  test::SceneBuilder b = test::cornell_builder(options);
  Material coat;
  coat.name = "";
  coat.kind = BsdfKind::plastic;
  b.sphere({0.3f, 0.2f, 0.3f}, 0.2f, b.add(coat));
  Material gloss;
  gloss.name = "gloss";
  gloss.kind = BsdfKind::blinn_phong;
  gloss.alpha = gloss.alpha_v = {gray(0.2f)};
  gloss.specular = {gray(0.4f)};
  b.sphere({-0.3f, 0.4f, 0.3f}, 0.2f, b.add(gloss));
  b.emitter("bulb", PointEmitter{{0.4f, 0.7f, 0}, gray(2)});
  b.emitter("spot",
            SpotEmitter{.to_world = Transform::look_at({0, 0.9f, 0.1f}, {0, 0, 0}, {1, 0, 0}), .intensity = gray(9)});
  b.emitter("sky", ConstantEmitter{gray(1)});
  return b.scene;
}

TEST(LightsOnDisk, EveryBitComesBack) {
  TestWorld t(all_kinds());
  Progress quiet;
  const VirtualLights lights = trace_lights(t.world, {.n_lights = 2000, .direct = true, .key = {1, 0}}, quiet).lights;
  ASSERT_GT(lights.glossy.size(), 100u);
  ASSERT_GT(lights.spots.size(), 10u);
  const TemporaryFolder folder;
  for (const bool binary : {true, false}) {
    write_lights(lights, t.scene, folder.file("lights.ply"), binary);
    expect_same(read_lights(folder.file("lights.ply"), t.scene), lights);
    EXPECT_EQ(folder.names().size(), 1u);
  }
}

TEST(LightsOnDisk, NoLightsAtAllComeBack) {
  const TemporaryFolder folder;
  const Scene scene = test::cornell_box();
  write_lights({}, scene, folder.file("none.ply"), true);
  EXPECT_EQ(read_lights(folder.file("none.ply"), scene).size(), 0u);
}

const std::string kForeign =
    "ply\nformat ascii 1.0\ncomment made elsewhere\nelement vertex 2\nproperty float x\nproperty float y\nproperty "
    "float z\n"
    "property double nx\nproperty float ny\nproperty float nz\nproperty float r\nproperty float g\nproperty float b\n"
    "property uchar quality\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0.5 0.25 0 0 2 0 1 2 3 7\n\n-0.5 0.25 1e-1 0 1 0 4 5 6 7\n3 0 1 1\n";

TEST(LightsOnDisk, ForeignPointCloudsAreOrientedLightsOfBounceOne) {
  const TemporaryFolder folder;
  const Scene scene = test::cornell_box();
  const VirtualLights lights = read_lights(folder.write("foreign.ply", kForeign), scene);
  ASSERT_EQ(lights.size(), 2u);
  EXPECT_EQ(lights.p[1], (Vec3{-0.5f, 0.25f, 0.1f}));
  EXPECT_EQ(lights.n[0], (Vec3{0, 1, 0}));
  EXPECT_EQ(lights.ng[0], (Vec3{0, 1, 0}));
  EXPECT_EQ(lights.light[1], (Rgb{4, 5, 6}));
  EXPECT_EQ(lights.kind[0], LightKind::oriented);
  EXPECT_EQ(lights.bounce[0], 1);
  EXPECT_GT(lights.offset[0], 0);
}

std::string refusal(const std::string& text, const Scene& scene) {
  const TemporaryFolder folder;
  try {
    read_lights(folder.write("bad.ply", text), scene);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::input);
    return e.what();
  }
  return "accepted";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(LightsOnDisk, DamagedTextIsRefusedByLine) {
  const Scene scene = test::cornell_box();
  const auto bad = [&](const std::string& from, const std::string& to) {
    return refusal(replaced(kForeign, from, to), scene);
  };
  EXPECT_THAT(bad("ply\n", "plx\n"), HasSubstr("bad.ply:1: "));
  EXPECT_THAT(bad("ascii", "binary_big_endian"), HasSubstr("bad.ply:2: format 'binary_big_endian'"));
  EXPECT_THAT(bad("vertex 2", "vertex -2"), HasSubstr("bad.ply:4: the number of lights"));
  EXPECT_THAT(bad("vertex 2", "vertex 99999999999999999999"), HasSubstr("bad.ply:4: the number of lights"));
  EXPECT_THAT(bad("property float x", "property floaty x"), HasSubstr("bad.ply:5: a property must be"));
  EXPECT_THAT(bad("property float x", "property list uchar int x"), HasSubstr("bad.ply:5: lights must not have list"));
  EXPECT_THAT(bad("property float y", "property float x"), HasSubstr("bad.ply:6: property 'x' is given twice"));
  EXPECT_THAT(bad("property float r\n", "property float red\n"),
              HasSubstr("lacks properties of every light (x y z nx ny nz r g b): r"));
  EXPECT_THAT(bad("uchar quality", "float radius"), HasSubstr("bad.ply:14: property 'radius'"));
  EXPECT_THAT(bad("uchar quality", "uchar kind"), HasSubstr("bad.ply:18: kind must be"));
  EXPECT_THAT(bad("end_header", "end_heade"), HasSubstr("bad.ply:17: unknown header line"));
  EXPECT_THAT(bad("1 2 3", "nan 2 3"), HasSubstr("bad.ply:18: r must be a finite number"));
  EXPECT_THAT(bad("1 2 3", "1e60 2 3"), HasSubstr("bad.ply:18: r must be a finite number"));
  EXPECT_THAT(bad("1 2 3", "-1 2 3"), HasSubstr("bad.ply:18: r g b must be >= 0"));
  EXPECT_THAT(bad("1 2 3", "one 2 3"), HasSubstr("bad.ply:18: 'one' is not a number"));
  EXPECT_THAT(bad("1 2 3", "1 2"), HasSubstr("bad.ply:18: a light must have 10 numbers, got 9"));
  EXPECT_THAT(bad("0 2 0", "0 0 0"), HasSubstr("bad.ply:18: nx ny nz must be a direction"));
  EXPECT_THAT(refusal(kForeign.substr(0, kForeign.find("-0.5")), scene),
              HasSubstr("bad.ply:20: the file ends at light 1 of 2"));
  EXPECT_THAT(refusal(kForeign.substr(0, 60), scene), HasSubstr("ends within the header"));
  EXPECT_THAT(refusal("", scene), HasSubstr("bad.ply:1: not a PLY file"));
}

TEST(LightsOnDisk, DamagedBytesAreRefusedByOffset) {
  TestWorld t(all_kinds());
  Progress quiet;
  const VirtualLights lights = trace_lights(t.world, {.n_lights = 50, .direct = true, .key = {1, 0}}, quiet).lights;
  const TemporaryFolder folder;
  write_lights(lights, t.scene, folder.file("lights.ply"), true);
  const std::string text = folder.read("lights.ply");
  const std::size_t body = text.find("end_header\n") + 11;
  const std::size_t last = lights.size() - 1, stride = (text.size() - body) / lights.size();
  EXPECT_THAT(
      refusal(text.substr(0, text.size() - 1), t.scene),
      HasSubstr("byte " + std::to_string(text.size() - 1) + ": the file ends within light " + std::to_string(last)));
  std::string nan = text;
  std::memset(nan.data() + body + stride * last, 0xff, 4);
  EXPECT_THAT(refusal(nan, t.scene), HasSubstr("byte " + std::to_string(body + stride * last) + " (light " +
                                               std::to_string(last) + "): x must be a finite number"));
  // Cut anywhere, a file is refused and never misread.
  for (std::size_t length = 0; length < text.size(); length += 37)
    EXPECT_NE(refusal(text.substr(0, length), t.scene), "accepted");
}

TEST(LightsOnDisk, LightsOfAnotherSceneAreRefused) {
  TestWorld t(all_kinds());
  Progress quiet;
  const VirtualLights lights = trace_lights(t.world, {.n_lights = 500, .direct = true, .key = {1, 0}}, quiet).lights;
  const TemporaryFolder folder;
  write_lights(lights, t.scene, folder.file("lights.ply"), false);
  EXPECT_THAT(refusal(folder.read("lights.ply"), test::cornell_box()), HasSubstr("made for another scene"));
  EXPECT_THROW(read_lights(folder.file("absent.ply"), t.scene), Error);
  EXPECT_THROW(write_lights(lights, t.scene, folder.file("no/such/folder.ply"), true), Error);
}

}  // namespace
}  // namespace myrialux
