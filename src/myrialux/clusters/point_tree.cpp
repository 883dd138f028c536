// Builds the point tree: Morton codes of normal and position, sorted in parallel; subtrees of few receivers are built
// independently, what stands above them from the codes alone. [bus15, 3]
// Deviations: the box that is divided is the receivers' own; bounds are true cones instead of the representative's
// directions; leaves are single receivers even where codes agree.
#include "myrialux/clusters/point_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "myrialux/base/assert.h"
#include "myrialux/base/parallel.h"
#include "myrialux/clusters/bounds.h"
#include "myrialux/clusters/lobe_bounds.h"

namespace myrialux {
namespace {

constexpr std::size_t kSerialPoints = 1 << 12;  ///< subtrees of at most so many are one task
constexpr std::uint32_t kDigits = 21;           ///< of 3 bits in a code

struct Point {
  std::uint64_t code;
  std::uint32_t row;
  bool operator<(const Point& o) const { return code != o.code ? code < o.code : row < o.row; }
};
using Points = std::span<const Point>;

std::vector<Point> sorted_points(const Receivers& receivers, std::uint32_t normal_levels);

class Builder {
 public:
  Builder(const World& world, const Receivers& receivers, Points points, PointTree& tree)
      : world_(world), receivers_(receivers), points_(points), tree_(tree) {}
  void build();

 private:
  void build_top(std::uint32_t node);
  void build_below(std::uint32_t node, std::uint32_t& next_free);
  void make_leaf(PointNode& node) const;
  void join_children(PointNode& node) const;

