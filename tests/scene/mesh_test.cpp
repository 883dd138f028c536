// Meshes: files of every format read back, normals, winding and what is dropped.
#include "myrialux/scene/mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "myrialux/scene/sha256.h"
#include "scene_text.h"

namespace myrialux {
namespace {

using test::TemporaryFolder;
using ::testing::ElementsAre;

const char* const kBoxCorner =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0.25\nvt 1 0\nvt 0 1\n"
    "f 1/1 2/2 3/3\nf 1/1 4/2 2/3\n";
const char* const kPlyHead =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float u\n"
    "property float v\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
const float kPlyVertices[4][5] = {{0, 0, 0, 0, 0.25f}, {1, 0, 0, 1, 0}, {0, 1, 0, 0, 1}, {0, 0, 1, 0, 0}};
const std::int32_t kPlyFaces[2][3] = {{0, 1, 2}, {0, 3, 1}};

template <class T>
void append(std::string& to, T value, bool big) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  if (big) std::reverse(bytes, bytes + sizeof(T));
  to.append(bytes, sizeof(T));
}

std::string binary_ply(bool big) {
  std::string text = std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\n" + kPlyHead;
  for (const auto& vertex : kPlyVertices)
    for (const float x : vertex) append(text, x, big);
  for (const auto& face : kPlyFaces) {
    append(text, std::uint8_t{3}, big);
    for (const std::int32_t v : face) append(text, v, big);
  }
  return text;
}

std::string ascii_ply() {
  return std::string("ply\nformat ascii 1.0\ncomment made by hand\n") + kPlyHead +
         "0 0 0 0 0.25\n1 0 0 1 0\n0 1 0 0 1\n0 0 1 0 0\n3 0 1 2\n3 0 3 1\n";
}

Mesh ply(const std::string& text) {
  const TemporaryFolder folder;
  Diagnostics found;
  Mesh mesh = read_ply(folder.write("a b.ply", text), found);
  found.throw_if(Severity::warning);
  return mesh;
}

Mesh obj(const std::string& text) {
  const TemporaryFolder folder;
  Diagnostics found;
  Mesh mesh = read_obj(folder.write("a.obj", text), found);
  found.throw_if(Severity::warning);
  return mesh;
}

void expect_vector(Vec3 got, Vec3 want) {
  EXPECT_NEAR(got.x, want.x, 1e-6f);
  EXPECT_NEAR(got.y, want.y, 1e-6f);
  EXPECT_NEAR(got.z, want.z, 1e-6f);
}

TEST(Ply, AsciiAndBothBinaryOrdersGiveTheSameMesh) {
  for (const std::string& text : {ascii_ply(), binary_ply(false), binary_ply(true)}) {
    const Mesh mesh = ply(text);
    ASSERT_EQ(mesh.positions.size(), 4u);
    for (int v = 0; v < 4; ++v) {
      EXPECT_EQ(mesh.positions[v], (Vec3{kPlyVertices[v][0], kPlyVertices[v][1], kPlyVertices[v][2]}));
      EXPECT_EQ(mesh.uvs[v].y, kPlyVertices[v][4]);
    }
    EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2, 0, 3, 1));
  }
}

TEST(Ply, PolygonsBecomeFansAndOtherElementsAreSkipped) {
  const Mesh mesh =
      ply("ply\nformat ascii 1.0\nelement edge 1\nproperty int a\nproperty list uchar float w\n"
          "element vertex 5\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n"
          "element face 1\nproperty uchar kind\nproperty list uchar uint vertex_index\nend_header\n"
          "7 2 1.5 2.5\n0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n-1 0.5 0 9\n4 5 0 1 2 3 4\n");
  EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2, 0, 2, 3, 0, 3, 4));
}

TEST(Ply, AHeaderThatPromisesMoreThanTheFileHoldsIsRefusedBeforeAllocating) {
  EXPECT_THROW(
      ply("ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n"
          "property float z\nend_header\n1234"),
      Error);
}

TEST(Obj, VerticesSplitWhereTextureCoordinatesDiffer) {
  const Mesh mesh = obj(kBoxCorner);  // Mitsuba: 5 vertices, faces 0 1 2, 0 3 4
  EXPECT_EQ(mesh.positions.size(), 5u);
  EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2, 0, 3, 4));
  EXPECT_TRUE(mesh.normals.empty());
}

