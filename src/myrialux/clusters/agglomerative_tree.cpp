// Builds a light tree bottom-up. Lights are sorted along a curve through position and normal; both halves of the curve
// are clustered on their own down to a few groups, which then compete with each other. [gu13; walter05]
// Deviations from [gu13]: the curve runs through six dimensions; costs are kept in a matrix.
#include "myrialux/clusters/agglomerative_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "myrialux/base/parallel.h"
#include "myrialux/clusters/light_metric.h"
#include "myrialux/clusters/merges.h"

namespace myrialux {
namespace {

constexpr std::size_t kSerialLights = 1 << 12;  ///< below this a task costs more than it gains

/// Lights of one kind in the order of their codes, which tell where they lie on the curve.
struct Curve {
  std::vector<std::uint32_t> lights;
  std::vector<std::uint64_t> codes;
};
Curve sort_along_curve(const VirtualLights& lights, const LightTree& tree, LightKind kind);

/// What costs are measured with: see join_cost().
struct Measure {
  float c2, least;
};
Measure measure_of(LightKind kind, float scene_radius);

/// Groups that look for partners, and what each pair would cost.
class Competition {
 public:
  Competition(std::vector<LightGroup>& groups, Measure measure);
  /// Joins the cheapest pair until n_left groups are left. @param n_leaves numbers of merges begin there
  void run(std::size_t n_left, std::uint32_t n_leaves, Merges& merges);

 private:
  float& cost(std::size_t i, std::size_t j) { return costs()[i * stride_ + j]; }
  void find_partner(std::size_t i);
  void set_cost(std::size_t i, std::size_t j);
  void join_pair(std::size_t i, std::size_t j);
  static std::vector<float>& costs() {
    thread_local std::vector<float> memory;
    return memory;
  }

  std::vector<LightGroup>& groups_;
  Measure measure_;
  std::size_t stride_;
  std::vector<std::uint32_t> partner_;  ///< the cheapest of each group
};

/// Clusters a curve; recursion over its halves.
class Clustering {
 public:
  Clustering(const VirtualLights& lights, const LightTree& tree, const Curve& curve, Measure measure,
             std::uint32_t n_competing)
      : lights_(lights), tree_(tree), curve_(curve), measure_(measure), n_competing_(n_competing) {
    merges_.parts.resize(curve.lights.size());
  }
  Merges run();

 private:
  std::vector<LightGroup> cluster(std::size_t first, std::size_t last);
  std::size_t split(std::size_t first, std::size_t last) const;
  std::size_t n_kept(std::size_t n_lights) const;
  LightGroup leaf(std::size_t k) const;

