// Closest hits and occlusion against slow, obvious answers; surface points against what Mitsuba 3.9.1 gives.
#include <gtest/gtest.h>

#include <array>

#include "myrialux/scene/shape_point.h"
#include "myrialux/trace/tracer.h"
#include "trace/trace_scenes.h"

namespace myrialux {

using test::random_direction;
using test::random_point;

namespace {

/// Möller-Trumbore in double [moller97]; `margin`: smallest distance to an edge in barycentric coordinates.
struct TriangleHit {
  bool hit = false;
  double t = 0, margin = 0;
};
TriangleHit meet(const Mesh& mesh, std::size_t triangle, const Ray& ray) {
  std::array<Point3d, 3> v;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 p = mesh.positions[mesh.indices[3 * triangle + k]];
    v[k] = {p.x, p.y, p.z};
  }
  const auto minus = [](const Point3d& a, const Point3d& b) { return Point3d{a[0] - b[0], a[1] - b[1], a[2] - b[2]}; };
  const auto cross = [](const Point3d& a, const Point3d& b) {
    return Point3d{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const auto dot = [](const Point3d& a, const Point3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const Point3d o{ray.origin.x, ray.origin.y, ray.origin.z}, d{ray.direction.x, ray.direction.y, ray.direction.z};
  const Point3d e1 = minus(v[1], v[0]), e2 = minus(v[2], v[0]), s = minus(o, v[0]), h = cross(d, e2), q = cross(s, e1);
  const double det = dot(e1, h), b1 = dot(s, h) / det, b2 = dot(d, q) / det, t = dot(e2, q) / det;
  TriangleHit found;
  found.margin = std::min({b1, b2, 1 - b1 - b2});
  found.t = t;
  found.hit = found.margin >= 0 && t > 0 && t <= ray.t_max;
  return found;
}

TEST(Closest, AgreesWithBruteForceOnATriangleSoup) {
  test::SceneBuilder b;
  test::add_mesh(b.scene, test::triangle_soup(300, 0.3f, 1), b.diffuse(gray(0.5f)));
  const Mesh& mesh = b.scene.meshes[0];
  const Tracer tracer(b.scene);
  Rng rng({1, 0}, Stage::test, 0);
  int n_hits = 0, n_unclear = 0;
  constexpr int kRays = 20'000;
  for (int i = 0; i < kRays; ++i) {
    const Vec3 from = random_point(rng, 1.5f), to = random_point(rng, 1.5f);
    const Ray ray{from, to - from, i % 2 ? 1.0f : kInfinity};
    double nearest = kInfinity;
    std::size_t which = 0;
    bool unclear = false;  // within rounding of an edge or of the segment's end
    for (std::size_t k = 0; k < mesh.n_triangles(); ++k) {
      const TriangleHit at = meet(mesh, k, ray);
      unclear |= std::fabs(at.margin) < 1e-5 || std::fabs(at.t - 1) < 1e-5;
      if (at.hit && at.t < nearest) nearest = at.t, which = k;
    }
    if (unclear) {
      ++n_unclear;
      continue;
    }
    const auto hit = tracer.closest(ray);
    ASSERT_EQ(hit.has_value(), nearest < kInfinity) << i;
    ASSERT_EQ(i % 2 ? tracer.occluded(from, to) : tracer.occluded_direction(from, to - from), hit.has_value()) << i;
    if (!hit) continue;
    ++n_hits;
    ASSERT_EQ(hit->primitive, which);
    ASSERT_NEAR(hit->t, nearest, 1e-6 + 1e-4 * nearest);  // float test of grazing triangles
    const Vec3 along = from + (to - from) * static_cast<float>(nearest);
    ASSERT_LT(length(hit->p - along), 2e-5f * (1 + static_cast<float>(nearest)));
  }
  EXPECT_GT(n_hits, kRays / 4);
  EXPECT_LT(n_unclear, kRays / 50);
}

TEST(Closest, QuadricsAgreeWithTheirImplicitEquations) {
  Rng rng({2, 0}, Stage::test, 0);
  int n_hits = 0;
  for (int k = 0; k < 30; ++k) {
    const auto kind = static_cast<Quadric::Kind>(k % 3);
    const float size = 0.1f + 3 * rng.next();
    const Transform m =
        Transform::translate(random_point(rng, 5)) * test::random_rotation(rng) * Transform::scale({size, size, size});
    const Transform back = m.inverse();
    test::SceneBuilder b;
    test::add_shape(b.scene, Quadric{kind, m}, b.diffuse(gray(0.5f)));
    const Tracer tracer(b.scene);
    for (int i = 0; i < 500; ++i) {
      const Vec3 from = m.point(random_point(rng, 3)), target = m.point(random_point(rng, 1.2f));
      const Vec3 w = normalize(target - from);
      // March along the ray in small steps: where does the implicit function change its sign?
      const auto inside = [&](double t) {
        const Point3d p = transform_point(back, {from.x + t * w.x, from.y + t * w.y, from.z + t * w.z});
        const double r2 = p[0] * p[0] + p[1] * p[1];
        if (kind == Quadric::Kind::disk) return p[2] > 0;
        return kind == Quadric::Kind::sphere ? r2 + p[2] * p[2] < 1 : r2 < 1;
      };
      const auto counts = [&](double t) {
        const Point3d p = transform_point(back, {from.x + t * w.x, from.y + t * w.y, from.z + t * w.z});
        if (kind == Quadric::Kind::disk) return p[0] * p[0] + p[1] * p[1] <= 1;
        return kind == Quadric::Kind::sphere || (p[2] >= 0 && p[2] <= 1);
      };
      constexpr int kSteps = 1500;
      const double step = 9.0 * size / kSteps;
      double expected = -1;
      for (int s = 0; s < kSteps && expected < 0; ++s) {
        double low = s * step, high = low + step;
        if (inside(low) == inside(high)) continue;
        for (int halving = 0; halving < 40; ++halving)
          (inside(0.5 * (low + high)) == inside(low) ? low : high) = 0.5 * (low + high);
        if (counts(low)) expected = low;
      }
      const auto hit = tracer.closest({from, w, static_cast<float>(9.0 * size)});
      if (hit.has_value() != (expected >= 0)) {
        // the march steps over chords shorter than a step, and edges are a matter of rounding
        ASSERT_TRUE(hit.has_value()) << "kind " << k % 3;
        continue;
      }
      if (!hit) continue;
      ++n_hits;
      if (hit->t < expected - 2 * step) continue;  // a short chord came first
      ASSERT_NEAR(hit->t, expected, 1e-5 * size + 1e-5 * expected) << "kind " << k % 3;
      ASSERT_NEAR(length(hit->p - (from + w * static_cast<float>(expected))), 0, 1e-5f * (10 + size));
      ASSERT_NEAR(length(hit->ng), 1, 1e-6f);
    }
  }
  EXPECT_GT(n_hits, 3000);
}

TEST(Closest, InstancesEqualTheirFlattenedCopies) {
  test::SceneBuilder groups, flat;
  const MaterialId material = groups.diffuse(gray(0.5f));
  flat.diffuse(gray(0.5f));
  const Mesh soup = test::triangle_soup(200, 0.3f, 5);
  groups.scene.groups.push_back({{test::add_mesh(groups.scene, soup, material, false)}});
  Rng rng({3, 0}, Stage::test, 0);
  for (int k = 0; k < 4; ++k) {
    const Transform m = Transform::translate(random_point(rng, 2)) * test::random_rotation(rng) *
                        Transform::scale({k % 2 ? -1.0f : 1.0f, 0.5f + rng.next(), 1});
    groups.scene.instances.push_back({0, m});
    Mesh copy = soup;
    for (Vec3& p : copy.positions) p = m.point(p);
    test::add_mesh(flat.scene, copy, material);
  }
  const Tracer a(groups.scene), b(flat.scene);
  int n_hits = 0, n_differ = 0, n_blocked_differ = 0;
  constexpr int kRays = 50'000;
  for (int i = 0; i < kRays; ++i) {
    const Vec3 from = random_point(rng, 3), to = random_point(rng, 3);
    n_blocked_differ += a.occluded(from, to) != b.occluded(from, to);
    const auto p = a.closest({from, normalize(to - from)}), q = b.closest({from, normalize(to - from)});
    if (p.has_value() != q.has_value() || (p && (p->primitive != q->primitive || std::fabs(p->t - q->t) > 1e-4f))) {
      ++n_differ;  // rays within rounding of an edge
      continue;
    }
    if (!p) continue;
    ++n_hits;
    // the copies' corners are rounded: along the ray this grows with 1 / cosine
    ASSERT_LT(length(p->p - q->p), 2e-6f + 2e-6f / std::fabs(dot(q->ng, normalize(to - from))));
    ASSERT_GT(std::fabs(dot(p->ng, q->ng)), 0.999f);
  }
  EXPECT_GT(n_hits, kRays / 4);
  EXPECT_LT(n_differ, kRays / 1000);
  EXPECT_LT(n_blocked_differ, kRays / 1000);
}

TEST(Closest, OcclusionIsSymmetric) {
  test::SceneBuilder b;
  test::add_mesh(b.scene, test::triangle_soup(500, 0.3f, 8), b.diffuse(gray(0.5f)));
  const Tracer tracer(b.scene);
  Rng rng({4, 0}, Stage::test, 0);
  int n_differ = 0;
  constexpr int kSegments = 200'000;
  for (int i = 0; i < kSegments; ++i) {
    const auto from = tracer.closest({random_point(rng, 1.5f), random_direction(rng)}),
               to = tracer.closest({random_point(rng, 1.5f), random_direction(rng)});
    if (!from || !to) continue;
    const Vec3 d = to->p - from->p, a = offset_origin(from->p, from->ng, from->offset, d),
               c = offset_origin(to->p, to->ng, to->offset, -d);
    n_differ += tracer.occluded(a, c) != tracer.occluded(c, a);
  }
  EXPECT_LE(n_differ, kSegments / 50'000);  // edges only
}

TEST(Masks, BlockWithTheProbabilityOfTheirOpacity) {
  for (const bool is_sphere : {false, true}) {
    test::SceneBuilder b;
    Material m;
    m.opacity = {gray(0.3f)};
    const MaterialId material = b.add(m);
    if (is_sphere)
      b.sphere({0, 0, 0}, 1, material);
    else
      b.rectangle({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, material);
    const Tracer tracer(b.scene);
    Rng rng({5, 0}, Stage::test, is_sphere);
    constexpr int kRays = 200'000;
    int n_blocked = 0, n_stopped = 0;
    for (int i = 0; i < kRays; ++i) {
      const float x = 0.1f * rng.next(), y = 0.1f * rng.next();
      n_blocked += tracer.occluded({x, y, 2}, {y - 0.5f, x, -2});
      n_stopped += tracer.closest({{x, y, 2}, {0, 0, -1}}).has_value();
    }
    const double opacity = is_sphere ? 1 - 0.7 * 0.7 : 0.3;  // a sphere is crossed twice
    const double sigma = std::sqrt(opacity * (1 - opacity) / kRays);
    EXPECT_NEAR(double(n_blocked) / kRays, opacity, 4 * sigma);
    EXPECT_NEAR(double(n_stopped) / kRays, opacity, 4 * sigma);
  }
}

TEST(Masks, NullSurfacesAreFoundButNeverBlock) {
  for (const bool is_sphere : {false, true}) {
    test::SceneBuilder b;
    Material m;
    m.kind = BsdfKind::null;
    const MaterialId material = b.add(m);
    is_sphere ? b.sphere({0, 0, 0}, 1, material) : b.rectangle({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, material);
    const Tracer tracer(b.scene);
    EXPECT_TRUE(tracer.closest({{0.3f, 0.2f, 2}, {0, 0, -1}}).has_value());
    EXPECT_FALSE(tracer.occluded({0.3f, 0.2f, 2}, {0.3f, 0.2f, -2}));
    Segments<8> s{};
    for (int k = 0; k < 8; ++k) s.from_z[k] = 2, s.to_z[k] = -2, s.from_x[k] = s.to_x[k] = 0.1f;
    EXPECT_EQ(tracer.occluded_packet(s, 0xff, true), 0u);
  }
}

/// A hit of Mitsuba 3.9.1 (scalar_rgb).
struct Measured {
  Quadric::Kind kind;
  bool flip, mirrored;  ///< mirrored: to_world = scale(-1, 1, 1)
  Vec3 origin, direction;
  float t;
  Vec3 n;
  Vec2 uv;
};
constexpr auto kSphere = Quadric::Kind::sphere;
constexpr auto kDisk = Quadric::Kind::disk;
constexpr auto kCylinder = Quadric::Kind::cylinder;
const Measured kMeasured[] = {
    {kSphere, false, false, {3, .5f, .2f}, {-1, 0, 0}, 2.1573851f, {.842615f, .5f, .2f}, {.0852348f, .435906f}},
    {kSphere, false, false, {-.1f, -3, .4f}, {0, 1, 0}, 2.0889566f, {-.1f, -.911043f, .4f}, {.7326f, .36901f}},
    {kSphere, true, false, {3, .5f, .2f}, {-1, 0, 0}, 2.1573851f, {-.842615f, -.5f, -.2f}, {.0852348f, .435906f}},
    {kSphere, false, true, {3, .5f, .2f}, {-1, 0, 0}, 2.1573851f, {-.842615f, -.5f, -.2f}, {.414765f, .435906f}},
    {kDisk, false, false, {.3f, .4f, 2}, {0, 0, -1}, 2, {0, 0, 1}, {.5f, .147584f}},
    {kDisk, true, false, {.3f, -.4f, -2}, {0, 0, 1}, 2, {0, 0, -1}, {.5f, .852416f}},
    {kDisk, false, true, {.3f, .4f, 2}, {0, 0, -1}, 2, {0, 0, 1}, {.5f, .352416f}},
    {kCylinder, false, false, {3, .5f, .2f}, {-1, 0, 0}, 2.1339746f, {.866025f, .5f, 0}, {.0833334f, .2f}},
    {kCylinder, true, false, {.1f, -3, .7f}, {0, 1, 0}, 2.0050125f, {-.1f, .994987f, 0}, {.765942f, .7f}},
    {kCylinder, false, true, {3, .5f, .2f}, {-1, 0, 0}, 2.1339743f, {.866025f, .5f, 0}, {.416667f, .2f}},
};

TEST(SurfacePoints, OfQuadricsAreThoseOfMitsuba) {
  for (const Measured& m : kMeasured) {
    test::SceneBuilder b;
    const Transform to_world = m.mirrored ? Transform::scale({-1, 1, 1}) : Transform();
    const ShapeId shape = test::add_shape(b.scene, Quadric{m.kind, to_world}, b.diffuse(gray(0.5f)));
    b.scene.shapes[index(shape)].flip_normals = m.flip;
    const auto hit = Tracer(b.scene).closest({m.origin, m.direction});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->t, m.t, 1e-5f);
    EXPECT_LT(length(hit->ng - m.n), 1e-5f) << "kind " << static_cast<int>(m.kind);
    EXPECT_NEAR(hit->uv.x, m.uv.x, 1e-5f);
    EXPECT_NEAR(hit->uv.y, m.uv.y, 1e-5f);
  }
}

TEST(SurfacePoints, OfMeshesAreThoseOfMitsuba) {
  const Vec3 n[] = {normalize({.1f, 0, -1}), {0, 0, -1}, normalize({0, .2f, -1})};
  const Vec3 shading{.0300225f, .0788968f, -.996431f};  // interpolated, not turned to the side of ng
  for (const bool flip : {false, true})
    for (const bool instanced : {false, true}) {
      test::SceneBuilder b;
      const ShapeId shape = b.mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2}, b.diffuse(gray(0.5f)));
      b.scene.meshes[0].normals.assign(n, n + 3);
      b.scene.shapes[index(shape)].flip_normals = flip;
      if (instanced) {
        b.scene.placed.clear();
        b.scene.groups.push_back({{shape}});
        b.scene.instances.push_back({0, Transform::scale({-1, 1, 1})});
      }
      const float mirror = instanced ? -1.0f : 1.0f, sign = flip ? -1.0f : 1.0f;
      const auto hit = Tracer(b.scene).closest({{mirror * .3f, .4f, 2}, {0, 0, -1}});
      ASSERT_TRUE(hit);
      EXPECT_LT(length(hit->p - Vec3{mirror * .3f, .4f, 0}), 1e-6f);
      EXPECT_LT(length(hit->ng - Vec3{0, 0, sign}), 1e-6f);
      EXPECT_LT(length(hit->n - Vec3{mirror * shading.x, shading.y, shading.z} * sign), 1e-5f);
      EXPECT_NEAR(hit->uv.x, .3f, 1e-6f);
      EXPECT_NEAR(hit->uv.y, .4f, 1e-6f);
    }
}

TEST(Tracer, KnowsItsBoundsAndMemoryAndStandsEmptyScenes) {
  const Scene scene = test::mixed_scene();
  const Tracer tracer(scene);
  const Box3 exact = scene.bounds(), found = tracer.bounds();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LT(found.lower[axis], -1);
    EXPECT_GE(found.lower[axis], exact.lower[axis] - 1e-3f);
    EXPECT_LE(found.upper[axis], exact.upper[axis] + 1e-3f);
  }
  EXPECT_GT(tracer.memory_bytes(), 10'000u);
  Scene empty;
  const Tracer nothing(empty);
  EXPECT_FALSE(nothing.closest({{0, 0, 0}, {0, 0, 1}}).has_value());
  EXPECT_FALSE(nothing.occluded({0, 0, 0}, {1, 1, 1}));
}

}  // namespace
}  // namespace myrialux
