// Refines the cuts of a packet of receivers by the largest bound among those that need it. [walter05, 4]
// Deviation: receivers of a packet share the order of refinement, not the cut; a packet of one has the published order.
#include "myrialux/clusters/receiver_cut.h"

#include <algorithm>
#include <bit>
#include <deque>
#include <span>
#include <vector>

#include "myrialux/base/assert.h"

namespace myrialux {
namespace {

using Lanes = std::array<float, kCutLanes>;

/// A node in the cuts of some receivers.
struct CutNode {
  PacketLight light;  ///< its cluster's estimate
  Lanes bound;        ///< 0: leaf
  std::uint32_t node;
  std::uint32_t rows;  ///< bits; 0: free
};

/// One packet's cuts while they grow. Memory is kept from packet to packet.
class PacketRefinement {
 public:
  void start(const LightTree& tree, const CutPoints& points, std::size_t group, std::uint32_t rows,
             const ReceiverCutParams& params, LightAtPacket& lights);
  void refine();
  PacketCut result() const;

 private:
  struct Waiting {
    float bound;
    std::uint32_t place;
    bool operator<(const Waiting& other) const {
      return bound < other.bound || (bound == other.bound && place > other.place);
    }
  };

  void add_root(std::uint32_t node);
  void split(std::uint32_t place, std::uint32_t rows);
  std::uint32_t new_place();
  void set_bounds(CutNode& at);
  void evaluate(CutNode& at);
  void wait(std::uint32_t place, std::uint32_t rows);
  std::uint32_t rows_in_need(const CutNode& at) const;
  void change_total(const CutNode& at, std::uint32_t rows, float sign);

