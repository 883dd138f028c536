// Transfer: exact geometry, symmetry, clamping, and agreement of activity with the value.
#include "myrialux/transfer/transfer.h"

#include <gtest/gtest.h>

#include "support/random_room.h"

namespace myrialux {
namespace {

using test::Room;
using test::RoomOptions;

const std::vector<LightKind> kAllKinds = {LightKind::oriented, LightKind::glossy, LightKind::point,
                                          LightKind::directional};

/// Calls visit(i, j) for all entries.
template <class Visit>
void for_all(const Room& room, const Visit& visit) {
  for (std::size_t i = 0; i < room.receivers.size(); ++i)
    for (std::size_t j = 0; j < room.lights.size(); ++j) visit(static_cast<ReceiverId>(i), static_cast<LightId>(j));
}

float distance_between(const Room& room, ReceiverId i, LightId j) {
  return length(room.lights.p[index(j)] - room.receivers.p[index(i)]);
}

TEST(Transfer, InsideASphereIsTheSameForEveryPair) {
  // Two points of a sphere of radius R, normals inwards: cos cos / d^2 = 1 / (4 R^2).
  constexpr float kR = 1.7f;
  Room room({.n_receivers = 1, .n_lights = 1});
  room.receivers.bsdf[0] = {.material = MaterialId{0}, .reflectance = gray(kPi), .specular = {}};  // f = 1
  room.lights.light[0] = {1, 2, 3};
  Rng rng({5}, Stage::test, 0);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 a = sample_sphere({rng.next(), rng.next()}), b = sample_sphere({rng.next(), rng.next()});
    if (length(a - b) < 0.05f) continue;
    room.receivers.p[0] = a * kR, room.receivers.n[0] = room.receivers.ng[0] = room.receivers.wo[0] = -a;
    room.lights.p[0] = b * kR, room.lights.n[0] = room.lights.ng[0] = -b;
    const Rgb t = transfer(room.world(), room.receivers, ReceiverId{0}, room.lights, LightId{0}, 0);
    // Cosines are d / 2 R: rounding of p, about 1e-7, counts 2 R / d times.
    const float expected = 1 / (4 * kR * kR), tolerance = 1e-6f / length(a - b);
    EXPECT_NEAR(t.r, expected, tolerance);
    EXPECT_NEAR(t.b, 3 * expected, 3 * tolerance);
  }
}

TEST(Transfer, OfDiffusePairsIsSymmetric) {
  const Room room({.n_receivers = 40, .n_lights = 200});
  Room swapped({.n_receivers = 1, .n_lights = 1});
  for_all(room, [&](ReceiverId i, LightId j) {
    swapped.receivers.p[0] = room.lights.p[index(j)];
    swapped.receivers.n[0] = swapped.receivers.ng[0] = swapped.receivers.wo[0] = room.lights.n[index(j)];
    swapped.receivers.bsdf[0] = room.receivers.bsdf[index(i)];
    swapped.lights.p[0] = room.receivers.p[index(i)];
    swapped.lights.n[0] = swapped.lights.ng[0] = room.receivers.n[index(i)];
    swapped.lights.light[0] = room.lights.light[index(j)];
    const float there = luminance(transfer(room.world(), room.receivers, i, room.lights, j, 0));
    const float back =
        luminance(transfer(swapped.world(), swapped.receivers, ReceiverId{0}, swapped.lights, LightId{0}, 0));
    EXPECT_NEAR(there, back, 1e-4f * there + 1e-6f);
  });
}

TEST(Transfer, IsClampedByTheSmallerOfBothGeometryTerms) {
  const Room room({.n_receivers = 40, .n_lights = 200, .kinds = kAllKinds, .glossy = true, .glass = true});
  constexpr float kClamp = 0.8f;
  std::size_t clamped = 0;
  for_all(room, [&](ReceiverId i, LightId j) {
    const float full = transfer(room.world(), room.receivers, i, room.lights, j, 0).g;
    const float bounded = transfer(room.world(), room.receivers, i, room.lights, j, kClamp).g;
    const float d = distance_between(room, i, j);
    const bool distant = room.lights.kind[index(j)] == LightKind::directional;
    const float factor = distant ? 1 : std::min(1.0f, d * d / (kClamp * kClamp));
    EXPECT_NEAR(bounded, full * factor, 1e-5f * full);
    clamped += factor < 1 && full > 0;
  });
  EXPECT_GT(clamped, 100u);
}

TEST(Transfer, OfADoubledLightIsExactlyDouble) {
  const Room room({.n_receivers = 20, .n_lights = 200, .kinds = kAllKinds, .glossy = true, .glass = true});
  Room doubled({.n_receivers = 20, .n_lights = 200, .kinds = kAllKinds, .glossy = true, .glass = true});
  for (Rgb& light : doubled.lights.light) light *= 2;
  for_all(room, [&](ReceiverId i, LightId j) {
    EXPECT_EQ(transfer(room.world(), room.receivers, i, room.lights, j, 0.1f) * 2,
              transfer(doubled.world(), doubled.receivers, i, doubled.lights, j, 0.1f));
  });
}

TEST(Transfer, IsZeroExactlyWhereTheEntryIsNotActive) {
  for (const float tilt : {0.0f, 0.5f}) {
    const Room room(
        {.n_receivers = 100, .n_lights = 400, .kinds = kAllKinds, .glossy = true, .glass = true, .shading_tilt = tilt});
    std::size_t active = 0, positive = 0, negative = 0;
    for_all(room, [&](ReceiverId i, LightId j) {
      const Rgb t = transfer(room.world(), room.receivers, i, room.lights, j, 0.01f);
      negative += !(t.r >= 0 && t.g >= 0 && t.b >= 0 && is_finite(t));
      if (!is_active(room.world(), room.receivers, i, room.lights, j)) {
        EXPECT_TRUE(is_black(t));
        return;
      }
      ++active;
      positive += !is_black(t);
    });
    EXPECT_EQ(negative, 0u);
    EXPECT_GT(active, 2000u);
    EXPECT_GT(positive, active * 9 / 10);  // rough glass: some directions have no facet that refracts them
  }
}

TEST(Transfer, NeedsBothNormalsOnTheSameSide) {
  Room room({.n_receivers = 1, .n_lights = 1});
  room.receivers.p[0] = {0, 0, 0}, room.lights.p[0] = {0, 0, 1};
  room.lights.n[0] = room.lights.ng[0] = {0, 0, -1};
  const Vec3 up{0.6f, 0, 0.8f}, down{0.6f, 0, -0.8f};
  const auto active = [&](Vec3 ng, Vec3 n) {
    room.receivers.ng[0] = ng, room.receivers.n[0] = n;
    return is_active(room.world(), room.receivers, ReceiverId{0}, room.lights, LightId{0});
  };
  EXPECT_TRUE(active(up, up));
  EXPECT_FALSE(active(up, down));
  EXPECT_FALSE(active(down, up));
  EXPECT_FALSE(active(down, down));
  room.receivers.bsdf[0].material = Room::kGlass;
  EXPECT_TRUE(active(up, up));
  EXPECT_FALSE(active(up, down));
  EXPECT_FALSE(active(down, up));
  EXPECT_TRUE(active(down, down));
}

TEST(Transfer, OfAGlossyLightHasTheGeometricCosineOfDeparture) {
  // f(wi, w) |w . ng|: the same light seen with another geometric normal differs by the ratio of the cosines.
  Room room({.n_receivers = 30, .n_lights = 100, .kinds = {LightKind::glossy}});
  for_all(room, [&](ReceiverId i, LightId j) {
    const Vec3 n = room.lights.n[index(j)], w = normalize(room.receivers.p[index(i)] - room.lights.p[index(j)]);
    const Vec3 ng = normalize(n + Frame(n).s * 0.3f);
    room.lights.ng[index(j)] = n;
    const float straight = transfer(room.world(), room.receivers, i, room.lights, j, 0).g;
    room.lights.ng[index(j)] = ng;
    if (!is_active(room.world(), room.receivers, i, room.lights, j)) return;
    const float tilted = transfer(room.world(), room.receivers, i, room.lights, j, 0).g;
    EXPECT_NEAR(tilted * dot(n, w), straight * dot(ng, w), 2e-4f * straight);
  });
}

TEST(Transfer, OfASpotFallsFromBeamToCutoff) {
  Room room({.n_receivers = 1, .n_lights = 1, .kinds = {LightKind::point}});
  room.lights.extra[0] = 0;
  room.lights.spots = {{std::cos(0.5f), std::cos(0.3f)}};
  room.lights.light[0] = gray(1);
  room.lights.p[0] = {0, 0, 0}, room.lights.n[0] = {0, 0, 1};
  room.receivers.bsdf[0] = {.material = MaterialId{0}, .reflectance = gray(kPi), .specular = {}};
  const auto at = [&](float angle) {
    const Vec3 w{std::sin(angle), 0, std::cos(angle)};
    room.receivers.p[0] = w * 2, room.receivers.n[0] = room.receivers.ng[0] = room.receivers.wo[0] = -w;
    return transfer(room.world(), room.receivers, ReceiverId{0}, room.lights, LightId{0}, 0).r;
  };
  EXPECT_NEAR(at(0), 0.25f, 1e-6f);
  EXPECT_NEAR(at(0.29f), 0.25f, 1e-6f);
  EXPECT_NEAR(at(0.4f), 0.125f, 1e-5f);
  EXPECT_EQ(at(0.51f), 0);
}

TEST(ShadowSegment, HasBothEndsOffTheirSurfacesTowardsEachOther) {
  const Room room({.n_receivers = 50, .n_lights = 200, .kinds = kAllKinds, .glossy = true, .glass = true});
  for_all(room, [&](ReceiverId i, LightId j) {
    if (!is_active(room.world(), room.receivers, i, room.lights, j)) return;
    const Segment s = shadow_segment(room.receivers, i, room.lights, j);
    const Vec3 p = room.receivers.p[index(i)], q = room.lights.p[index(j)];
    const float offset = room.receivers.offset[index(i)];
    EXPECT_NEAR(length(s.from - p), offset, 1e-6f);
    if (room.lights.kind[index(j)] == LightKind::directional) {
      EXPECT_TRUE(s.distant);
      EXPECT_EQ(s.to, -room.lights.n[index(j)]);
      EXPECT_GT(dot(s.from - p, s.to), 0);
      return;
    }
    EXPECT_FALSE(s.distant);
    EXPECT_GT(dot(s.from - p, q - p), 0);
    if (room.lights.kind[index(j)] == LightKind::point) {
      EXPECT_EQ(s.to, q);
    } else {
      EXPECT_NEAR(length(s.to - q), room.lights.offset[index(j)], 1e-6f);
      EXPECT_GT(dot(s.to - q, p - q), 0);
    }
  });
}

}  // namespace
}  // namespace myrialux
