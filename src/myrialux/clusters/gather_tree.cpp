// Builds a gather tree top down and joins its bounds bottom up. [walter06]; bounds of materials: the lobe about the
// mirror direction of lobe_bounds.h over a cone of mirror directions, where the paper has cube maps of half vectors.
#include "myrialux/clusters/gather_tree.h"

#include <algorithm>
#include <array>

#include "myrialux/clusters/bounds.h"
#include "myrialux/clusters/cone.h"
#include "myrialux/clusters/lobe_bounds.h"

namespace myrialux {
namespace {

class Builder {
 public:
  Builder(const World& world, const Receivers& receivers, float normal_scale, Rng& rng, GatherTree& tree)
      : world_(world), receivers_(receivers), normal_scale_(normal_scale), rng_(rng), tree_(tree) {}
  void build(std::uint32_t node);

 private:
  float coordinate(ReceiverId i, int axis) const;
  int widest_axis(std::span<const ReceiverId> rows) const;
  void make_leaf(GatherNode& node) const;
  void join_children(GatherNode& node);

  const World& world_;
  const Receivers& receivers_;
  float normal_scale_;
  Rng& rng_;
  GatherTree& tree_;
};

float strength(const Receivers& receivers, ReceiverId i) { return max_component(receivers.beta[index(i)]); }
void join_lobes(const PairReceivers& a, const PairReceivers& b, PairReceivers& joined);

}  // namespace

void build_gather_tree(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                       float normal_scale, Rng& rng, GatherTree& tree) {
  tree.order.clear(), tree.nodes.clear();
  for (const ReceiverId i : rows)
    if (strength(receivers, i) > 0) tree.order.push_back(i);
  if (tree.order.empty()) return;
  tree.nodes.reserve(2 * tree.order.size() - 1);
  GatherNode root{};
  root.count = static_cast<std::uint32_t>(tree.order.size());
  tree.nodes.push_back(root);
  Builder(world, receivers, normal_scale, rng, tree).build(0);
}

namespace {

float Builder::coordinate(ReceiverId i, int axis) const {
  return axis < 3 ? receivers_.p[index(i)][axis] : receivers_.n[index(i)][axis - 3] * normal_scale_;
}

int Builder::widest_axis(std::span<const ReceiverId> rows) const {
  int widest = 0;
  float width = -1;
  for (int axis = 0; axis < 6; ++axis) {
    float low = kInfinity, high = -kInfinity;
    for (const ReceiverId i : rows)
      low = std::min(low, coordinate(i, axis)), high = std::max(high, coordinate(i, axis));
    if (high - low > width) width = high - low, widest = axis;
  }
  return widest;
}

/// `node` has its range; its descendants are appended. Depth is the logarithm of the count, since halves are equal.
void Builder::build(std::uint32_t node) {
  const std::uint32_t first = tree_.nodes[node].first, count = tree_.nodes[node].count;
  if (count == 1) return make_leaf(tree_.nodes[node]);
  const std::span<ReceiverId> rows = std::span(tree_.order).subspan(first, count);
  const std::uint32_t half = count / 2;
  const int axis = widest_axis(rows);
  std::nth_element(rows.begin(), rows.begin() + half, rows.end(), [&](ReceiverId a, ReceiverId b) {
    const float xa = coordinate(a, axis), xb = coordinate(b, axis);
    return xa != xb ? xa < xb : a < b;
  });
  const auto left = static_cast<std::uint32_t>(tree_.nodes.size());
  tree_.nodes[node].left = left;
  GatherNode child{};
  child.first = first, child.count = half;
  tree_.nodes.push_back(child);
  child.first = first + half, child.count = count - half;
  tree_.nodes.push_back(child);
  build(left);
  build(left + 1);
  join_children(tree_.nodes[node]);
}

void Builder::make_leaf(GatherNode& node) const {
  const ReceiverId row = tree_.order[node.first];
  const std::size_t i = index(row);
  const BsdfParams& params = receivers_.bsdf[i];
  const Bsdf bsdf = make_bsdf(world_.scene.materials[index(params.material)], params, world_.sharp_alpha);
  const Vec3 p = receivers_.p[i], n = receivers_.n[i], wo = receivers_.wo[i];
  const LobeBounds lobes = lobe_bounds(bsdf, Frame(receivers_.inside[i] ? -n : n).to_local(wo));
  PairReceivers& b = node.bounds;
  for (int a = 0; a < 3; ++a) b.lower[a] = b.upper[a] = p[a];
  b.normal = axis_frame(n), b.normal_cos = 1, b.normal_sin = 0;
  b.mirror = axis_frame(normalize(n * (2 * dot(n, wo)) - wo)), b.mirror_cos = 1, b.mirror_sin = 0;
  b.diffuse = max_component(lobes.diffuse), b.gloss = max_component(lobes.gloss), b.any = max_component(lobes.any);
  b.inverse_alpha2 = 1 / (lobes.alpha * lobes.alpha);
  b.c1 = lobes.c1, b.c2 = lobes.c2, b.c3 = lobes.c3, b.t_least = lobes.t_least;
  node.strength = strength(receivers_, row);
  node.representative = row;
}

Cone cone_of(const AxisFrame& frame, float cosine) { return {{frame.axis[0], frame.axis[1], frame.axis[2]}, cosine}; }

void set_cone(const Cone& cone, AxisFrame& frame, float& cosine, float& sine) {
  frame = axis_frame(cone.axis);
  cosine = cone.cos_angle, sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
}

void Builder::join_children(GatherNode& node) {
  const GatherNode &a = tree_.nodes[node.left], &b = tree_.nodes[node.left + 1];
  PairReceivers& joined = node.bounds;
  Vec3 extent;
  for (int k = 0; k < 3; ++k) {
    joined.lower[k] = std::min(a.bounds.lower[k], b.bounds.lower[k]);
    joined.upper[k] = std::max(a.bounds.upper[k], b.bounds.upper[k]);
    extent[k] = joined.upper[k] - joined.lower[k];
  }
  node.diagonal = length(extent);
  set_cone(join(cone_of(a.bounds.normal, a.bounds.normal_cos), cone_of(b.bounds.normal, b.bounds.normal_cos)),
           joined.normal, joined.normal_cos, joined.normal_sin);
  join_lobes(a.bounds, b.bounds, joined);

  node.strength = a.strength + b.strength;
  node.representative = rng_.next() * node.strength < a.strength ? a.representative : b.representative;
  node.same_beta = a.same_beta && b.same_beta &&
                   receivers_.beta[index(a.representative)] == receivers_.beta[index(b.representative)];
}

bool same_shape(const PairReceivers& a, const PairReceivers& b) {
  return a.inverse_alpha2 == b.inverse_alpha2 && a.c1 == b.c1 && a.c2 == b.c2 && a.c3 == b.c3 && a.t_least == b.t_least;
}

/// The lobe with the shape that all receivers can be told by: coefficients 1, 1/2, 0 up to kLargestShapedAlpha, from
/// there on the peak alone. lobe_bounds.h
PairReceivers in_common_shape(PairReceivers b) {
  if (b.c1 == 1 && b.c2 == 0.5f && b.c3 == 0 && b.t_least == 0) return b;
  const float alpha = 1 / std::sqrt(b.inverse_alpha2);
  b.gloss = max_component(peak_gloss({{}, gray(b.gloss), {}, alpha, b.c1, b.c2, b.c3, b.t_least}));
  b.inverse_alpha2 = 1 / (std::min(alpha, kLargestShapedAlpha) * std::min(alpha, kLargestShapedAlpha));
  b.c1 = 1, b.c2 = 0.5f, b.c3 = 0, b.t_least = 0;
  if (alpha > kLargestShapedAlpha) b.mirror_cos = -1, b.mirror_sin = 0;
  return b;
}

void join_lobes(const PairReceivers& a, const PairReceivers& b, PairReceivers& joined) {
  joined.diffuse = std::max(a.diffuse, b.diffuse), joined.any = std::max(a.any, b.any);
  // A side without gloss has no say in the shape.
  const bool both = a.gloss > 0 && b.gloss > 0, keep = !both || same_shape(a, b);
  const PairReceivers sa = keep ? a : in_common_shape(a), sb = keep ? b : in_common_shape(b);
  const PairReceivers& glossy = a.gloss > 0 ? sa : sb;
  joined.gloss = std::max(sa.gloss, sb.gloss);
  joined.inverse_alpha2 = both ? std::min(sa.inverse_alpha2, sb.inverse_alpha2) : glossy.inverse_alpha2;
  joined.c1 = glossy.c1, joined.c2 = glossy.c2, joined.c3 = glossy.c3, joined.t_least = glossy.t_least;
  if (!both)
    joined.mirror = glossy.mirror, joined.mirror_cos = glossy.mirror_cos, joined.mirror_sin = glossy.mirror_sin;
  else
    set_cone(join(cone_of(sa.mirror, sa.mirror_cos), cone_of(sb.mirror, sb.mirror_cos)), joined.mirror,
             joined.mirror_cos, joined.mirror_sin);
}

}  // namespace
}  // namespace myrialux
