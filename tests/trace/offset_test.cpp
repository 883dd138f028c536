// New rays start off the surface: they never meet the triangle they left, and never slip through a thin wall behind it.
#include <gtest/gtest.h>

#include "myrialux/scene/shape_point.h"
#include "myrialux/trace/tracer.h"
#include "trace/trace_scenes.h"

namespace myrialux {

using test::random_direction;
using test::random_point;

namespace {

double dot_d(const Point3d& a, Vec3 b) { return a[0] * b.x + a[1] * b.y + a[2] * b.z; }

/// Up to 45 degrees to the surface in half of the cases, else down to 1e-7 rad, evenly in the logarithm of the cosine.
Vec3 direction_over(const Vec3& ng, Rng& rng) {
  const float u = rng.next(), turn = 2 * kPi * rng.next();
  const float z = u < 0.5f ? 0.02f + 1.96f * u : std::pow(10.0f, -14 * (u - 0.5f));
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  return Frame(ng).to_world({r * std::cos(turn), r * std::sin(turn), z});
}

struct Counts {
  std::size_t n_rays = 0, n_failed = 0;
  /// To and from a point 3 sizes away, both ends above the plane: [0] at cosines above 0.02, [1] grazing.
  std::size_t n_segments[2] = {}, n_blocked[2] = {};
  double largest_offset = 0;  ///< over the largest coordinate or edge
};

/// Leaves one triangle (or instanced triangle) n times from points that rays found on it; nothing may be hit.
void leave_one_triangle(Rng& rng, std::size_t n, bool instanced, Counts& counts) {
  const auto log_uniform = [&](float low, float high) { return low * std::pow(high / low, rng.next()); };
  const float size = log_uniform(1e-3f, 1e4f), away = rng.next() < 0.3f ? 0 : size * log_uniform(0.1f, 1000);
  const Vec3 at = random_direction(rng) * away;
  const Vec3 a = at + random_point(rng, size), b = a + random_point(rng, size);
  const float sharp = log_uniform(0.02f, 1);  // height of the third corner: some slivers
  const Vec3 c = a + (b - a) * rng.next() + random_point(rng, size * sharp);
  test::SceneBuilder builder;
  builder.mesh({a, b, c}, {0, 1, 2}, builder.diffuse(gray(0.5f)));
  if (instanced) {
    builder.scene.groups.push_back({builder.scene.placed});
    builder.scene.placed.clear();
    const Vec3 to = random_direction(rng) * (size * log_uniform(0.1f, 100));
    builder.scene.instances.push_back({0, Transform::translate(to) * test::random_rotation(rng) *
                                              Transform::scale({log_uniform(0.3f, 3), log_uniform(0.3f, 3), 1})});
  }
  const Tracer tracer(builder.scene);
  const Placement placement(instanced ? builder.scene.instances[0].to_world : Transform());
  Point3d v[3];
  for (int k = 0; k < 3; ++k) {
    const Vec3 p = builder.scene.meshes[0].positions[static_cast<std::size_t>(k)];
    v[k] = transform_point(placement.to_world, {p.x, p.y, p.z});
  }
  Point3d e[2], plane;
  for (int i = 0; i < 3; ++i) e[0][i] = v[1][i] - v[0][i], e[1][i] = v[2][i] - v[0][i];
  for (int i = 0; i < 3; ++i) plane[i] = e[0][(i + 1) % 3] * e[1][(i + 2) % 3] - e[0][(i + 2) % 3] * e[1][(i + 1) % 3];
  for (std::size_t i = 0; i < n; ++i) {
    const double b1 = rng.next(), b2 = rng.next() * (1 - b1);
    Point3d aim;
    for (int k = 0; k < 3; ++k) aim[k] = v[0][k] + b1 * e[0][k] + b2 * e[1][k];
    const Vec3 target{static_cast<float>(aim[0]), static_cast<float>(aim[1]), static_cast<float>(aim[2])};
    const Vec3 origin = target + random_direction(rng) * size;
    const auto hit = tracer.closest({origin, normalize(target - origin), kInfinity});
    if (!hit) continue;
    const Vec3 side = rng.next() < 0.5f ? hit->ng : -hit->ng;
    const Vec3 d = direction_over(side, rng);
    const double rise = dot_d(plane, d), up = dot_d(plane, side);
    if (rise * up <= 0) continue;  // rounding of d made it point below the plane
    const Vec3 start = offset_origin(hit->p, hit->ng, hit->offset, side);
    counts.n_rays += 1;
    counts.n_failed += tracer.occluded_direction(start, d);
    const Vec3 far = start + d * (3 * size);
    const Point3d over{far.x - v[0][0], far.y - v[0][1], far.z - v[0][2]};
    if ((plane[0] * over[0] + plane[1] * over[1] + plane[2] * over[2]) * up > 0) {
      const int grazing = rise * up < 0.02 * up * up;
      counts.n_segments[grazing] += 2;
      counts.n_blocked[grazing] += tracer.occluded(start, far) + tracer.occluded(far, start);
    }
    const Vec3 m = abs(hit->p);
    counts.largest_offset = std::max(counts.largest_offset, double(hit->offset) / std::max({m.x, m.y, m.z, size}));
  }
}

Counts leave_triangles(std::size_t n_triangles, std::size_t rays_each, bool instanced) {
  Counts counts;
  for (std::size_t k = 0; k < n_triangles; ++k) {
    Rng rng({14, instanced}, Stage::test, k);
    leave_one_triangle(rng, rays_each, instanced, counts);
  }
  std::printf(
      "%zu rays, %zu met their own triangle; blocked segments: %zu of %zu, grazing %zu of %zu; largest offset "
      "/ size %.3g\n",
      counts.n_rays, counts.n_failed, counts.n_blocked[0], counts.n_segments[0], counts.n_blocked[1],
      counts.n_segments[1], counts.largest_offset);
  return counts;
}

/// Rays from the surface never meet it; segments that end on it at grazing angles may, since t = 1 is rounded too: the
/// error grows with their length, and what they carry vanishes with the cosine.
void expect_rare_failures(const Counts& counts) {
  EXPECT_LT(static_cast<double>(counts.n_failed), 1e-6 * static_cast<double>(counts.n_rays));
  EXPECT_LT(static_cast<double>(counts.n_blocked[0]), 1e-6 * static_cast<double>(counts.n_segments[0]));
  EXPECT_LT(static_cast<double>(counts.n_blocked[1]), 1e-3 * static_cast<double>(counts.n_segments[1]));
  EXPECT_LT(counts.largest_offset, 1e-3);
}

TEST(Offset, RaysDoNotMeetTheTriangleTheyLeave) { expect_rare_failures(leave_triangles(500, 1000, false)); }
TEST(Offset, RaysDoNotMeetTheInstancedTriangleTheyLeave) { expect_rare_failures(leave_triangles(500, 1000, true)); }
TEST(Offset, SlowTenMillionRaysFailBelowOneInAMillion) {
  const Counts counts = leave_triangles(3000, 3400, false);
  EXPECT_GT(counts.n_rays, 10'000'000u);
  expect_rare_failures(counts);
}
TEST(Offset, SlowTenMillionRaysFromInstancesFailBelowOneInAMillion) {
  const Counts counts = leave_triangles(3000, 3400, true);
  EXPECT_GT(counts.n_rays, 10'000'000u);
  expect_rare_failures(counts);
}

struct Leaks {
  std::size_t n = 0, n_leaks = 0;                ///< of all points further than 4 ulps from a second wall
  std::size_t n_at_edges = 0, n_edge_leaks = 0;  ///< of the others: rounding may put them onto that wall
};

/// Rays that start on the inside of a closed box and find nothing have slipped through a wall.
Leaks count_leaks(Vec3 lower, Vec3 extent, std::size_t n) {
  test::SceneBuilder b;
  const Vec3 upper = lower + extent, size = max(abs(lower), abs(upper));
  b.box(lower, upper, b.diffuse(gray(0.5f)), true);
  const Tracer tracer(b.scene);
  Rng rng({15, 0}, Stage::test, 0);
  Leaks leaks;
  for (std::size_t i = 0; i < n; ++i) {
    // half of the rays start in a strip of a thousandth along the walls
    const auto inside = [&] { return rng.next() < 0.5f ? 1e-3f * rng.next() : rng.next(); };
    const float x = inside(), y = inside(), z = 0.25f + 0.5f * rng.next();
    const Vec3 from = lower + Vec3{extent.x * x, extent.y * y, extent.z * z};
    if (from.x <= lower.x || from.y <= lower.y || from.x >= upper.x || from.y >= upper.y) continue;
    const auto hit = tracer.closest({from, random_direction(rng)});
    if (!hit) {
      ++leaks.n_leaks;
      continue;
    }
    int n_near = 0;
    for (int axis = 0; axis < 3; ++axis)
      n_near += std::min(hit->p[axis] - lower[axis], upper[axis] - hit->p[axis]) <= 4 * 0x1p-23f * size[axis];
    const Vec3 d = direction_over(hit->ng, rng);
    const bool leaked = !tracer.occluded_direction(offset_origin(hit->p, hit->ng, hit->offset, d), d);
    (n_near > 1 ? leaks.n_at_edges : leaks.n) += 1;
    (n_near > 1 ? leaks.n_edge_leaks : leaks.n_leaks) += leaked;
  }
  std::printf("%zu of %zu rays leaked; within 4 ulps of an edge %zu of %zu\n", leaks.n_leaks, leaks.n,
              leaks.n_edge_leaks, leaks.n_at_edges);
  return leaks;
}

TEST(Offset, AClosedThinBoxDoesNotLeak) {
  const Leaks unit = count_leaks({0, 0, 0}, {1, 1, 1e-3f}, 500'000),
              far = count_leaks({100, 50, -20}, {10, 10, 0.01f}, 500'000);
  EXPECT_GT(unit.n + far.n, 980'000u);
  // Embree's triangles share no bits at common edges: a ray along the diagonal of a wall may pass (1 of 1e6 seen)
  EXPECT_LE(unit.n_leaks + far.n_leaks, 10u);
}

TEST(Offset, RaysDoNotMeetTheQuadricTheyLeave) {
  std::size_t n_rays = 0, n_failed = 0;
  for (std::uint64_t k = 0; k < 300; ++k) {
    Rng rng({16, 0}, Stage::test, k);
    const float size = std::pow(10.0f, 7 * rng.next() - 3);
    const auto kind = static_cast<Quadric::Kind>(k % 3);
    const Transform m = Transform::translate(random_direction(rng) * (size * 30 * rng.next())) *
                        test::random_rotation(rng) * Transform::scale({size, size, size});
    test::SceneBuilder b;
    test::add_shape(b.scene, Quadric{kind, m}, b.diffuse(gray(0.5f)));
    const Tracer tracer(b.scene);
    const bool is_disk = kind == Quadric::Kind::disk;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 target = m.point(random_point(rng, 0.5f)), from = m.point(random_direction(rng) * 3);
      const auto hit = tracer.closest({from, normalize(target - from)});
      if (!hit) continue;
      // outwards: nothing else of a convex shape is on that side
      const Vec3 side = is_disk && dot(from - hit->p, hit->ng) < 0 ? -hit->ng : hit->ng;
      if (dot(from - hit->p, side) < 0) continue;  // the cylinder's inside
      const Vec3 d = direction_over(side, rng);
      ++n_rays;
      n_failed += tracer.occluded_direction(offset_origin(hit->p, hit->ng, hit->offset, side), d);
    }
  }
  std::printf("%zu rays, %zu met their own quadric\n", n_rays, n_failed);
  EXPECT_GT(n_rays, 200'000u);
  EXPECT_EQ(n_failed, 0u);
}

}  // namespace
}  // namespace myrialux
