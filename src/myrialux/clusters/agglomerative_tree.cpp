// Builds a light tree bottom-up. Lights are sorted along a curve through position and normal; halves of the curve are
// clustered on their own down to a few groups, which then compete with those of the other half. [gu13; walter05, 5]
// Deviation from [gu13]: the curve runs through six dimensions, and the number of groups kept grows with the fourth
// root of a subtree's lights.
#include "myrialux/clusters/agglomerative_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "myrialux/base/assert.h"
#include "myrialux/base/parallel.h"
#include "myrialux/clusters/light_metric.h"
#include "myrialux/clusters/tree_nodes.h"

namespace myrialux {
namespace {

constexpr std::size_t kSerialLights = 1 << 12;  ///< below this a task costs more than it gains

/// A light and where it lies on the curve.
struct Placed {
  std::uint64_t code;
  std::uint32_t light;
};
std::vector<Placed> lights_along_curve(const VirtualLights& lights, const LightTree& tree, LightKind kind,
                                       float radius);

/// A binary tree as a list of merges. Of n leaves; leaf k is node k, merge m is node n + m.
struct Merges {
  std::vector<std::array<std::uint32_t, 2>> parts;  ///< [n]; n - 1 are used
  std::uint32_t root = 0;
};

class Clustering {
 public:
  Clustering(const VirtualLights& lights, const LightTree& tree, std::span<const Placed> leaves, float c2, float least,
             std::uint32_t n_competing);
  Merges run();

 private:
  using Groups = std::vector<LightGroup>;
  Groups cluster(std::size_t first, std::size_t last);
  void reduce(Groups& groups, std::size_t n_left);
  std::size_t n_kept(std::size_t n_lights) const;
  LightGroup leaf(std::size_t k) const;

  const VirtualLights& lights_;
  const LightTree& tree_;
  std::span<const Placed> leaves_;
  float c2_, least_;
  std::size_t n_competing_;
  Merges merges_;
};

void lay_out(const Merges& merges, std::span<const Placed> leaves, std::uint32_t root, std::uint32_t first,
             const NodeMaker& maker, LightTree& tree);

}  // namespace

LightTree build_agglomerative_tree(const World& world, const VirtualLights& lights, float scene_radius,
                                   const AgglomerativeParams& params) {
  LightTree tree;
  tree.importance = light_importance(world, lights);
  std::array<std::vector<Placed>, kLightKinds> leaves;
  std::array<std::uint32_t, kLightKinds> first_node{};
  std::size_t n_nodes = 0, n_lights = 0;
  for (int k = 0; k < kLightKinds; ++k) {
    leaves[k] = lights_along_curve(lights, tree, static_cast<LightKind>(k), scene_radius);
    first_node[k] = static_cast<std::uint32_t>(n_nodes);
    if (leaves[k].empty()) continue;
    const std::size_t n = 2 * leaves[k].size() - 1;
    if (static_cast<LightKind>(k) == LightKind::glossy) tree.first_glossy = first_node[k], tree.glossy.resize(n);
    tree.roots.push_back(first_node[k]);
    n_nodes += n, n_lights += leaves[k].size();
  }
  tree.nodes.resize(n_nodes);
  tree.order.resize(n_lights);

  const NodeMaker maker(world, lights, params.key, tree);
  std::uint32_t first = 0;
  for (int k = 0; k < kLightKinds; ++k) {
    if (leaves[k].empty()) continue;
    const auto kind = static_cast<LightKind>(k);
    const bool has_cosine = kind == LightKind::oriented || kind == LightKind::glossy;
    const float size = kind == LightKind::directional ? 2.0f : 2 * scene_radius;
    Clustering clustering(lights, tree, leaves[k], has_cosine ? size * size : 0.0f, 1e-12f * size * size,
                          params.n_competing);
    lay_out(clustering.run(), leaves[k], first_node[k], first, maker, tree);
    first += static_cast<std::uint32_t>(leaves[k].size());
  }
  return tree;
}

namespace {

/// Bits of six coordinates, each in [0, 1], interleaved.
std::uint64_t interleave(const std::array<float, 6>& x) {
  constexpr int kBits = 10;
  std::uint64_t code = 0;
  for (int a = 0; a < 6; ++a) {
    auto v = static_cast<std::uint64_t>(std::clamp(x[a] * 1024.0f, 0.0f, 1023.0f));
    for (int bit = 0; bit < kBits; ++bit) code |= (v >> bit & 1) << (6 * bit + a);
  }
  return code;
}

std::vector<Placed> lights_along_curve(const VirtualLights& lights, const LightTree& tree, LightKind kind,
                                       float radius) {
  std::vector<Placed> placed;
  Box3 box;
  for (std::size_t j = 0; j < lights.size(); ++j)
    if (lights.kind[j] == kind && tree.importance[j] > 0) {
      placed.push_back({0, static_cast<std::uint32_t>(j)});
      box.add(kind == LightKind::directional ? -lights.n[j] : lights.p[j]);
    }
  (void)radius;
  const Vec3 extent = box.upper - box.lower;
  const float largest = std::max({extent.x, extent.y, extent.z, 1e-30f});
  parallel_for(
      placed.size(),
      [&](std::size_t k) {
        const std::size_t j = placed[k].light;
        const Vec3 p = ((kind == LightKind::directional ? -lights.n[j] : lights.p[j]) - box.lower) / largest;
        Vec3 n{};
        if (kind == LightKind::oriented || kind == LightKind::glossy)
          n = cosine_normal(lights, j) * 0.25f + Vec3{0.25f, 0.25f, 0.25f};
        placed[k].code = interleave({p.x, p.y, p.z, n.x, n.y, n.z});
      },
      kSerialLights);
  std::sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    return a.code < b.code || (a.code == b.code && a.light < b.light);
  });
  return placed;
}