  const LightTree* tree_ = nullptr;
  const CutPoints* points_ = nullptr;
  std::size_t group_ = 0;
  ReceiverCutParams params_;
  LightAtPacket* lights_ = nullptr;
  std::deque<CutNode> nodes_;  ///< grows without copies; the first n_nodes_ are in use or free
  std::size_t n_nodes_ = 0;
  std::vector<std::uint32_t> free_;
  std::vector<Waiting> heap_;
  std::vector<std::uint32_t> settled_;  ///< places whose bounds were small enough when looked at
  std::array<double, kCutLanes> total_{};
  std::array<std::uint32_t, kCutLanes> size_{};
  std::uint32_t growing_ = 0;  ///< receivers whose cut may still grow
  std::uint32_t n_bounds_ = 0, n_evaluated_ = 0;
};

template <class Body>
void for_rows(std::uint32_t rows, const Body& body) {
  for (; rows != 0; rows &= rows - 1) body(static_cast<std::size_t>(std::countr_zero(rows)));
}

}  // namespace

PacketCut cut_packet(const LightTree& tree, const CutPoints& points, std::size_t group, std::uint32_t rows,
                     const ReceiverCutParams& params, LightAtPacket& lights) {
  thread_local PacketRefinement refinement;
  refinement.start(tree, points, group, rows, params, lights);
  refinement.refine();
  return refinement.result();
}

namespace {

void PacketRefinement::start(const LightTree& tree, const CutPoints& points, std::size_t group, std::uint32_t rows,
                             const ReceiverCutParams& params, LightAtPacket& lights) {
  tree_ = &tree, points_ = &points, group_ = group, params_ = params, lights_ = &lights;
  n_nodes_ = 0;
  free_.clear(), heap_.clear(), settled_.clear();
  total_ = {}, size_ = {}, growing_ = rows;
  n_bounds_ = n_evaluated_ = 0;
  for (const std::uint32_t root : tree.roots) add_root(root);
  if (tree.roots.size() >= params.max_size) growing_ = 0;
}

/// Largest bound first. Totals change meanwhile, so nodes that were good enough are looked at again in the end.
void PacketRefinement::refine() {
  for (;;) {
    while (!heap_.empty()) {
      std::pop_heap(heap_.begin(), heap_.end());
      const std::uint32_t place = heap_.back().place;
      heap_.pop_back();
      const std::uint32_t rows = rows_in_need(nodes_[place]);
      if (rows == 0)
        settled_.push_back(place);
      else
        split(place, rows);
    }
    std::vector<std::uint32_t> settled;
    settled.swap(settled_);
    for (const std::uint32_t place : settled) {
      const std::uint32_t rows = rows_in_need(nodes_[place]);
      if (rows != 0)
        wait(place, rows);
      else
        settled_.push_back(place);
    }
    if (heap_.empty()) return;
  }
}

PacketCut PacketRefinement::result() const {
  PacketCut cut;
  cut.size = size_, cut.n_bounds = n_bounds_, cut.n_evaluated = n_evaluated_;
  std::array<std::array<double, 3>, kCutLanes> sums{};
  for (std::size_t n = 0; n < n_nodes_; ++n)
    for_rows(nodes_[n].rows, [&](std::size_t k) {
      for (std::size_t c = 0; c < 3; ++c) sums[k][c] += static_cast<double>(nodes_[n].light.rgb[c][k]);
    });
  for (std::size_t k = 0; k < kCutLanes; ++k)
    cut.radiance[k] = {static_cast<float>(sums[k][0]), static_cast<float>(sums[k][1]), static_cast<float>(sums[k][2])};
  return cut;
}

void PacketRefinement::add_root(std::uint32_t node) {
  const std::uint32_t place = new_place();
  CutNode& at = nodes_[place];
  at.node = node, at.rows = growing_;
  set_bounds(at);
  evaluate(at);
  change_total(at, at.rows, 1);
  for_rows(at.rows, [&](std::size_t k) { ++size_[k]; });
  wait(place, at.rows);
}

/// Replaces the node by its children in the cuts of some receivers.
void PacketRefinement::split(std::uint32_t place, std::uint32_t rows) {
  const LightNode& divided = tree_->inner[nodes_[place].node];
  std::array<std::uint32_t, 2> children{};
  for (std::uint32_t c = 0; c < 2; ++c) {
    children[c] = new_place();
    CutNode& at = nodes_[children[c]];
    at.node = c == 0 ? divided.left : divided.right, at.rows = rows;
    const LightNode node = tree_->node(at.node);
    set_bounds(at);
    if (node.representative == divided.representative) {
      const float share = node.importance / divided.importance;
      for (std::size_t channel = 0; channel < 3; ++channel)
        for (std::size_t k = 0; k < kCutLanes; ++k)
          at.light.rgb[channel][k] = share * nodes_[place].light.rgb[channel][k];
    } else {
      evaluate(at);
    }
    change_total(at, rows, 1);
  }
  CutNode& parent = nodes_[place];
  change_total(parent, rows, -1);
  parent.rows &= ~rows;
  for_rows(rows, [&](std::size_t k) {
    if (++size_[k] >= params_.max_size) growing_ &= ~(1u << k);
  });
  if (parent.rows == 0)
    free_.push_back(place);
  else
    wait(place, parent.rows);
  for (const std::uint32_t child : children) wait(child, rows);
}

std::uint32_t PacketRefinement::new_place() {
  if (free_.empty()) {
    if (n_nodes_ == nodes_.size()) nodes_.emplace_back();
    return static_cast<std::uint32_t>(n_nodes_++);
  }
  const std::uint32_t place = free_.back();
  free_.pop_back();
  return place;
}

void PacketRefinement::set_bounds(CutNode& at) {
  if (tree_->is_leaf(at.node)) {
    at.bound.fill(0);
  } else {
    bound_lanes(*points_, group_, make_cut_cluster(*tree_, at.node), at.bound);
    ++n_bounds_;
  }
}

void PacketRefinement::evaluate(CutNode& at) {
  const LightNode node = tree_->node(at.node);
  lights_->evaluate(node.representative, at.rows, at.light);
  const float weight = node.importance / tree_->importance[index(node.representative)];
  for (auto& channel : at.light.rgb)
    for (float& x : channel) x *= weight;
  ++n_evaluated_;
}

/// Queues a node by its largest bound among the receivers that may still refine it.
void PacketRefinement::wait(std::uint32_t place, std::uint32_t rows) {
  float largest = 0;
  for_rows(rows & growing_, [&](std::size_t k) { largest = std::max(largest, nodes_[place].bound[k]); });
  if (!(largest > 0)) return;
  heap_.push_back({largest, place});
  std::push_heap(heap_.begin(), heap_.end());
}

std::uint32_t PacketRefinement::rows_in_need(const CutNode& at) const {
  std::uint32_t rows = 0;
  for_rows(at.rows & growing_, [&](std::size_t k) {
    const double allowed = static_cast<double>(params_.error) * total_[k];
    if (static_cast<double>(at.bound[k]) > std::max(allowed, 0.0)) rows |= 1u << k;
  });
  return rows;
}

void PacketRefinement::change_total(const CutNode& at, std::uint32_t rows, float sign) {
  for_rows(rows, [&](std::size_t k) {
    const Rgb light{at.light.rgb[0][k], at.light.rgb[1][k], at.light.rgb[2][k]};
    total_[k] += static_cast<double>(sign * luminance(light));
  });
}

}  // namespace
}  // namespace myrialux