  const VirtualLights& lights_;
  const LightTree& tree_;
  const Curve& curve_;
  Measure measure_;
  std::size_t n_competing_;
  Merges merges_;
};

bool has_cosine(LightKind kind) { return kind == LightKind::oriented || kind == LightKind::glossy; }

/// Directional lights: by where they come from.
Vec3 place_of(const VirtualLights& lights, std::size_t j) {
  return lights.kind[j] == LightKind::directional ? -lights.n[j] : lights.p[j];
}

}  // namespace

LightTree build_agglomerative_tree(const World& world, const VirtualLights& lights, float scene_radius,
                                   const AgglomerativeParams& params) {
  LightTree tree;
  tree.lights = &lights;
  tree.importance = light_importance(world, lights);
  std::array<Curve, kLightKinds> curves;
  std::array<std::size_t, kLightKinds> n_lights{};
  for (std::size_t k = 0; k < kLightKinds; ++k) {
    curves[k] = sort_along_curve(lights, tree, static_cast<LightKind>(k));
    n_lights[k] = curves[k].lights.size();
  }
  const std::array<RootPlace, kLightKinds> roots = reserve_nodes(n_lights, tree);

  const NodeMaker maker(world, lights, params.key, tree);
  for (std::size_t k = 0; k < kLightKinds; ++k) {
    if (n_lights[k] == 0) continue;
    const Measure measure = measure_of(static_cast<LightKind>(k), scene_radius);
    const Merges merges = Clustering(lights, tree, curves[k], measure, params.n_competing).run();
    lay_out(merges, curves[k].lights, roots[k], maker, tree);
  }
  return tree;
}

namespace {

/// Ten bits of each of six coordinates in [0, 1], interleaved.
std::uint64_t curve_code(Vec3 p, Vec3 n) {
  const float x[6] = {p.x, p.y, p.z, n.x, n.y, n.z};
  std::uint64_t code = 0;
  for (int a = 0; a < 6; ++a) {
    const auto cell = static_cast<std::uint64_t>(std::clamp(x[a] * 1024, 0.0f, 1023.0f));
    for (int bit = 0; bit < 10; ++bit) code |= (cell >> bit & 1) << (6 * bit + a);
  }
  return code;
}

Curve sort_along_curve(const VirtualLights& lights, const LightTree& tree, LightKind kind) {
  struct Coded {
    std::uint64_t code;
    std::uint32_t light;
  };
  std::vector<Coded> coded;
  Box3 box;
  for (std::size_t j = 0; j < lights.size(); ++j)
    if (lights.kind[j] == kind && tree.importance[j] > 0) {
      coded.push_back({0, static_cast<std::uint32_t>(j)});
      box.add(place_of(lights, j));
    }

  // Opposite normals are as far from each other as ends of half the box.
  constexpr float kNormal = 0.25f;
  const Vec3 extent = box.upper - box.lower;
  const float largest = std::max({extent.x, extent.y, extent.z, 1e-30f});
  const auto set_code = [&](std::size_t k) {
    const std::size_t j = coded[k].light;
    const Vec3 n = has_cosine(kind) ? (cosine_normal(lights, j) + Vec3{1, 1, 1}) * kNormal : Vec3{};
    coded[k].code = curve_code((place_of(lights, j) - box.lower) / largest, n);
  };
  parallel_for(coded.size(), set_code, kSerialLights);
  std::sort(coded.begin(), coded.end(),
            [](const Coded& a, const Coded& b) { return a.code < b.code || (a.code == b.code && a.light < b.light); });
  Curve curve;
  curve.lights.reserve(coded.size()), curve.codes.reserve(coded.size());
  for (const Coded& c : coded) curve.lights.push_back(c.light), curve.codes.push_back(c.code);
  return curve;
}

Measure measure_of(LightKind kind, float scene_radius) {
  constexpr float kLeast = 1e-12f;  // of the squared size; see join_cost()
  const float size = kind == LightKind::directional ? 2 : 2 * scene_radius;
  return {has_cosine(kind) ? size * size : 0, std::max(kLeast * size * size, 1e-30f)};
}

LightGroup Clustering::leaf(std::size_t k) const {
  const std::size_t j = curve_.lights[k];
  LightGroup g;
  g.box.add(place_of(lights_, j));
  g.axis = has_cosine(lights_.kind[j]) ? cosine_normal(lights_, j) : Vec3{0, 0, 1};
  g.intensity = tree_.importance[j];
  g.id = g.slot = static_cast<std::uint32_t>(k);
  return g;
}

Merges Clustering::run() {
  const std::size_t n = curve_.lights.size();
  std::vector<LightGroup> top = cluster(0, n);
  Competition(top, measure_).run(1, static_cast<std::uint32_t>(n), merges_);
  merges_.root = top[0].id;
  return std::move(merges_);
}

/// Groups that a subtree hands up: half of those that compete at the lowest level, more for larger subtrees. Higher up
/// more groups are there, and a wrong partner costs more. [gu13]
std::size_t Clustering::n_kept(std::size_t n_lights) const {
  const double competing = static_cast<double>(n_competing_), share = static_cast<double>(n_lights) / competing;
  return std::max<std::size_t>(1, static_cast<std::size_t>(competing / 2 * std::pow(share, 0.25)));
}

std::vector<LightGroup> Clustering::cluster(std::size_t first, std::size_t last) {
  const std::size_t n = last - first;
  std::vector<LightGroup> groups;
  if (n <= n_competing_) {
    for (std::size_t k = first; k < last; ++k) groups.push_back(leaf(k));
  } else {
    const std::size_t middle = split(first, last);
    std::vector<LightGroup> others;
    const auto cluster_left = [&] { groups = cluster(first, middle); };
    const auto cluster_right = [&] { others = cluster(middle, last); };
    if (n > kSerialLights) {
      parallel_invoke(cluster_left, cluster_right);
    } else {
      cluster_left();
      cluster_right();
    }
    groups.insert(groups.end(), others.begin(), others.end());
  }
  const std::size_t kept = n_kept(n);
  if (groups.size() > kept)
    Competition(groups, measure_).run(kept, static_cast<std::uint32_t>(curve_.lights.size()), merges_);
  return groups;
}

/// Where the highest bit in which codes differ changes; the middle if they are all the same.
std::size_t Clustering::split(std::size_t first, std::size_t last) const {
  const std::uint64_t differ = curve_.codes[first] ^ curve_.codes[last - 1];
  if (differ == 0) return first + (last - first) / 2;
  const std::uint64_t bit = std::bit_floor(differ);
  const auto begin = curve_.codes.begin();
  const auto middle =
      std::partition_point(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last),
                           [&](std::uint64_t code) { return (code & bit) == 0; });
  return static_cast<std::size_t>(middle - begin);
}

Competition::Competition(std::vector<LightGroup>& groups, Measure measure)
    : groups_(groups), measure_(measure), stride_(groups.size()), partner_(groups.size()) {
  costs().assign(stride_ * stride_, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < stride_; ++i)
    for (std::size_t j = 0; j < i; ++j) set_cost(i, j);
  if (stride_ > 1)
    for (std::size_t i = 0; i < stride_; ++i) find_partner(i);
}

void Competition::set_cost(std::size_t i, std::size_t j) {
  cost(i, j) = cost(j, i) = join_cost(groups_[i], groups_[j], measure_.c2, measure_.least);
}

/// Ties to the lower place.
void Competition::find_partner(std::size_t i) {
  const float* row = &cost(i, 0);
  std::size_t best = i == 0 ? 1 : 0;
  for (std::size_t j = 0; j < groups_.size(); ++j)
    if (row[j] < row[best]) best = j;
  partner_[i] = static_cast<std::uint32_t>(best);
}

void Competition::run(std::size_t n_left, std::uint32_t n_leaves, Merges& merges) {
  while (groups_.size() > n_left) {
    std::size_t cheapest = 0;
    for (std::size_t k = 1; k < groups_.size(); ++k)
      if (cost(k, partner_[k]) < cost(cheapest, partner_[cheapest])) cheapest = k;
    const std::size_t other = partner_[cheapest], i = std::min(cheapest, other), j = std::max(cheapest, other);

    // Every group owns a slot: the pair uses up the first's and keeps the second's, so no two merges share one.
    LightGroup joined = join(groups_[i], groups_[j]);
    merges.parts[groups_[i].slot] = {groups_[i].id, groups_[j].id};
    joined.id = n_leaves + groups_[i].slot;
    joined.slot = groups_[j].slot;
    groups_[i] = joined;
    join_pair(i, j);
  }
}

/// The last group moves to place j; partners of i and j look for others.
void Competition::join_pair(std::size_t i, std::size_t j) {
  const std::size_t last = groups_.size() - 1;
  groups_[j] = groups_[last];
  partner_[j] = partner_[last];
  for (std::size_t k = 0; k < last; ++k) cost(j, k) = cost(k, j) = cost(last, k);
  cost(j, j) = std::numeric_limits<float>::infinity();
  groups_.pop_back();
  partner_.pop_back();
  if (groups_.size() == 1) return;
  for (std::size_t k = 0; k < last; ++k)
    if (k != i) set_cost(i, k);
  for (std::size_t k = 0; k < last; ++k) {
    if (k == i || partner_[k] == i || partner_[k] == j)
      find_partner(k);
    else if (partner_[k] == last)
      partner_[k] = static_cast<std::uint32_t>(j);
  }
}

}  // namespace
}  // namespace myrialux
