// Camera rays and receivers: same rays as Mitsuba, stratified, independent of threads, weights that add up.
#include "myrialux/receivers/receivers.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "myrialux/base/parallel.h"
#include "support/build_scene.h"
#include "support/statistics.h"
#include "support/test_world.h"

namespace myrialux {
namespace {

using test::Sample;
using test::TestWorld;
using test::z_score;

void expect_near(Vec3 a, Vec3 b, float tolerance) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(a[axis], b[axis], tolerance);
}

// Rays of Mitsuba 3.9.1 (scalar_rgb): perspective, fov 39, look_at (1 2 3) -> (-1 0.5 -2), near 0.01, far 100, 40 x 30.
TEST(CameraRay, EqualsMitsuba) {
  Camera camera;
  camera.to_world = Transform::look_at({1, 2, 3}, {-1, 0.5f, -2}, {0, 1, 0});
  camera.fov_x_deg = 39;
  camera.near_clip = 0.01f, camera.far_clip = 100;
  struct Case {
    float principal_x, principal_y;
    Vec2 position;
    Vec3 origin, direction;
    float t_max;
  };
  for (const Case& c :
       {Case{0, 0, {20, 15}, {0.996422f, 1.99732f, 2.99106f}, {-0.357771f, -0.268328f, -0.894427f}, 99.98999f},
        Case{0, 0, {4, 24}, {0.993951f, 1.99578f, 2.9925f}, {-0.575296f, -0.401177f, -0.712805f}, 105.13935f},
        Case{0.1f, -0.2f, {20, 15}, {0.996974f, 1.99834f, 2.99053f}, {-0.300163f, -0.164652f, -0.93957f}, 100.80172f},
        Case{
            0.1f, -0.2f, {4, 24}, {0.994502f, 1.99681f, 2.99198f}, {-0.537024f, -0.312101f, -0.783708f}, 102.35995f}}) {
    camera.principal_x = c.principal_x, camera.principal_y = c.principal_y;
    const Ray ray = camera_ray(camera, 40, 30, {c.position});
    expect_near(ray.origin, c.origin, 1e-5f);  // printed with 6 digits
    expect_near(ray.direction, c.direction, 2e-6f);
    EXPECT_NEAR(ray.t_max, c.t_max, 2e-4f);
  }
}

TEST(FilmPosition, EveryCellOfAPixelHoldsOneSample) {
  struct Case {
    int spp, columns, rows;
  };
  for (const Case c : {Case{1, 1, 1}, Case{4, 2, 2}, Case{6, 3, 2}, Case{7, 7, 1}, Case{16, 4, 4}}) {
    std::set<int> cells;
    for (int k = 0; k < c.spp; ++k) {
      const Vec2 p = film_position(5, 13, k, c.spp, {3, 1});  // pixel (3, 2)
      ASSERT_TRUE(p.x >= 3 && p.x < 4 && p.y >= 2 && p.y < 3);
      cells.insert(static_cast<int>((p.y - 2) * static_cast<float>(c.rows)) * c.columns +
                   static_cast<int>((p.x - 3) * static_cast<float>(c.columns)));
    }
    EXPECT_EQ(cells.size(), static_cast<std::size_t>(c.spp));
  }
}

TEST(FilmPosition, EverySampleIsUniformOverThePixel) {
  for (const int k : {0, 3}) {
    Sample x, xx;
    for (std::uint64_t pixel = 0; pixel < 4000; ++pixel) {
      const Vec2 p = film_position(1, pixel, k, 4, {9, 0});
      x.add(static_cast<double>(p.x)), xx.add(static_cast<double>(p.x * p.x));
    }
    EXPECT_LT(std::fabs(z_score(x, 0.5)), 4);
    EXPECT_LT(std::fabs(z_score(xx, 1.0 / 3)), 4);
  }
}

template <class T>
bool same_bits(const Array<T>& a, const Array<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

TEST(Receivers, SameBitsForAnyNumberOfThreads) {
  TestWorld t(test::plastic_floor_box());
  Progress quiet;
  const ReceiverParams params{.width = 23, .height = 17, .spp = 3, .key = {5, 2}};
  const auto trace = [&](int n_threads) {
    const ThreadScope threads(n_threads);
    return trace_receivers(t.world, params, quiet);
  };
  const ReceiverResult one = trace(1);
  EXPECT_GT(one.receivers.size(), 500u);
  for (const int n : {2, 7}) {
    const ReceiverResult many = trace(n);
    EXPECT_TRUE(same_bits(one.receivers.p, many.receivers.p));
    EXPECT_TRUE(same_bits(one.receivers.beta, many.receivers.beta));
    EXPECT_TRUE(same_bits(one.receivers.bsdf, many.receivers.bsdf));
    EXPECT_TRUE(same_bits(one.receivers.sample, many.receivers.sample));
    EXPECT_TRUE(same_bits(one.samples.emission, many.samples.emission));
    EXPECT_EQ(one.camera_rays, many.camera_rays);
  }
  ReceiverParams other = params;
  other.key.seed = 6;
  EXPECT_FALSE(same_bits(one.receivers.p, trace_receivers(t.world, other, quiet).receivers.p));
}

TEST(Receivers, ThoseOfManyBlocksCloseUpInOrder) {
  // A wall that half of the samples miss: most blocks have gaps, and there are more blocks than are moved at once.
  test::SceneBuilder b;
  b.rectangle({-9, -9, 0}, {18, 0, 0}, {0, 17.3f, 0}, b.diffuse(gray(0.5f), true));
  b.emitter("sky", ConstantEmitter{gray(2)});
  b.camera({0, 8, 4}, {0, 8, 0}, 60, 4, 4);
  TestWorld t(b.scene);
  Progress quiet;
  const ReceiverParams params{.width = 1024, .height = 600, .spp = 1, .key = {5, 2}};
  ReceiverResult first;
  for (const int n_threads : {1, 2, 7}) {
    const ThreadScope threads(n_threads);
    ReceiverResult r = trace_receivers(t.world, params, quiet);
    const std::size_t n = r.receivers.size();
    ASSERT_GT(n, 100000u);
    ASSERT_LT(n, 500000u);
    EXPECT_EQ(r.receivers.wo.size(), n);
    for (std::size_t i = 1; i < n; ++i) ASSERT_LT(r.receivers.sample[i - 1], r.receivers.sample[i]);
    for (std::size_t i = 0; i < n; ++i)
      ASSERT_NEAR(length(r.receivers.p[i] - Vec3{0, 8, 4}), r.samples.depth[r.receivers.sample[i]], 1e-3f);
    if (n_threads == 1)
      first = std::move(r);
    else
      EXPECT_TRUE(same_bits(first.receivers.p, r.receivers.p) && same_bits(first.receivers.bsdf, r.receivers.bsdf));
  }
}

TEST(Receivers, FollowMirrorsToTheFirstWideSurface) {
  // A mirror of reflectance 0.8 at 45 degrees sends the view down to a wall.
  test::SceneBuilder b;
  Material mirror;
  mirror.kind = BsdfKind::conductor;
  mirror.specular = {gray(0.8f)};
  const MaterialId m = b.add(mirror);
  b.mesh({{-1, -1, -1}, {1, -1, -1}, {1, 1, 1}, {-1, 1, 1}}, {0, 1, 2, 0, 2, 3}, m);  // faces the camera, tilted down
  b.rectangle({-1, -5, -2}, {2, 0, 0}, {0, 0, 4}, b.diffuse(gray(0.5f), true));       // below
  b.emitter("sky", ConstantEmitter{gray(2)});
  b.scene.materials[index(m)].two_sided = true;
  b.camera({0, 0, 4}, {0, 0, 0}, 5, 4, 4);
  TestWorld t(b.scene);
  Progress quiet;
  const ReceiverResult r = trace_receivers(t.world, {.width = 4, .height = 4, .spp = 4, .key = {1, 0}}, quiet);
  ASSERT_EQ(r.receivers.size(), 64u);
  for (std::size_t i = 0; i < r.receivers.size(); ++i) {
    EXPECT_EQ(r.receivers.depth[i], 2);
    EXPECT_NEAR(r.receivers.beta[i].r, 0.8f, 1e-6f);
    EXPECT_NEAR(r.receivers.p[i].y, -5, 1e-4f);
    EXPECT_GT(dot(r.receivers.n[i], r.receivers.wo[i]), 0);
    EXPECT_GT(dot(r.receivers.ng[i], r.receivers.n[i]), 0);
    EXPECT_EQ(r.samples.emission[r.receivers.sample[i]], Rgb{});
    EXPECT_NEAR(r.samples.depth[i], 4, 0.2f);
  }
}

TEST(Receivers, EnvironmentIsSeenDirectlyAndNothingElse) {
  test::SceneBuilder b;
  b.rectangle({-1, -1, 5}, {2, 0, 0}, {0, 2, 0}, b.diffuse(gray(0.5f)));  // behind the camera
  b.emitter("sky", ConstantEmitter{{1, 2, 3}});
  b.camera({0, 0, 4}, {0, 0, 0}, 30, 8, 8);
  for (const bool hide : {false, true}) {
    b.scene.hide_emitters = hide;
    TestWorld t(b.scene);
    Progress quiet;
    const ReceiverResult r = trace_receivers(t.world, {.width = 8, .height = 8, .spp = 1, .key = {1, 0}}, quiet);
    EXPECT_EQ(r.receivers.size(), 0u);
    for (const Rgb& e : r.samples.emission) EXPECT_EQ(e, (hide ? Rgb{} : Rgb{1, 2, 3}));
    for (const float d : r.samples.depth) EXPECT_EQ(d, kInfinity);
  }
}

TEST(Receivers, WeightsOfAVarnishedFloorAddUpToOne) {
  test::SceneBuilder b;
  Material varnish;
  varnish.kind = BsdfKind::plastic;
  varnish.eta = 1.5f;
  b.rectangle({-9, -1, 9}, {18, 0, 0}, {0, 0, -18}, b.add(varnish));
  b.emitter("sky", ConstantEmitter{gray(1)});
  b.camera({0, 1, 3}, {0, -1, 0}, 5, 8, 8);
  TestWorld t(b.scene);
  Progress quiet;
  Sample weight;
  for (std::uint32_t pass = 0; pass < 60; ++pass) {
    const ReceiverResult r = trace_receivers(t.world, {.width = 8, .height = 8, .spp = 4, .key = {1, pass}}, quiet);
    double sum = 0;
    for (const Rgb& beta : r.receivers.beta) sum += static_cast<double>(beta.r);
    weight.add(sum / 256);
  }
  EXPECT_LT(std::fabs(z_score(weight, 1)), 4) << weight.mean;
}

TEST(Receivers, NoneWhereMaxDepthLeavesNoEdge) {
  TestWorld t(test::cornell_box(), 1);
  Progress quiet;
  const ReceiverResult r = trace_receivers(t.world, {.width = 8, .height = 8, .spp = 1, .key = {1, 0}}, quiet);
  EXPECT_EQ(r.receivers.size(), 0u);
}

TEST(Receivers, CountsViewsOfBacksOfOneSidedSurfaces) {
  test::SceneBuilder b;
  b.area_emitter(b.sphere({0, 0, 0}, 1, b.diffuse(gray(0.5f))), gray(1));  // normals outwards, camera inside
  b.camera({0, 0, 0}, {0, 0, -1}, 60, 8, 8);
  TestWorld t(b.scene);
  Progress quiet;
  const ReceiverResult r = trace_receivers(t.world, {.width = 8, .height = 8, .spp = 2, .key = {1, 0}}, quiet);
  EXPECT_EQ(r.inside_walls, 128u);
  EXPECT_EQ(r.receivers.size(), 0u);
}

TEST(Receivers, VertexIsRebuiltAsItWas) {
  TestWorld t(test::glossy_floor_box(0.3f));
  Progress quiet;
  const ReceiverResult r = trace_receivers(t.world, {.width = 16, .height = 16, .spp = 1, .key = {1, 0}}, quiet);
  for (std::size_t i = 0; i < r.receivers.size(); ++i) {
    const Vec3 origin = t.scene.camera.to_world.point({});
    const Vec3 direction = normalize(r.receivers.p[i] - origin);
    const auto hit = t.tracer.closest({origin, direction, kInfinity});
    ASSERT_TRUE(hit);
    const Vertex now = make_vertex(t.world, *hit, -direction), then = receiver_vertex(t.world, r.receivers, i);
    if (now.params.material != then.params.material) continue;  // rounding at an edge
    EXPECT_EQ(now.n, then.n);
    const Vec3 wi = now.to_local(normalize(now.n + Vec3{0.3f, 0.1f, 0.2f}));
    const Rgb a = evaluate(now.bsdf, wi, now.to_local(now.wo), Lobes::wide);
    const Rgb b = evaluate(then.bsdf, wi, then.to_local(then.wo), Lobes::wide);
    EXPECT_NEAR(a.r, b.r, 1e-3f * a.r + 1e-5f);
  }
}

}  // namespace
}  // namespace myrialux
