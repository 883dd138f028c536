// Finds the light cut of a slice: from the roots down, always refining the node with the largest bound at the slice's
// points. [walter05, 4; wang20, 4.3] Deviation: stops at an exact number of clusters instead of an error threshold.
#include "myrialux/clusters/cut.h"

#include <algorithm>
#include <array>
#include <bit>

#include "myrialux/clusters/bounds.h"

namespace myrialux {
namespace {

/// Inner nodes of the cut, largest bound on top, ties to the lower node. Bounds are >= 0, so their bits order as
/// integers do; the node's complement breaks ties. Four children a place: a fifth faster than std::push_heap here.
class NodeHeap {
 public:
  void push(float bound, std::uint32_t node) {
    const Key key = Key{std::bit_cast<std::uint32_t>(bound)} << 32 | ~node;
    std::size_t place = keys_.size();
    keys_.push_back(key);
    for (; place > 0 && keys_[(place - 1) / 4] < key; place = (place - 1) / 4) keys_[place] = keys_[(place - 1) / 4];
    keys_[place] = key;
  }
  std::uint32_t pop() {
    const Key top = keys_.front(), last = keys_.back();
    keys_.pop_back();
    if (!keys_.empty()) sink(last);
    return ~static_cast<std::uint32_t>(top);
  }
  std::size_t size() const { return keys_.size(); }
  void append_nodes(std::vector<std::uint32_t>& nodes) const {
    for (const Key key : keys_) nodes.push_back(~static_cast<std::uint32_t>(key));
  }

 private:
  using Key = std::uint64_t;
  /// Fills the hole at the top: larger children rise until the key fits.
  void sink(Key key) {
    std::size_t place = 0;
    for (;;) {
      const std::size_t first = 4 * place + 1, end = std::min(first + 4, keys_.size());
      if (first >= end) break;
      std::size_t child = first;
      for (std::size_t k = first + 1; k < end; ++k)
        if (keys_[k] > keys_[child]) child = k;
      if (keys_[child] <= key) break;
      keys_[place] = keys_[child];
      place = child;
    }
    keys_[place] = key;
  }
  std::vector<Key> keys_;
};

/// The nodes of a growing cut: leaves are final, inner nodes wait in the heap.
struct Cut {
  NodeHeap heap;
  std::vector<std::uint32_t> leaves;
  std::size_t size() const { return heap.size() + leaves.size(); }
};

std::vector<ReceiverId> evenly_spaced(std::span<const ReceiverId> rows, std::size_t n_points) {
  if (n_points == 0 || n_points >= rows.size()) return {rows.begin(), rows.end()};
  std::vector<ReceiverId> points(n_points);
  for (std::size_t k = 0; k < n_points; ++k) points[k] = rows[(2 * k + 1) * rows.size() / (2 * n_points)];
  return points;
}

/// Adds nodes to the cut, bounded together.
void add_nodes(const LightTree& tree, const CutPoints& points, std::span<const std::uint32_t> nodes, Cut& cut) {
  std::array<CutCluster, kLightKinds> clusters;
  std::array<float, kLightKinds> bounds{};
  std::array<std::uint32_t, kLightKinds> inner{};
  std::size_t n_inner = 0;
  for (const std::uint32_t node : nodes) {
    if (tree.is_leaf(node)) {
      cut.leaves.push_back(node);
    } else {
      clusters[n_inner] = make_cut_cluster(tree, node);
      inner[n_inner++] = node;
    }
  }
  bound_clusters(points, std::span(clusters).first(n_inner), std::span(bounds).first(n_inner));
  for (std::size_t k = 0; k < n_inner; ++k) cut.heap.push(bounds[k], inner[k]);
}

std::vector<Column> sorted_columns(const VirtualLights& lights, const LightTree& tree, Vec3 centre,
                                   std::span<const std::uint32_t> nodes);

}  // namespace

std::vector<Column> light_cut(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                              const VirtualLights& lights, const LightTree& tree, const CutParams& params) {
  GrowingCut cut(world, receivers, rows, tree, params);
  cut.grow(params.n_clusters);
  return sorted_columns(lights, tree, slice_centre(receivers, rows), cut.nodes());
}

struct GrowingCut::State {
  const LightTree& tree;
  CutPoints points;
  Cut cut;
};

GrowingCut::GrowingCut(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                       const LightTree& tree, const CutParams& params)
    : state_(new State{
          tree, make_cut_points(world, receivers, evenly_spaced(rows, params.n_points), params.clamp_distance), {}}) {
  add_nodes(tree, state_->points, tree.roots, state_->cut);
}

GrowingCut::~GrowingCut() = default;
GrowingCut::GrowingCut(GrowingCut&&) noexcept = default;
GrowingCut& GrowingCut::operator=(GrowingCut&&) noexcept = default;
std::size_t GrowingCut::size() const { return state_->cut.size(); }

/// Each step replaces a node by its two children, so the cut grows by one.
void GrowingCut::grow(std::uint32_t n_clusters) {
  Cut& cut = state_->cut;
  while (cut.size() < n_clusters && cut.heap.size() > 0) {
    const LightNode& node = state_->tree.inner[cut.heap.pop()];
    add_nodes(state_->tree, state_->points, std::array{node.left, node.right}, cut);
  }
}

std::vector<std::uint32_t> GrowingCut::nodes() const {
  std::vector<std::uint32_t> nodes = state_->cut.leaves;
  state_->cut.heap.append_nodes(nodes);
  return nodes;
}

std::uint32_t octant(Vec3 slice_centre, const VirtualLights& lights, LightId light) {
  const std::size_t j = index(light);
  const Vec3 d = lights.kind[j] == LightKind::directional ? -lights.n[j] : lights.p[j] - slice_centre;
  return (d.x < 0 ? 1u : 0u) | (d.y < 0 ? 2u : 0u) | (d.z < 0 ? 4u : 0u);
}

namespace {

/// Nodes of a cut are disjoint, so their first leaves differ; leaves of one kind are consecutive.
std::vector<Column> sorted_columns(const VirtualLights& lights, const LightTree& tree, Vec3 centre,
                                   std::span<const std::uint32_t> nodes) {
  struct Place {
    std::uint64_t key;  ///< kind, octant, first leaf
    std::uint32_t node;
    std::uint32_t octant;
  };
  std::vector<Place> places;
  places.reserve(nodes.size());
  for (const std::uint32_t n : nodes) {
    const LightId light = tree.representative(n);
    const std::uint64_t kind = static_cast<std::uint8_t>(lights.kind[index(light)]);
    const std::uint32_t o = octant(centre, lights, light);
    places.push_back({(kind << 8 | o) << 32 | tree.first_leaf(n), n, o});
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.key < b.key; });

  std::vector<Column> columns;
  columns.reserve(nodes.size());
  for (const Place& place : places) {
    const LightId light = tree.representative(place.node);
    const bool leaf = tree.is_leaf(place.node);
    const float weight = leaf ? 1.0f : tree.inner[place.node].importance / tree.importance[index(light)];
    columns.push_back(
        {light, weight, place.node, leaf ? 1u : tree.inner[place.node].count, static_cast<std::uint8_t>(place.octant)});
  }
  return columns;
}

}  // namespace
}  // namespace myrialux