TEST(Obj, NegativeIndicesPolygonsAndContinuedLinesAreRead) {
  const Mesh mesh =
      obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 +1\r\ns off\ng a b\n"
          "f -4//-1 -3//1 \\\n -2//-1 4//1\n");
  EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2, 0, 2, 3));
  ASSERT_EQ(mesh.normals.size(), 4u);
  EXPECT_EQ(mesh.normals[3], (Vec3{0, 0, 1}));
}

TEST(Mesh, SmoothNormalsAreWeightedByAnglesAsInMitsuba) {
  Mesh mesh = obj(kBoxCorner);
  finish_mesh(mesh, {});
  const float s = 0.70710677f;
  expect_vector(mesh.normals[0], {0, s, s});
  expect_vector(mesh.normals[1], {0, 0, 1});
  expect_vector(mesh.normals[3], {0, 1, 0});
  Mesh shared = ply(ascii_ply());
  finish_mesh(shared, {});
  expect_vector(shared.normals[1], {0, s, s});  // two angles of 45 degrees
}

TEST(Mesh, FaceNormalsTakeNormalsAway) {
  Mesh mesh = obj(kBoxCorner);
  finish_mesh(mesh, {.to_world = {}, .face_normals = true});
  EXPECT_TRUE(mesh.normals.empty());
}

TEST(Mesh, NormalsMoveByTheInverseTranspose) {
  Mesh mesh = obj("v 0 0 0\nv 1 0 0\nv 0 1 1\nvn 0 -1 1\nf 1//1 2//1 3//1\n");
  finish_mesh(mesh, {.to_world = Transform::scale({1, 2, 1})});
  const float s = 1 / std::sqrt(5.0f);
  expect_vector(mesh.normals[0], {0, -s, 2 * s});
  expect_vector(mesh.positions[2], {0, 2, 1});
}

/// Geometric normal of the first triangle by winding.
Vec3 winding_normal(const Mesh& mesh) {
  const Vec3 a = mesh.positions[mesh.indices[0]];
  return normalize(cross(mesh.positions[mesh.indices[1]] - a, mesh.positions[mesh.indices[2]] - a));
}

TEST(Mesh, MirrorsKeepTheSideOfGivenNormalsAndTurnMadeOnes) {
  const Transform mirror = Transform::scale({-1, 1, 1});
  Mesh given = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
  finish_mesh(given, {.to_world = mirror});
  expect_vector(winding_normal(given), {0, 0, 1});
  expect_vector(given.normals[0], {0, 0, 1});
  Mesh made = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  finish_mesh(made, {.to_world = mirror});
  expect_vector(winding_normal(made), {0, 0, -1});
  expect_vector(made.normals[0], {0, 0, -1});
  Mesh rectangle = rectangle_mesh();
  finish_mesh(rectangle, {.to_world = mirror, .smooth = false});
  expect_vector(winding_normal(rectangle), {0, 0, 1});
}

TEST(Mesh, TrianglesWithoutAreaAreDroppedAndCounted) {
  Mesh mesh = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nv 0 0 0\nf 1 2 3\nf 1 1 2\nf 1 2 4\nf 1 5 3\n");
  EXPECT_EQ(finish_mesh(mesh, {}), 3u);
  EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2));
}

TEST(Mesh, ZeroNormalsOfAFileAreReplaced) {
  Mesh mesh = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n");
  finish_mesh(mesh, {});
  expect_vector(mesh.normals[2], {0, 0, 1});
}

TEST(Mesh, CubeFacesLookOutwards) {
  Mesh cube = cube_mesh();
  ASSERT_EQ(cube.n_triangles(), 12u);
  for (std::size_t t = 0; t < 12; ++t) {
    const Vec3 a = cube.positions[cube.indices[3 * t]], b = cube.positions[cube.indices[3 * t + 1]],
               c = cube.positions[cube.indices[3 * t + 2]];
    EXPECT_GT(dot(cross(b - a, c - a), a + b + c), 0) << t;
  }
  EXPECT_EQ(cube.positions[0], (Vec3{1, -1, -1}));
  EXPECT_EQ(cube.positions[23], (Vec3{-1, 1, -1}));
}