Clustering::Clustering(const VirtualLights& lights, const LightTree& tree, std::span<const Placed> leaves, float c2,
                       float least, std::uint32_t n_competing)
    : lights_(lights), tree_(tree), leaves_(leaves), c2_(c2), least_(least), n_competing_(n_competing) {
  merges_.parts.resize(leaves.size());
}

LightGroup Clustering::leaf(std::size_t k) const {
  const std::size_t j = leaves_[k].light;
  LightGroup g;
  const bool directional = lights_.kind[j] == LightKind::directional;
  g.box.add(directional ? -lights_.n[j] : lights_.p[j]);
  g.axis = c2_ > 0 ? cosine_normal(lights_, j) : Vec3{0, 0, 1};
  g.intensity = tree_.importance[j];
  g.id = g.slot = static_cast<std::uint32_t>(k);
  return g;
}

Merges Clustering::run() {
  Groups top = cluster(0, leaves_.size());
  reduce(top, 1);
  merges_.root = top[0].id;
  return std::move(merges_);
}

/// Groups that a subtree hands up.
std::size_t Clustering::n_kept(std::size_t n_lights) const {
  const double share = static_cast<double>(n_lights) / static_cast<double>(n_competing_);
  return std::max<std::size_t>(
      1, static_cast<std::size_t>(0.5 * static_cast<double>(n_competing_) * std::pow(share, 0.25)));
}

Clustering::Groups Clustering::cluster(std::size_t first, std::size_t last) {
  const std::size_t n = last - first;
  Groups groups;
  if (n <= n_competing_) {
    for (std::size_t k = first; k < last; ++k) groups.push_back(leaf(k));
  } else {
    // Where the highest bit that differs changes; the middle if none does.
    std::size_t middle = first + n / 2;
    const std::uint64_t differ = leaves_[first].code ^ leaves_[last - 1].code;
    if (differ != 0) {
      const std::uint64_t bit = std::bit_floor(differ);
      middle = static_cast<std::size_t>(std::partition_point(leaves_.begin() + first, leaves_.begin() + last,
                                                             [&](const Placed& p) { return (p.code & bit) == 0; }) -
                                        leaves_.begin());
    }
    Groups right;
    const auto do_left = [&] { groups = cluster(first, middle); };
    const auto do_right = [&] { right = cluster(middle, last); };
    if (n > kSerialLights) {
      parallel_invoke(do_left, do_right);
    } else {
      do_left();
      do_right();
    }
    groups.insert(groups.end(), right.begin(), right.end());
  }
  reduce(groups, n_kept(n));
  return groups;
}

