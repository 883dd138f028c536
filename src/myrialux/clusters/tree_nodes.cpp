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

std::array<std::uint32_t, kLightKinds> reserve_nodes(const std::array<std::size_t, kLightKinds>& n_lights,
                                                     LightTree& tree) {
  std::array<std::uint32_t, kLightKinds> roots{};
  std::size_t n_nodes = 0, n_all = 0;
  for (std::size_t k = 0; k < kLightKinds; ++k) {
    roots[k] = static_cast<std::uint32_t>(n_nodes);
    if (n_lights[k] == 0) continue;
    const std::size_t n = 2 * n_lights[k] - 1;
    if (static_cast<LightKind>(k) == LightKind::glossy) tree.first_glossy = roots[k], tree.glossy.resize(n);
    tree.roots.push_back(roots[k]);
    n_nodes += n, n_all += n_lights[k];
  }
  tree.nodes.resize(n_nodes);
  tree.order.resize(n_all);
  return roots;
}

void NodeMaker::make_leaf(std::uint32_t index, std::uint32_t light) const {
  LightNode& node = tree_.nodes[index];
  node.kind = lights_.kind[light];
  node.box.add(node.kind == LightKind::directional ? -lights_.n[light] : lights_.p[light]);
  const bool has_cosine = node.kind == LightKind::oriented || node.kind == LightKind::glossy;
  node.cone_axis = has_cosine ? cosine_normal(lights_, light) : Vec3{0, 0, 1};
  node.cone_cos = has_cosine ? 1.0f : -1.0f;
  node.importance = tree_.importance[light];
  node.representative = static_cast<LightId>(light);
  tree_.order[node.first] = static_cast<LightId>(light);
  if (node.kind == LightKind::glossy) glossy(index) = glossy_bounds(world_, lights_, static_cast<LightId>(light));
}

void NodeMaker::join_children(std::uint32_t index) const {
  LightNode& node = tree_.nodes[index];
  const LightNode &a = tree_.nodes[node.left], &b = tree_.nodes[node.left + 1];
  node.kind = a.kind;
  node.box = a.box;
  node.box.add(b.box);
  const Cone cone = join({a.cone_axis, a.cone_cos}, {b.cone_axis, b.cone_cos});
  node.cone_axis = cone.axis, node.cone_cos = cone.cos_angle;
  node.importance = a.importance + b.importance;
  Rng rng(key_, Stage::light_tree, index);
  node.representative = rng.next() * node.importance < a.importance ? a.representative : b.representative;
  if (node.kind != LightKind::glossy) return;

  const GlossyNode &ga = glossy(node.left), &gb = glossy(node.left + 1);
  const Cone mirror = join({ga.mirror_axis, ga.mirror_cos}, {gb.mirror_axis, gb.mirror_cos});
  glossy(index) = {mirror.axis,         mirror.cos_angle, ga.diffuse + gb.diffuse,
                   ga.gloss + gb.gloss, ga.any + gb.any,  std::max(ga.alpha, gb.alpha)};
}

}  // namespace myrialux
