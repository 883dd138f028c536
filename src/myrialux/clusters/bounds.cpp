// Fills the bounding kernel's inputs: what a receiver's BSDF and a node's lights can do at most. [walter05, 4.1]
#include "myrialux/clusters/bounds.h"

#include <algorithm>

#include "myrialux/clusters/cut.h"
#include "myrialux/clusters/lobe_bounds.h"

namespace myrialux {
namespace {

void set_frame(Vec3 axis, float (&soa)[9][kCutLanes], std::size_t lane) {
  const Frame frame(axis);
  for (int a = 0; a < 3; ++a) soa[a][lane] = frame.n[a], soa[3 + a][lane] = frame.s[a], soa[6 + a][lane] = frame.t[a];
}

AxisFrame back_frame(Vec3 axis) { return axis_frame(-axis); }

CutCluster cluster_of(const LightTree& tree, const LightNode& node, std::uint32_t index);

float sine(float cosine) { return std::sqrt(std::max(0.0f, 1 - cosine * cosine)); }

void set_point(const World& world, const Receivers& receivers, std::size_t i, std::size_t lane, CutPoints::Group& g) {
  const BsdfParams& params = receivers.bsdf[i];
  const Bsdf bsdf = make_bsdf(world.scene.materials[index(params.material)], params, world.sharp_alpha);
  const Vec3 p = receivers.p[i], n = receivers.n[i], wo = receivers.wo[i];
  const float side = receivers.inside[i] ? -1.0f : 1.0f;
  const LobeBounds bounds = lobe_bounds(bsdf, Frame(n * side).to_local(wo));
  for (int a = 0; a < 3; ++a) g.p[a][lane] = p[a];
  set_frame(n, g.normal, lane);
  set_frame(normalize(n * (2 * dot(n, wo)) - wo), g.mirror, lane);
  g.diffuse[lane] = max_component(bounds.diffuse);
  g.gloss[lane] = max_component(bounds.gloss);
  g.any[lane] = max_component(bounds.any);
  g.inverse_alpha2[lane] = 1 / (bounds.alpha * bounds.alpha);
  g.c1[lane] = bounds.c1, g.c2[lane] = bounds.c2, g.c3[lane] = bounds.c3;
  g.t_least[lane] = bounds.t_least;
}

}  // namespace

AxisFrame axis_frame(Vec3 axis) {
  const Frame frame(axis);
  AxisFrame a{};
  for (int k = 0; k < 3; ++k) a.axis[k] = frame.n[k], a.s[k] = frame.s[k], a.t[k] = frame.t[k];
  return a;
}

CutPoints make_cut_points(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                          float clamp_distance) {
  CutPoints points;
  points.least_distance_squared = std::max(clamp_distance * clamp_distance, 1e-20f);
  points.groups.resize((rows.size() + kCutLanes - 1) / kCutLanes);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    CutPoints::Group& g = points.groups[k / kCutLanes];
    const std::size_t lane = k % kCutLanes;
    set_point(world, receivers, index(rows[k]), lane, g);
    points.any_gloss |= g.gloss[lane] > 0 || g.any[lane] > 0;
  }
  return points;
}

CutCluster make_cut_cluster(const LightTree& tree, std::uint32_t index) {
  return tree.is_leaf(index) ? cluster_of(tree, tree.node(index), index) : cluster_of(tree, tree.inner[index], index);
}

namespace {

CutCluster cluster_of(const LightTree& tree, const LightNode& node, std::uint32_t index) {
  CutCluster c{};
  for (int a = 0; a < 3; ++a) c.lower[a] = node.box.lower[a], c.upper[a] = node.box.upper[a];
  c.distant = node.kind == LightKind::directional;
  c.has_cone = node.kind == LightKind::oriented || node.kind == LightKind::glossy;
  c.diffuse = node.importance;
  if (!c.has_cone) return c;
  c.back = back_frame(node.cone_axis);
  c.cone_cos = node.cone_cos, c.cone_sin = sine(node.cone_cos);
  if (node.kind == LightKind::oriented) return c;
  const GlossyNode& glossy = tree.glossy_node(index);
  c.diffuse = glossy.diffuse, c.gloss = glossy.gloss, c.any = glossy.any;
  c.mirror_back = back_frame(glossy.mirror_axis);
  c.mirror_cos = glossy.mirror_cos, c.mirror_sin = sine(glossy.mirror_cos);
  c.inverse_alpha2 = 1 / (glossy.alpha * glossy.alpha);
  return c;
}

}  // namespace

CutCluster make_light_cluster(const World& world, const VirtualLights& lights, LightId light, float importance,
                              float weight) {
  const std::size_t j = index(light);
  const LightKind kind = lights.kind[j];
  const bool glossy = kind == LightKind::glossy;
  CutCluster c{};
  c.distant = kind == LightKind::directional;
  const Vec3 at = c.distant ? -lights.n[j] : lights.p[j];
  for (int a = 0; a < 3; ++a) c.lower[a] = c.upper[a] = at[a];
  c.diffuse = weight * importance;
  c.has_cone = kind == LightKind::oriented || glossy;
  if (!c.has_cone) return c;
  c.back = back_frame(glossy ? lights.ng[j] : lights.n[j]);
  c.cone_cos = 1;
  if (!glossy) return c;
  const GlossyNode bounds = glossy_bounds(world, lights, light);
  c.diffuse = weight * bounds.diffuse, c.gloss = weight * bounds.gloss, c.any = weight * bounds.any;
  c.mirror_back = back_frame(bounds.mirror_axis);
  c.mirror_cos = bounds.mirror_cos, c.mirror_sin = sine(bounds.mirror_cos);
  c.inverse_alpha2 = 1 / (bounds.alpha * bounds.alpha);
  return c;
}

float cluster_bound(const World& world, const Receivers& receivers, ReceiverId i, const LightTree& tree,
                    std::uint32_t node, float clamp_distance) {
  const CutPoints points = make_cut_points(world, receivers, std::span(&i, 1), clamp_distance);
  const CutCluster cluster = make_cut_cluster(tree, node);
  float bound = 0;
  bound_clusters(points, std::span(&cluster, 1), std::span(&bound, 1));
  return bound;
}

}  // namespace myrialux