/// Joins the cheapest pair until n_left groups are left.
void Clustering::reduce(Groups& groups, std::size_t n_left) {
  std::size_t n = groups.size();
  if (n <= n_left) return;
  thread_local std::vector<float> cost;
  thread_local std::vector<std::uint32_t> partner;
  const std::size_t stride = n;
  cost.assign(n * n, std::numeric_limits<float>::infinity());
  partner.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < i; ++j)
      cost[i * stride + j] = cost[j * stride + i] = join_cost(groups[i], groups[j], c2_, least_);
  const auto find_partner = [&](std::size_t i) {
    const float* row = &cost[i * stride];
    std::size_t best = i == 0 ? 1 : 0;
    for (std::size_t j = 0; j < n; ++j)
      if (row[j] < row[best]) best = j;
    partner[i] = static_cast<std::uint32_t>(best);
  };
  for (std::size_t i = 0; i < n; ++i) find_partner(i);
  while (n > n_left) {
    std::size_t i = 0;
    for (std::size_t k = 1; k < n; ++k)
      if (cost[k * stride + partner[k]] < cost[i * stride + partner[i]]) i = k;
    std::size_t j = partner[i];
    if (j < i) std::swap(i, j);

    LightGroup joined = join(groups[i], groups[j]);
    const std::uint32_t slot = groups[i].slot;
    merges_.parts[slot] = {groups[i].id, groups[j].id};
    joined.id = static_cast<std::uint32_t>(leaves_.size()) + slot;
    joined.slot = groups[j].slot;
    groups[i] = joined;
    // The last group moves into the gap.
    --n;
    const std::size_t moved = n;
    if (j != moved) {
      groups[j] = groups[moved];
      partner[j] = partner[moved];
      for (std::size_t k = 0; k < n; ++k) cost[j * stride + k] = cost[k * stride + j] = cost[moved * stride + k];
      cost[j * stride + j] = std::numeric_limits<float>::infinity();
    }
    for (std::size_t k = 0; k < n; ++k)
      if (k != i) cost[i * stride + k] = cost[k * stride + i] = join_cost(groups[i], groups[k], c2_, least_);
    if (n == 1) break;
    for (std::size_t k = 0; k < n; ++k) {
      if (k == i || partner[k] == i || partner[k] == j)
        find_partner(k);
      else if (partner[k] == moved)
        partner[k] = static_cast<std::uint32_t>(j);
    }
  }
  groups.resize(n_left);
}

/// Gives every merge its place in the tree, then fills nodes from the leaves up.
void lay_out(const Merges& merges, std::span<const Placed> leaves, std::uint32_t root, std::uint32_t first,
             const NodeMaker& maker, LightTree& tree) {
  const auto n = static_cast<std::uint32_t>(leaves.size());
  // Lights below each merge, from a list in which parts come after their whole.
  std::vector<std::uint32_t> down;
  down.reserve(n);
  if (merges.root >= n) down.push_back(merges.root);
  for (std::size_t k = 0; k < down.size(); ++k)
    for (const std::uint32_t part : merges.parts[down[k] - n])
      if (part >= n) down.push_back(part);
  std::vector<std::uint32_t> count(n, 1);
  const auto count_of = [&](std::uint32_t id) { return id < n ? 1u : count[id - n]; };
  for (std::size_t k = down.size(); k-- > 0;) {
    const auto& parts = merges.parts[down[k] - n];
    count[down[k] - n] = count_of(parts[0]) + count_of(parts[1]);
  }

  struct Place {
    std::uint32_t id, node, descendants, first;
  };
  const auto place = [&](const Place& p, std::vector<Place>& open) {
    LightNode& node = tree.nodes[p.node];
    node.first = p.first;
    node.count = count_of(p.id);
    if (p.id < n) return maker.make_leaf(p.node, leaves[p.id].light);
    node.left = p.descendants;
    const auto& parts = merges.parts[p.id - n];
    const std::uint32_t n_left = count_of(parts[0]), below = p.descendants + 2;
    open.push_back({parts[0], p.descendants, below, p.first});
    open.push_back({parts[1], p.descendants + 1, below + 2 * n_left - 2, p.first + n_left});
  };
  const auto fill_subtree = [&](const Place& top) {
    std::vector<Place> open{top};
    std::vector<std::uint32_t> inner;
    while (!open.empty()) {
      const Place p = open.back();
      open.pop_back();
      place(p, open);
      if (p.id >= n) inner.push_back(p.node);
    }
    for (std::size_t k = inner.size(); k-- > 0;) maker.join_children(inner[k]);
  };

  std::vector<Place> open{{merges.root, root, root + 1, first}}, subtrees;
  std::vector<std::uint32_t> upper;
  while (!open.empty()) {
    const Place p = open.back();
    open.pop_back();
    if (count_of(p.id) <= kSerialLights) {
      subtrees.push_back(p);
    } else {
      place(p, open);
      upper.push_back(p.node);
    }
  }
  parallel_for(subtrees.size(), [&](std::size_t k) { fill_subtree(subtrees[k]); });
  for (std::size_t k = upper.size(); k-- > 0;) maker.join_children(upper[k]);
}

}  // namespace
}  // namespace myrialux