  const World& world_;
  const Receivers& receivers_;
  Points points_;
  PointTree& tree_;
  std::vector<std::uint32_t> subtrees_;  ///< roots, among the nodes that stand above them
};

void set_shape(const PointNode& node, PairReceivers& r);
void draw_representatives(RandomKey key, PointTree& tree);

}  // namespace

PointTree build_point_tree(const World& world, const Receivers& receivers, const PointTreeParams& params) {
  MYRIALUX_ASSERT(params.normal_levels <= kMaxNormalLevels);
  PointTree tree;
  if (receivers.size() == 0) return tree;
  {
    const std::vector<Point> points = sorted_points(receivers, params.normal_levels);
    tree.order.resize(points.size());
    parallel_for(
        points.size(), [&](std::size_t k) { tree.order[k] = static_cast<ReceiverId>(points[k].row); }, kSerialPoints);
    Builder(world, receivers, points, tree).build();
  }
  draw_representatives(params.key, tree);
  return tree;
}

PairReceivers make_pair_receivers(const PointNode& node) {
  PairReceivers r{};
  for (int a = 0; a < 3; ++a) r.lower[a] = node.box.lower[a], r.upper[a] = node.box.upper[a];
  const auto sine = [](float cosine) { return std::sqrt(std::max(0.0f, 1 - cosine * cosine)); };
  r.normal = axis_frame(node.normals.axis);
  r.normal_cos = node.normals.cos_angle, r.normal_sin = sine(node.normals.cos_angle);
  r.diffuse = node.diffuse, r.gloss = node.gloss, r.any = node.any;
  if (!(node.gloss > 0)) return r;
  r.mirror = axis_frame(node.mirrors.axis);
  r.mirror_cos = node.mirrors.cos_angle, r.mirror_sin = sine(node.mirrors.cos_angle);
  r.inverse_alpha2 = 1 / (node.alpha * node.alpha);
  set_shape(node, r);
  return r;
}

namespace {

void set_shape(const PointNode& node, PairReceivers& r) {
  const float a = node.alpha * node.alpha;
  switch (node.shape) {
    case GlossShape::ggx:
      r.c1 = 2, r.c2 = 1, r.c3 = 0;
      return;
    case GlossShape::beckmann:
      r.c1 = 1, r.c2 = 0.5f, r.c3 = 1.0f / 6;
      return;
    case GlossShape::blinn_phong:
      r.c1 = 1 + a, r.c2 = (1 + a) / 2, r.c3 = (1 - a * a) / 6;
      return;
    case GlossShape::common:
      r.c1 = 1, r.c2 = 0.5f, r.c3 = 0;
  }
}

/// Every third bit of the result from the bits of x, which has at most 21.
std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

/// Octants of a point in the unit cube, `levels` digits of 3 bits.
std::uint64_t morton_code(Vec3 x, std::uint32_t levels) {
  std::uint64_t code = 0;
  const float cells = static_cast<float>(1u << levels);
  for (int a = 0; a < 3; ++a) {
    const float cell = std::clamp(x[a] * cells, 0.0f, cells - 1);
    code |= spread_bits(static_cast<std::uint64_t>(cell)) << (2 - a);
  }
  return code;
}

void sort_points(std::span<Point> points) {
  if (points.size() <= kSerialPoints) return std::sort(points.begin(), points.end());
  const std::size_t middle = points.size() / 2;
  std::nth_element(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(middle), points.end());
  parallel_invoke([&] { sort_points(points.first(middle)); }, [&] { sort_points(points.subspan(middle)); });
}

std::vector<Point> sorted_points(const Receivers& receivers, std::uint32_t normal_levels) {
  Box3 box;
  for (const Vec3 p : receivers.p) box.add(p);
  const Vec3 extent = box.upper - box.lower;
  const auto inverse = [](float x) { return x > 0 ? 1 / x : 0.0f; };
  const Vec3 scale{inverse(extent.x), inverse(extent.y), inverse(extent.z)};
  const std::uint32_t levels = kDigits - normal_levels;
  std::vector<Point> points(receivers.size());
  parallel_for(
      points.size(),
      [&](std::size_t i) {
        const Vec3 d = receivers.p[i] - box.lower, n = receivers.n[i] * 0.5f + Vec3{0.5f, 0.5f, 0.5f};
        const std::uint64_t normals = morton_code(n, normal_levels);
        points[i] = {normals << 3 * levels | morton_code({d.x * scale.x, d.y * scale.y, d.z * scale.z}, levels),
                     static_cast<std::uint32_t>(i)};
      },
      kSerialPoints);
  sort_points(points);
  return points;
}

/// Where the children of a range begin, and its end: the octants of the first digit that differs, in order.
struct Octants {
  std::array<std::uint32_t, 9> begin{};
  std::uint32_t n = 0;
};

Octants split(Points points, std::uint32_t first, std::uint32_t count) {
  Octants o;
  const Points range = points.subspan(first, count);
  const std::uint64_t differs = range.front().code ^ range.back().code;
  if (differs == 0) {  // in one cell: by count
    o.n = std::min(count, 8u);
    for (std::uint32_t k = 0; k <= o.n; ++k)
      o.begin[k] = first + static_cast<std::uint32_t>(std::uint64_t{count} * k / o.n);
    return o;
  }
  const int shift = (63 - std::countl_zero(differs)) / 3 * 3;
  auto at = range.begin();
  while (at != range.end()) {
    o.begin[o.n++] = first + static_cast<std::uint32_t>(at - range.begin());
    const std::uint64_t digit = at->code >> shift;
    at = std::partition_point(at, range.end(), [&](const Point& p) { return p.code >> shift <= digit; });
  }
  o.begin[o.n] = first + count;
  return o;
}

/// Descendants of a range of receivers.
std::uint32_t count_below(Points points, std::uint32_t first, std::uint32_t count) {
  if (count == 1) return 0;
  const Octants o = split(points, first, count);
  std::uint32_t n = o.n;
  for (std::uint32_t k = 0; k < o.n; ++k) n += count_below(points, o.begin[k], o.begin[k + 1] - o.begin[k]);
  return n;
}

/// The node's children without their bounds.
std::array<PointNode, 8> make_children(Points points, std::uint32_t place, PointNode& node) {
  const Octants o = split(points, node.first, node.count);
  std::array<PointNode, 8> children;
  for (std::uint32_t k = 0; k < o.n; ++k)
    children[k].first = o.begin[k], children[k].count = o.begin[k + 1] - o.begin[k];
  node.children = place, node.n_children = static_cast<std::uint8_t>(o.n);
  return children;
}

/// A lobe that its shape cannot tell counts with its peak, in all directions.
void to_peak(PointNode& node, const LobeBounds& lobes) {
  node.gloss = max_component(peak_gloss(lobes));
  node.mirrors.cos_angle = -1;
  node.alpha = kLargestShapedAlpha, node.shape = GlossShape::common;
}

void Builder::make_leaf(PointNode& node) const {
  const std::size_t i = points_[node.first].row;
  const BsdfParams& params = receivers_.bsdf[i];
  const Bsdf bsdf = make_bsdf(world_.scene.materials[index(params.material)], params, world_.sharp_alpha);
  const Vec3 n = receivers_.n[i], wo = receivers_.wo[i];
  const LobeBounds lobes = lobe_bounds(bsdf, Frame(receivers_.inside[i] ? -n : n).to_local(wo));
  node.box = {};
  node.box.add(receivers_.p[i]);
  node.normals = {n, 1};
  node.mirrors = {normalize(n * (2 * dot(n, wo)) - wo), 1};
  node.diffuse = max_component(lobes.diffuse), node.any = max_component(lobes.any);
  node.gloss = max_component(lobes.gloss);
  if (!(node.gloss > 0)) return;
  node.alpha = lobes.alpha;
  node.shape = !lobes.microfacets ? GlossShape::blinn_phong : lobes.c1 == 2 ? GlossShape::ggx : GlossShape::beckmann;
  if (lobes.alpha > kLargestShapedAlpha) to_peak(node, lobes);
}

void join(const PointNode& child, bool is_first, PointNode& node) {
  if (is_first) {
    const std::uint32_t first = node.first, count = node.count, children = node.children;
    const std::uint8_t n_children = node.n_children;
    node = child;
    node.first = first, node.count = count, node.children = children, node.n_children = n_children;
    return;
  }
  node.box.add(child.box);
  node.normals = join(node.normals, child.normals);
  node.diffuse = std::max(node.diffuse, child.diffuse), node.any = std::max(node.any, child.any);
  if (!(child.gloss > 0)) return;  // a side without gloss has no say in its shape
  if (!(node.gloss > 0)) {
    node.mirrors = child.mirrors, node.alpha = child.alpha, node.shape = child.shape;
  } else {
    node.mirrors = join(node.mirrors, child.mirrors);
    node.alpha = std::max(node.alpha, child.alpha);
    if (node.shape != child.shape) node.shape = GlossShape::common;
  }
  node.gloss = std::max(node.gloss, child.gloss);
}

void Builder::join_children(PointNode& node) const {
  for (std::uint32_t k = 0; k < node.n_children; ++k) join(tree_.nodes[node.children + k], k == 0, node);
}

/// @param next_free where descendants go; moved behind them
void Builder::build_below(std::uint32_t index, std::uint32_t& next_free) {
  PointNode& node = tree_.nodes[index];
  if (node.count == 1) return make_leaf(node);
  const std::array<PointNode, 8> children = make_children(points_, next_free, node);
  next_free += node.n_children;
  for (std::uint32_t k = 0; k < node.n_children; ++k) {
    tree_.nodes[node.children + k] = children[k];
    build_below(node.children + k, next_free);
  }
  join_children(node);
}

/// Nodes of many receivers, one after another.
void Builder::build_top(std::uint32_t index) {
  if (tree_.nodes[index].count <= kSerialPoints) return subtrees_.push_back(index);
  const auto place = static_cast<std::uint32_t>(tree_.nodes.size());
  const std::array<PointNode, 8> children = make_children(points_, place, tree_.nodes[index]);
  const std::uint32_t n = tree_.nodes[index].n_children;
  tree_.nodes.insert(tree_.nodes.end(), children.begin(), children.begin() + n);
  for (std::uint32_t k = 0; k < n; ++k) build_top(place + k);
}

void Builder::build() {
  PointNode root;
  root.count = static_cast<std::uint32_t>(points_.size());
  tree_.nodes.push_back(root);
  build_top(0);
  const std::size_t n_top = tree_.nodes.size();

  // Subtrees lie one behind the other; they are counted first, so that no node is ever moved.
  std::vector<std::uint32_t> places(subtrees_.size());
  parallel_for(subtrees_.size(), [&](std::size_t s) {
    const PointNode& node = tree_.nodes[subtrees_[s]];
    places[s] = count_below(points_, node.first, node.count);
  });
  std::size_t n = n_top;
  for (std::uint32_t& place : places) n += std::exchange(place, static_cast<std::uint32_t>(n));
  std::vector<PointNode> top = std::move(tree_.nodes);
  tree_.nodes = std::vector<PointNode>(n);
  std::copy(top.begin(), top.end(), tree_.nodes.begin());
  parallel_for(subtrees_.size(), [&](std::size_t s) { build_below(subtrees_[s], places[s]); });

  // Children stand behind their parents.
  for (std::size_t k = n_top; k-- > 0;)
    if (tree_.nodes[k].count > kSerialPoints) join_children(tree_.nodes[k]);
}

void draw_representatives(RandomKey key, PointTree& tree) {
  parallel_for(
      tree.nodes.size(),
      [&](std::size_t k) {
        PointNode& node = tree.nodes[k];
        Rng rng(key, Stage::point_tree, k);
        node.representative = tree.order[node.first + rng.below(node.count)];
      },
      kSerialPoints);
}

}  // namespace
}  // namespace myrialux