/// A file of `n` meshes as Mitsuba 0.6 writes it; mesh i is a triangle (0, 1, last) of 3 vertices shifted by i along x.
std::string serialized_file(int n, std::uint16_t version, bool in_double, std::uint32_t last = 2) {
  std::string file;
  std::vector<std::uint64_t> offsets;
  for (int i = 0; i < n; ++i) {
    std::string body;
    append(body, std::uint32_t{(in_double ? 0x2000u : 0x1000u) | 0x1u | 0x2u}, false);
    if (version == 4) body += std::string("mesh") + std::to_string(i) + '\0';
    append(body, std::uint64_t{3}, false);
    append(body, std::uint64_t{1}, false);
    const auto number = [&](double x) {
      if (in_double)
        append(body, x, false);
      else
        append(body, static_cast<float>(x), false);
    };
    for (const double x : {0.0 + i, 0.0, 0.0, 1.0 + i, 0.0, 0.0, 0.0 + i, 1.0, 0.0}) number(x);
    for (int v = 0; v < 3; ++v)
      for (const double x : {0.0, 0.0, 1.0}) number(x);
    for (const double x : {0.0, 0.0, 1.0, 0.0, 0.0, 1.0}) number(x);
    for (const std::uint32_t v : {0u, 1u, last}) append(body, v, false);
    std::vector<Bytef> packed(compressBound(body.size()));
    uLongf size = packed.size();
    compress(packed.data(), &size, reinterpret_cast<const Bytef*>(body.data()), body.size());
    offsets.push_back(file.size());
    append(file, std::uint16_t{0x041c}, false);
    append(file, version, false);
    file.append(reinterpret_cast<const char*>(packed.data()), size);
  }
  for (const std::uint64_t offset : offsets) {
    if (version == 4)
      append(file, offset, false);
    else
      append(file, static_cast<std::uint32_t>(offset), false);
  }
  append(file, static_cast<std::uint32_t>(n), false);
  return file;
}

TEST(Serialized, BothVersionsAndPrecisionsGiveTheMeshAsked) {
  const TemporaryFolder folder;
  for (const std::uint16_t version : {3, 4})
    for (const bool in_double : {false, true}) {
      const std::string path = folder.write("a.serialized", serialized_file(3, version, in_double));
      Diagnostics found;
      const Mesh mesh = read_serialized(path, 1, found);
      found.throw_if(Severity::warning);
      ASSERT_EQ(mesh.positions.size(), 3u);
      EXPECT_EQ(mesh.positions[1], (Vec3{2, 0, 0}));
      EXPECT_EQ(mesh.normals[0], (Vec3{0, 0, 1}));
      EXPECT_EQ(mesh.uvs[2].y, 1);
      EXPECT_THAT(mesh.indices, ElementsAre(0, 1, 2));
    }
}

TEST(Serialized, WrongIndexVersionAndLengthAreTold) {
  const TemporaryFolder folder;
  const std::string good = serialized_file(2, 4, false);
  const auto message = [&](const std::string& bytes, int shape_index) {
    Diagnostics found;
    read_serialized(folder.write("a.serialized", bytes), shape_index, found);
    return found.all().empty() ? "" : found.all()[0].message;
  };
  EXPECT_EQ(message(good, 2), "shape index is 2; allowed: 0 to 1");
  EXPECT_EQ(message("abcdefghijk", 0), "not a serialized mesh file of Mitsuba");
  std::string old = good;
  old[2] = 2;
  EXPECT_EQ(message(old, 0), "version is 2; allowed: 3, 4");
  std::string damaged = good;
  damaged[16] = static_cast<char>(damaged[16] ^ 0x55);
  EXPECT_NE(message(damaged, 0), "");
  EXPECT_EQ(message(serialized_file(2, 4, false, 3), 0), "a face names vertex 3; allowed: 0 to 2");
}

TEST(Sha256, DigestsAreThoseOfTheStandard) {
  // FIPS 180-4 examples
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace myrialux
