// Bounds of clusters: never exceeded, not absurdly loose, and the kernel's bits are its plain twin's.
#include "myrialux/clusters/bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>

#include "myrialux/clusters/agglomerative_tree.h"
#include "myrialux/clusters/cut.h"
#include "myrialux/clusters/lobe_bounds.h"
#include "myrialux/kernels/isa.h"
#include "myrialux/transfer/transfer.h"
#include "support/random_room.h"

namespace myrialux {
namespace {

using test::Room;
using test::RoomOptions;

constexpr float kClamp = 0.1f;

/// What bound / light of the whole cluster may be: recorded, with margin. Quantiles weigh by light, since clusters that
/// send next to nothing may be bounded ever so badly.
struct BoundsCase {
  const char* name;
  RoomOptions options;
  double median, quantile_95;
};
/// One cluster at one receiver.
struct Tightness {
  double ratio, light;
};
double quantile(std::vector<Tightness>& all, double share) {
  std::sort(all.begin(), all.end(), [](const Tightness& a, const Tightness& b) { return a.ratio < b.ratio; });
  double total = 0, sum = 0;
  for (const Tightness& t : all) total += t.light;
  for (const Tightness& t : all)
    if ((sum += t.light) >= share * total) return t.ratio;
  return all.back().ratio;
}
std::ostream& operator<<(std::ostream& out, const BoundsCase& c) { return out << c.name; }

/// Pairs of a receiver and a node drawn at random; what passed its bound, and how loose bounds are.
struct BoundsCheck {
  int pairs = 0, exceeded = 0, exceeded_by_representative = 0;
  std::vector<Tightness> tightness;
};
BoundsCheck check_bounds(const Room& room, const LightTree& tree, int n_pairs, std::uint64_t seed) {
  const World world = room.world();
  Rng rng({seed}, Stage::test, 0);
  BoundsCheck check;
  while (check.pairs < n_pairs) {
    const auto i = static_cast<ReceiverId>(rng.below(static_cast<std::uint32_t>(room.receivers.size())));
    const std::uint32_t n = rng.below(tree.size());
    const LightNode node = tree.node(n);
    if (node.count > 128) continue;
    ++check.pairs;
    double sum = 0, most = 0;
    for (std::uint32_t l = node.first; l < node.first + node.count; ++l) {
      const LightId j = tree.order[l];
      const double light = luminance(transfer(world, room.receivers, i, room.lights, j, kClamp));
      sum += light;
      most = std::max(most, light * node.importance / tree.importance[index(j)]);
    }
    const double bound = cluster_bound(world, room.receivers, i, tree, n, kClamp);
    // Rounding: 2e-5 of the value; cosines near 0 are off by 1e-6 in bound or transfer.
    const double near = std::max<double>(distance_squared(node.box, room.receivers.p[index(i)]), kClamp * kClamp);
    const double slack = node.kind == LightKind::directional ? 1e-6 : 1e-6 * node.importance / near;
    check.exceeded += sum > bound * (1 + 2e-5) + slack;
    if (node.kind != LightKind::glossy) check.exceeded_by_representative += most > bound * (1 + 2e-5) + slack;
    if (sum > 0 && node.count > 1) check.tightness.push_back({bound / sum, sum});
  }
  return check;
}

class ClusterBound : public ::testing::TestWithParam<BoundsCase> {};

TEST_P(ClusterBound, IsNeverExceededAndNotTooLoose) {
  const Room room(GetParam().options);
  BoundsCheck check = check_bounds(room, build_light_tree(room.world(), room.lights, Room::kRadius, {}), 30000, 17);
  EXPECT_EQ(check.exceeded, 0);
  EXPECT_EQ(check.exceeded_by_representative, 0);
  ASSERT_GT(check.tightness.size(), 1000u);
  const double median = quantile(check.tightness, 0.5), quantile_95 = quantile(check.tightness, 0.95);
  std::printf("bound / light, %s: median %.3g, 95 %% %.3g\n", GetParam().name, median, quantile_95);
  EXPECT_LT(median, GetParam().median);
  EXPECT_LT(quantile_95, GetParam().quantile_95);
}

/// 12 rooms, two trees each: a million and a half pairs.
TEST_P(ClusterBound, IsNotExceededByAMillionPairs_Slow) {
  const Room room(GetParam().options);
  const LightTree trees[] = {build_light_tree(room.world(), room.lights, Room::kRadius, {}),
                             build_agglomerative_tree(room.world(), room.lights, Room::kRadius, {})};
  for (const bool agglomerative : {false, true}) {
    BoundsCheck check = check_bounds(room, trees[agglomerative], 62500, 18);
    EXPECT_EQ(check.exceeded, 0);
    EXPECT_EQ(check.exceeded_by_representative, 0);
    std::printf("bound / light, %s, %s: %d pairs, median %.3g, 95 %% %.3g\n", GetParam().name,
                agglomerative ? "agglomerative" : "divisive", check.pairs, quantile(check.tightness, 0.5),
                quantile(check.tightness, 0.95));
  }
}

using Kinds = std::vector<LightKind>;
INSTANTIATE_TEST_SUITE_P(
    Rooms, ClusterBound,
    ::testing::Values(
        BoundsCase{"diffuse", {.n_lights = 5000}, 6, 110},
        BoundsCase{"tilted", {.n_lights = 5000, .shading_tilt = 0.3f}, 6, 150},
        BoundsCase{"points", {.n_lights = 5000, .kinds = {LightKind::point}}, 7, 30},
        BoundsCase{"directional", {.n_lights = 5000, .kinds = {LightKind::directional}, .glossy = true}, 3, 13},
        BoundsCase{"glossy_receivers", {.n_lights = 5000, .glossy = true, .shading_tilt = 0.1f}, 6, 600},
        BoundsCase{"glossy_lights", {.n_lights = 5000, .kinds = {LightKind::glossy}, .shading_tilt = 0.1f}, 100, 5000},
        BoundsCase{"all_glossy", {.n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true}, 32, 2000},
        BoundsCase{
            "glass", {.n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true, .glass = true}, 200, 40000},
        BoundsCase{"blinn_phong_receivers",
                   {.n_lights = 5000, .glossy = true, .blinn_phong = 1, .shading_tilt = 0.1f},
                   6,
                   250},
        BoundsCase{"blinn_phong_lights",
                   {.n_lights = 5000, .kinds = {LightKind::glossy}, .blinn_phong = 1, .shading_tilt = 0.1f},
                   32,
                   650},
        BoundsCase{"all_blinn_phong",
                   {.n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true, .blinn_phong = 1},
                   35,
                   800},
        BoundsCase{
            "mixed_gloss",
            {.n_lights = 5000, .kinds = {LightKind::glossy}, .glossy = true, .blinn_phong = 0.4f, .shading_tilt = 0.2f},
            100,
            2200}),
    [](const auto& c) { return std::string(c.param.name); });

TEST(LobeBounds, AreNotExceededByAnyDirection) {
  Rng rng({23}, Stage::test, 0);
  const auto u = [&] {
    const float x = rng.next();
    return Vec2{x, rng.next()};
  };
  for (const BsdfKind kind : {BsdfKind::diffuse, BsdfKind::plastic, BsdfKind::rough_plastic, BsdfKind::rough_conductor,
                              BsdfKind::blinn_phong, BsdfKind::rough_dielectric})
    for (const Microfacets distribution : {Microfacets::ggx, Microfacets::beckmann})
      for (const float alpha : {0.11f, 0.3f, 0.7f, 0.8f, 1.3f}) {
        Material material;
        material.kind = kind, material.distribution = distribution, material.nonlinear = alpha > 0.5f;
        const Bsdf bsdf = make_bsdf(
            material, {.material = {}, .alpha = alpha, .reflectance = {0.9f, 0.5f, 0.2f}, .specular = {1, 0.8f, 0.3f}},
            kDefaultSharpAlpha);
        int exceeded = 0;
        for (int k = 0; k < 4000; ++k) {
          Vec3 v = sample_sphere(u());
          if (kind != BsdfKind::rough_dielectric) v.z = std::fabs(v.z);
          const LobeBounds b = lobe_bounds(bsdf, v);
          // Half of the directions near the mirror's, where lobes are high.
          const Vec3 mirror{-v.x, -v.y, v.z};
          const Vec3 w = k % 2 ? sample_sphere(u()) : normalize(mirror + sample_sphere(u()) * alpha);
          const float cosine = dot(w, mirror);
          const float ratio = (1 - cosine) / std::max(1 + cosine, 1e-6f);
          const float t = std::min(std::max(ratio, b.t_least), 1e6f), x = t / (b.alpha * b.alpha);
          const float shape = (1 + t) * (1 + t) / (1 + x * (b.c1 + x * (b.c2 + x * b.c3)));
          const Rgb bound = b.diffuse * std::max(w.z, 0.0f) + b.any + (w.z > 0 ? b.gloss * shape : Rgb{});
          const Rgb f_cos = evaluate(bsdf, w, v, Lobes::wide);
          const Rgb back = evaluate(bsdf, v, w, Lobes::wide) * std::fabs(w.z / v.z);  // of a light lit from v
          for (const Rgb f : {f_cos, back})
            exceeded += !(f.r <= bound.r * 1.0001f && f.g <= bound.g * 1.0001f && f.b <= bound.b * 1.0001f);
        }
        EXPECT_EQ(exceeded, 0) << static_cast<int>(kind) << ' ' << static_cast<int>(distribution) << ' ' << alpha;
      }
}

TEST(CutBounds, HaveTheSameBitsInAllInstructionSets) {
  const Room room({.n_receivers = 37,
                   .n_lights = 1500,
                   .kinds = {LightKind::oriented, LightKind::glossy, LightKind::point, LightKind::directional},
                   .glossy = true,
                   .glass = true,
                   .blinn_phong = 0.2f,
                   .shading_tilt = 0.2f});
  const LightTree tree = build_light_tree(room.world(), room.lights, Room::kRadius, {});
  std::vector<CutCluster> clusters;
  for (std::uint32_t n = 0; n < tree.size(); ++n) clusters.push_back(make_cut_cluster(tree, n));
  for (const std::size_t n_points : {1, 15, 16, 17, 37}) {
    std::vector<ReceiverId> rows;
    for (std::size_t i = 0; i < n_points; ++i) rows.push_back(static_cast<ReceiverId>(i));
    const CutPoints points = make_cut_points(room.world(), room.receivers, rows, 0.05f);
    std::vector<float> plain(clusters.size()), vectors(clusters.size());
    bound_clusters_plain(points, clusters, plain);
    for (const std::int64_t isa : available_isas()) {
      force_isa(isa);
      bound_clusters(points, clusters, vectors);
      EXPECT_EQ(vectors, plain) << isa_name(isa) << ' ' << n_points;
      std::vector<float> groups(points.groups.size()), plain_groups(groups.size());
      for (std::size_t n = 0; n < clusters.size(); n += 7) {
        bound_groups(points, clusters[n], groups);
        bound_groups_plain(points, clusters[n], plain_groups);
        EXPECT_EQ(groups, plain_groups) << isa_name(isa) << ' ' << n_points << " node " << n;
        EXPECT_EQ(*std::max_element(groups.begin(), groups.end()), plain[n]);
        std::array<float, kCutLanes> lanes{}, plain_lanes{};
        bound_lanes(points, groups.size() - 1, clusters[n], lanes);
        bound_lanes_plain(points, groups.size() - 1, clusters[n], plain_lanes);
        EXPECT_EQ(lanes, plain_lanes) << isa_name(isa) << ' ' << n_points << " node " << n;
        EXPECT_EQ(*std::max_element(lanes.begin(), lanes.end()), groups.back());
      }
    }
    force_isa(0);
  }
}

}  // namespace
}  // namespace myrialux
