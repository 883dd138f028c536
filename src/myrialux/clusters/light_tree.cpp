// Builds the light tree: lights are halved by count along the principal axis of (position, scaled normal), top down.
// [wang20, 4.3]; representatives and bounds as in [walter05, 3].
#include "myrialux/clusters/light_tree.h"

#include <algorithm>
#include <array>
#include <span>

#include "myrialux/base/array.h"
#include "myrialux/base/parallel.h"
#include "myrialux/clusters/lobe_bounds.h"
#include "myrialux/clusters/principal_axis.h"
#include "myrialux/clusters/tree_nodes.h"

namespace myrialux {
namespace {

constexpr std::size_t kSerialLights = 1 << 12;  ///< below this a task costs more than it gains

/// A light as the tree sees it; moved around whole so that every level reads memory in order. 32 bytes.
struct Point {
  SixVector x;
  std::uint32_t light;
  float key;  ///< position along the axis of the node being split
};

/// One subtree under construction: its inner nodes fill inner[node, node + count - 1), its leaves the order from
/// `first`.
struct Subtree {
  std::uint32_t node;
  DrawKey key;
  std::uint32_t first;
  std::span<Point> points;
};

void build(const Subtree& s, const NodeMaker& maker, LightTree& tree);
Array<Point> points_of_kind(const VirtualLights& lights, const LightTree& tree, LightKind kind, float scale);
void split(std::span<Point> points);

}  // namespace

LightTree build_light_tree(const World& world, const VirtualLights& lights, float scene_radius,
                           const LightTreeParams& params) {
  LightTree tree;
  tree.lights = &lights;
  tree.importance = light_importance(world, lights);

  // Places of all nodes follow from the counts, n - 1 inner ones for each kind, so subtrees are built independently.
  std::array<Array<Point>, kLightKinds> points;
  std::array<std::size_t, kLightKinds> n_lights{};
  for (int k = 0; k < kLightKinds; ++k) {
    points[k] = points_of_kind(lights, tree, static_cast<LightKind>(k), params.normal_weight * scene_radius);
    n_lights[k] = points[k].size();
  }
  const std::array<RootPlace, kLightKinds> roots = reserve_nodes(n_lights, tree);

  const NodeMaker maker(world, lights, params.key, tree);
  for (int k = 0; k < kLightKinds; ++k)
    if (!points[k].empty()) build({roots[k].inner, roots[k].key, roots[k].first, points[k]}, maker, tree);
  return tree;
}

GlossyNode glossy_bounds(const World& world, const VirtualLights& lights, LightId light) {
  const std::size_t j = index(light);
  const VirtualLights::Glossy& g = lights.glossy[lights.extra[j]];
  const Vec3 n = lights.n[j];
  const Bsdf bsdf = make_bsdf(world.scene.materials[index(g.bsdf.material)], g.bsdf, world.sharp_alpha);
  const LobeBounds bounds = lobe_bounds(bsdf, Frame(n).to_local(g.wi));
  const Rgb power = lights.light[j];
  const float lobe = geometric_cosine_factor(bounds, length(cross(n, lights.ng[j])));
  GlossyNode node;
  node.mirror_axis = normalize(n * (2 * dot(n, g.wi)) - g.wi);
  node.mirror_cos = bounds.alpha <= kLargestShapedAlpha ? 1.0f : -1.0f;
  node.diffuse = luminance(power * bounds.diffuse);
  node.gloss = luminance(power * peak_gloss(bounds)) * lobe;
  node.any = luminance(power * bounds.any) * lobe;
  node.alpha = std::min(bounds.alpha, kLargestShapedAlpha);
  return node;
}

namespace {

/// Coordinates in which alike lights are near. Directional lights: by where they come from.
Point make_point(const VirtualLights& lights, std::size_t j, float scale) {
  const Vec3 p = lights.p[j], n = lights.n[j], m = n * scale;
  Point point{{}, static_cast<std::uint32_t>(j), 0};
  switch (lights.kind[j]) {
    case LightKind::oriented:
    case LightKind::glossy:
      point.x = {p.x, p.y, p.z, m.x, m.y, m.z};
      break;
    case LightKind::point:
      point.x = {p.x, p.y, p.z, 0, 0, 0};
      break;
    case LightKind::directional:
      point.x = {-n.x, -n.y, -n.z, 0, 0, 0};
      break;
  }
  return point;
}

Array<Point> points_of_kind(const VirtualLights& lights, const LightTree& tree, LightKind kind, float scale) {
  return select<Point>(
      lights.size(), [&](std::size_t j) { return lights.kind[j] == kind && tree.importance[j] > 0; },
      [&](std::size_t j) { return make_point(lights, j, scale); });
}

/// Moves the lower half along the principal axis to the front; ties by light.
void split(std::span<Point> points) {
  if (points.size() == 2) return;
  const SixVector axis = principal_axis(points, [](const Point& p) -> const SixVector& { return p.x; });
  for (Point& p : points) {
    p.key = 0;
    for (int k = 0; k < 6; ++k) p.key += axis[k] * p.x[k];
  }
  const auto middle = points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2);
  std::nth_element(points.begin(), middle, points.end(), [](const Point& a, const Point& b) {
    return a.key < b.key || (a.key == b.key && a.light < b.light);
  });
}

void build(const Subtree& s, const NodeMaker& maker, LightTree& tree) {
  const auto count = static_cast<std::uint32_t>(s.points.size()), n_left = count / 2;
  if (count == 1) return maker.make_leaf(s.first, s.points[0].light);
  set_places(s.node, s.first, count, n_left, tree);

  split(s.points);
  const auto build_left = [&] { build({s.node + 1, s.key.left(), s.first, s.points.first(n_left)}, maker, tree); };
  const auto build_right = [&] {
    build({s.node + n_left, s.key.right(n_left), s.first + n_left, s.points.subspan(n_left)}, maker, tree);
  };
  if (count > kSerialLights) {
    parallel_invoke(build_left, build_right);
  } else {
    build_left();
    build_right();
  }
  maker.join_children(s.node, s.key);
}

}  // namespace
}  // namespace myrialux
