// Leaves and inner nodes of light trees: boxes, cones, sums and representatives drawn in proportion to importance.
// [walter05, 3]
#include "myrialux/clusters/tree_nodes.h"

#include <algorithm>

#include "myrialux/base/parallel.h"
#include "myrialux/clusters/cone.h"

namespace myrialux {

std::vector<float> light_importance(const World& world, const VirtualLights& lights) {
  constexpr std::size_t kGrain = 1 << 12;
  std::vector<float> importance(lights.size());
  parallel_for(
      lights.size(), [&](std::size_t j) { importance[j] = lights.importance(world, static_cast<LightId>(j)); }, kGrain);
  return importance;
}

std::array<RootPlace, kLightKinds> reserve_nodes(const std::array<std::size_t, kLightKinds>& n_lights,
                                                 LightTree& tree) {
  std::array<RootPlace, kLightKinds> roots{};
  std::uint32_t n_inner = 0, n_all = 0, n_keys = 0;
  for (std::size_t k = 0; k < kLightKinds; ++k) {
    roots[k] = {n_inner, {n_keys, n_keys + 1}, n_all};
    if (n_lights[k] == 0) continue;
    const auto n = static_cast<std::uint32_t>(n_lights[k]);
    if (static_cast<LightKind>(k) == LightKind::glossy) {
      tree.first_glossy_inner = n_inner, tree.n_glossy_inner = n - 1, tree.first_glossy_leaf = n_all;
      tree.glossy.resize(2 * n_lights[k] - 1);
    }
    n_inner += n - 1, n_all += n, n_keys += 2 * n - 1;
  }
  tree.inner.resize(n_inner);
  tree.order.resize(n_all);
  for (std::size_t k = 0; k < kLightKinds; ++k)
    if (n_lights[k] > 0) tree.roots.push_back(n_lights[k] == 1 ? tree.leaf(roots[k].first) : roots[k].inner);
  return roots;
}

void set_places(std::uint32_t index, std::uint32_t first, std::uint32_t count, std::uint32_t n_left, LightTree& tree) {
  LightNode& node = tree.inner[index];
  node.first = first, node.count = count & ((1u << 30) - 1);
  node.left = n_left == 1 ? tree.leaf(first) : index + 1;
  node.right = count - n_left == 1 ? tree.leaf(first + n_left) : index + n_left;
}

LightNode LightTree::leaf_node(std::uint32_t n) const {
  LightNode node;
  node.first = n - static_cast<std::uint32_t>(inner.size()), node.count = 1;
  node.representative = order[node.first];
  const std::size_t j = index(node.representative);
  const LightKind kind = lights->kind[j];
  node.kind = kind;
  node.box.add(kind == LightKind::directional ? -lights->n[j] : lights->p[j]);
  const bool has_cosine = kind == LightKind::oriented || kind == LightKind::glossy;
  node.cone_axis = has_cosine ? cosine_normal(*lights, j) : Vec3{0, 0, 1};
  node.cone_cos = has_cosine ? 1.0f : -1.0f;
  node.importance = importance[j];
  return node;
}

void NodeMaker::make_leaf(std::uint32_t place, std::uint32_t light) const {
  tree_.order[place] = static_cast<LightId>(light);
  if (lights_.kind[light] == LightKind::glossy)
    tree_.glossy[tree_.glossy_place(tree_.leaf(place))] = glossy_bounds(world_, lights_, static_cast<LightId>(light));
}

void NodeMaker::join_children(std::uint32_t index, DrawKey key) const {
  LightNode& node = tree_.inner[index];
  const LightNode a = tree_.node(node.left), b = tree_.node(node.right);
  node.kind = a.kind;
  node.box = a.box;
  node.box.add(b.box);
  const Cone cone = join({a.cone_axis, a.cone_cos}, {b.cone_axis, b.cone_cos});
  node.cone_axis = cone.axis, node.cone_cos = cone.cos_angle;
  node.importance = a.importance + b.importance;
  Rng rng(key_, Stage::light_tree, key.number);
  node.representative = rng.next() * node.importance < a.importance ? a.representative : b.representative;
  if (node.kind != LightKind::glossy) return;

  const GlossyNode &ga = tree_.glossy_node(node.left), &gb = tree_.glossy_node(node.right);
  const Cone mirror = join({ga.mirror_axis, ga.mirror_cos}, {gb.mirror_axis, gb.mirror_cos});
  tree_.glossy[tree_.glossy_place(index)] = {mirror.axis,         mirror.cos_angle, ga.diffuse + gb.diffuse,
                                             ga.gloss + gb.gloss, ga.any + gb.any,  std::max(ga.alpha, gb.alpha)};
}

}  // namespace myrialux
