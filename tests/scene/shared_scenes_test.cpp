// The shared scenes: shapes, triangles, bounds and angles against Mitsuba 3.9.1; both dialects against each other.
#include "support/scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

#include "myrialux/base/parallel.h"
#include "myrialux/scene/load.h"

namespace myrialux {
namespace {

struct Facts {
  const char* name;
  std::size_t n_shapes;
  std::uint64_t n_triangles;  ///< with those without area
  Vec3 lower, upper;
  float fov_x_deg;
};
std::ostream& operator<<(std::ostream& out, const Facts& f) { return out << f.name; }

// mi.load_file(..., optimize=False): len(shapes()), sum of face counts (rectangles: 2), bbox(), x_fov
const Facts kShared[] = {
    {"classroom", 79, 103832, {-110.811317f, -0.165661007f, -110.811317f}, {110.811317f, 3.05558705f, 110.811317f}, 60},
    {"cornell-box", 8, 36, {-1.00000012f, -8.74227979e-08f, -1.00000012f}, {1.00000012f, 2, 1}, 19.5f},
    {"living-room",
     65,
     143163,
     {-0.513427973f, -0.00306200003f, -3.63537908f},
     {5.12268209f, 2.87914109f, 0.592839003f},
     90},
    {"smoke-hetvol", 3, 14, {-10, -3, -10}, {10, 0.50999999f, 10}, 45.8401985f},
    {"staircase", 775, 262663, {-4.1070199f, -0.163450003f, -5.20437002f}, {2.50292397f, 7.15841198f, 5.13401222f}, 35},
    {"staircase2", 32, 30927, {-21.7195568f, -3.68796206f, -3.08068705f}, {7.16257381f, 11.3850193f, 6.95097113f}, 70},
    {"veach-ajar",
     22,
     382690,
     {-9.64634037f, -0.0167599991f, -7.5999999f},
     {7.42999983f, 3.79999995f, 0.599999011f},
     60},
    {"veach-mis", 9, 52, {-5.00000095f, -4.32743008e-07f, -23.7600002f}, {14.7999992f, 19.7999992f, 23.7600002f}, 35},
    {"vol-cbox-teapot", 7, 15718, {0, 0, 0}, {556, 548.799988f, 559.200012f}, 39.3077011f},
    {"volumetric-caustic", 8, 14, {-1, 0, -1}, {1, 2, 1}, 19.5f},
};
const Facts kPacked[] = {
    {"kitchen", 293, 1050941, {-3.1386981f, -0.0207759999f, -3.18370509f}, {3.77741098f, 3.3639009f, 5.47059107f}, 60},
    {"bedroom", 71, 449390, {-2.97799397f, -0.201441005f, -1.30645895f}, {4.22586918f, 2.63836288f, 4.14286804f}, 65},
    {"bathroom2", 71, 1016615, {-20.1429806f, -2.45509911f, -22.9467659f}, {18.9672337f, 36.955101f, 53.5325012f}, 60},
    {"dining-room", 53, 269538, {-6.35318518f, -1.51684999f, -4.71470547f}, {5.26334f, 8.03075027f, 10.0439997f}, 60},
    {"sanmiguel-part",
     133,
     1218202,
     {-37.9735985f, -36.9362984f, -0.381559014f},
     {46.7743988f, 36.9506989f, 53.5195999f},
     114.101547f},
};

void expect_facts(const Scene& scene, const Facts& facts) {
  EXPECT_EQ(scene.shapes.size(), facts.n_shapes);
  EXPECT_EQ(scene.n_triangles() + scene.dropped_triangles, facts.n_triangles);
  EXPECT_NEAR(scene.camera.fov_x_deg, facts.fov_x_deg, 1e-4f);
  const Box3 box = scene.bounds();
  const float tolerance = 1e-6f * box.diagonal();  // single precision, another order of products
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(box.lower[axis], facts.lower[axis], tolerance) << axis;
    EXPECT_NEAR(box.upper[axis], facts.upper[axis], tolerance) << axis;
  }
  for (const Mesh& mesh : scene.meshes)
    for (const Vec3& n : mesh.normals) ASSERT_NEAR(length(n), 1, 1e-5f) << mesh.name;
}

/// Names of tests hold letters and digits only.
template <class Info>
std::string test_name(const Info& info) {
  std::string name;
  if constexpr (std::is_same_v<std::decay_t<decltype(info.param)>, Facts>)
    name = info.param.name;
  else
    name = info.param;
  std::erase(name, '-');
  return name;
}

class SharedScene : public testing::TestWithParam<Facts> {};

TEST_P(SharedScene, HasTheShapesTrianglesAndBoundsThatMitsubaFinds) {
  MYRIALUX_REQUIRE_SCENES();
  expect_facts(load_scene(test::scenes_folder() + "/" + GetParam().name + "/scene.xml"), GetParam());
}
INSTANTIATE_TEST_SUITE_P(All, SharedScene, testing::ValuesIn(kShared), test_name<testing::TestParamInfo<Facts>>);

class SlowPackedScene : public testing::TestWithParam<Facts> {};

/// Unpacks beside the test program unless MYRIALUX_SCENES_UNPACKED names a folder that has the scene.
std::string packed_scene(const std::string& name) {
  const std::string unpacked = test::unpacked_scenes_folder();
  if (std::filesystem::exists(unpacked + "/" + name + "/scene.xml")) return unpacked + "/" + name + "/scene.xml";
  const std::string target = "unpacked-scenes";
  std::filesystem::create_directories(target);
  if (!std::filesystem::exists(target + "/" + name + "/scene.xml")) {
    const std::string command = "tar -xJf '" + test::scenes_folder() + "/" + name + ".tar.xz' -C " + target;
    if (std::system(command.c_str()) != 0) return {};
  }
  return target + "/" + name + "/scene.xml";
}

TEST_P(SlowPackedScene, HasTheShapesTrianglesAndBoundsThatMitsubaFinds) {
  MYRIALUX_REQUIRE_SCENES();
  const std::string path = packed_scene(GetParam().name);
  ASSERT_FALSE(path.empty()) << "tar and xz are needed to unpack " << GetParam().name << ".tar.xz";
  expect_facts(load_scene(path), GetParam());
}
INSTANTIATE_TEST_SUITE_P(All, SlowPackedScene, testing::ValuesIn(kPacked), test_name<testing::TestParamInfo<Facts>>);

bool close(const Transform& a, const Transform& b) {
  for (int i = 0; i < 16; ++i)
    if (std::abs(a.rows()[i] - b.rows()[i]) > 1e-5 * (1 + std::abs(a.rows()[i]))) return false;
  return true;
}

class BothDialects : public testing::TestWithParam<const char*> {};

TEST_P(BothDialects, GiveTheSameShapesMaterialsAndTransforms) {
  MYRIALUX_REQUIRE_SCENES();
  const std::string folder = test::scenes_folder() + "/" + GetParam();
  const Scene a = load_scene(folder + "/scene.xml"), b = load_scene(folder + "/scene.orig.xml");
  ASSERT_EQ(a.shapes.size(), b.shapes.size());
  EXPECT_EQ(a.n_triangles(), b.n_triangles());
  EXPECT_TRUE(close(a.camera.to_world, b.camera.to_world));
  EXPECT_NEAR(a.camera.fov_x_deg, b.camera.fov_x_deg, 1e-4f);
  for (std::size_t s = 0; s < a.shapes.size(); ++s) {
    const Material &ma = a.materials[index(a.shapes[s].material)], &mb = b.materials[index(b.shapes[s].material)];
    EXPECT_EQ(ma.kind, mb.kind) << a.shapes[s].name;
    EXPECT_EQ(ma.two_sided, mb.two_sided) << a.shapes[s].name;
    EXPECT_EQ(ma.reflectance.value, mb.reflectance.value) << a.shapes[s].name;
    EXPECT_NEAR(ma.alpha.value.r, mb.alpha.value.r, 1e-6f) << a.shapes[s].name;
    EXPECT_NEAR(ma.eta, mb.eta, 1e-6f) << a.shapes[s].name;
    const Quadric* qa = std::get_if<Quadric>(&a.shapes[s].geometry);
    const Quadric* qb = std::get_if<Quadric>(&b.shapes[s].geometry);
    ASSERT_EQ(qa == nullptr, qb == nullptr);
    if (qa) {
      EXPECT_TRUE(close(qa->to_world, qb->to_world)) << a.shapes[s].name;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(All, BothDialects,
                         testing::Values("classroom", "cornell-box", "living-room", "smoke-hetvol", "staircase",
                                         "staircase2", "veach-ajar", "veach-mis"),
                         test_name<testing::TestParamInfo<const char*>>);

TEST(SharedScenes, MediaScenesLoadAndAreRefusedByARender) {
  MYRIALUX_REQUIRE_SCENES();
  int n_scenes = 0, n_refused = 0;
  const std::string folder = test::scenes_folder() + "/extras/mitsuba-media-tests/tests/scenes/participating_media";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is missing";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".xml") continue;
    const Scene scene = load_scene(entry.path().string());
    ++n_scenes;
    EXPECT_GT(scene.n_triangles(), 5000u) << entry.path();
    EXPECT_EQ(scene.film.width, 48) << entry.path();
    try {
      require_renderable(scene);
    } catch (const Error& error) {
      ++n_refused;
      EXPECT_THAT(error.what(), testing::HasSubstr("medium \"")) << entry.path();
    }
  }
  EXPECT_EQ(n_scenes, 9);
  EXPECT_EQ(n_refused, 8);  // test_surf_area_light has no medium
}

TEST(SharedScenes, LoadingIsTheSameForAnyNumberOfThreads) {
  MYRIALUX_REQUIRE_SCENES();
  const std::string path = test::scenes_folder() + "/staircase2/scene.xml";
  const auto digest = [&](int n_threads) {
    const ThreadScope scope(n_threads);
    const Scene scene = load_scene(path);
    std::vector<float> numbers;
    for (const Mesh& mesh : scene.meshes)
      for (const Vec3& n : mesh.normals) numbers.insert(numbers.end(), {n.x, n.y, n.z});
    for (const Diagnostic& d : scene.diagnostics) numbers.push_back(static_cast<float>(d.at.line));
    return numbers;
  };
  const std::vector<float> one = digest(1);
  EXPECT_EQ(digest(2), one);
  EXPECT_EQ(digest(7), one);
}

}  // namespace
}  // namespace myrialux
