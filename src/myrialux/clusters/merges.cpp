// Counts the leaves below each merge, from which the places of all nodes follow; subtrees are then filled on their own.
#include "myrialux/clusters/merges.h"

#include "myrialux/base/parallel.h"

namespace myrialux {
namespace {

constexpr std::uint32_t kSerialLights = 1 << 12;  ///< subtrees up to this size are one task

/// A node of the merges and where it goes.
struct Place {
  std::uint32_t id, node;
  DrawKey key;
  std::uint32_t first;
};

class Layout {
 public:
  Layout(const Merges& merges, std::span<const std::uint32_t> lights, const NodeMaker& maker, LightTree& tree);
  /// Fills the node, but for its sums; adds the places of its children to `open`.
  void place(const Place& p, std::vector<Place>& open) const;
  void fill_subtree(const Place& top) const;
  std::uint32_t count(std::uint32_t id) const { return id < n_ ? 1u : count_[id - n_]; }

 private:
  const Merges& merges_;
  std::span<const std::uint32_t> lights_;
  const NodeMaker& maker_;
  LightTree& tree_;
  std::uint32_t n_;
  std::vector<std::uint32_t> count_;  ///< leaves below each merge
};

}  // namespace

void lay_out(const Merges& merges, std::span<const std::uint32_t> lights, const RootPlace& root, const NodeMaker& maker,
             LightTree& tree) {
  const Layout layout(merges, lights, maker, tree);
  std::vector<Place> open{{merges.root, root.inner, root.key, root.first}}, subtrees, upper;
  while (!open.empty()) {
    const Place p = open.back();
    open.pop_back();
    if (layout.count(p.id) <= kSerialLights) {
      subtrees.push_back(p);
    } else {
      layout.place(p, open);
      upper.push_back(p);
    }
  }
  parallel_for(subtrees.size(), [&](std::size_t k) { layout.fill_subtree(subtrees[k]); });
  for (std::size_t k = upper.size(); k-- > 0;) maker.join_children(upper[k].node, upper[k].key);
}

namespace {

Layout::Layout(const Merges& merges, std::span<const std::uint32_t> lights, const NodeMaker& maker, LightTree& tree)
    : merges_(merges), lights_(lights), maker_(maker), tree_(tree), n_(static_cast<std::uint32_t>(lights.size())) {
  // A list in which parts come after their whole, walked backwards.
  std::vector<std::uint32_t> down;
  down.reserve(n_);
  if (merges.root >= n_) down.push_back(merges.root);
  for (std::size_t k = 0; k < down.size(); ++k)
    for (const std::uint32_t part : merges.parts[down[k] - n_])
      if (part >= n_) down.push_back(part);
  count_.resize(n_);
  for (std::size_t k = down.size(); k-- > 0;) {
    const auto& parts = merges.parts[down[k] - n_];
    count_[down[k] - n_] = count(parts[0]) + count(parts[1]);
  }
}

void Layout::place(const Place& p, std::vector<Place>& open) const {
  if (p.id < n_) return maker_.make_leaf(p.first, lights_[p.id]);
  const auto& parts = merges_.parts[p.id - n_];
  const std::uint32_t n_left = count(parts[0]);
  set_places(p.node, p.first, count(p.id), n_left, tree_);
  open.push_back({parts[0], p.node + 1, p.key.left(), p.first});
  open.push_back({parts[1], p.node + n_left, p.key.right(n_left), p.first + n_left});
}

void Layout::fill_subtree(const Place& top) const {
  std::vector<Place> open{top};
  std::vector<Place> inner;
  while (!open.empty()) {
    const Place p = open.back();
    open.pop_back();
    place(p, open);
    if (p.id >= n_) inner.push_back(p);
  }
  for (std::size_t k = inner.size(); k-- > 0;) maker_.join_children(inner[k].node, inner[k].key);
}

}  // namespace
}  // namespace myrialux
