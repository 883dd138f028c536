// Draws lights by importance below the nodes of a cut, so that samples are dense where the cut expects much light.
#include "myrialux/methods/pass_errors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/shade_block.h"
#include "myrialux/lights/walks.h"
#include "myrialux/shading/shade_entries.h"
#include "myrialux/visibility/slice_visibility.h"

namespace myrialux {
namespace {

constexpr std::size_t kColumnsAtOnce = 256;

/// As representatives are drawn.
LightId draw_light(const LightTree& tree, std::uint32_t node, Rng& rng) {
  while (!tree.is_leaf(node)) {
    const LightNode& parent = tree.inner[node];
    node = rng.next() * parent.importance < tree.node(parent.left).importance ? parent.left : parent.right;
  }
  return tree.representative(node);
}

double weight(const LightTree& tree, std::uint32_t node, LightId light) {
  return static_cast<double>(tree.node(node).importance) / static_cast<double>(tree.importance[index(light)]);
}

}  // namespace

PassErrors::PassErrors(const FrameView& frame, const LightTree& tree, std::vector<ReceiverId> rows,
                       float clamp_distance)
    : frame_(frame), tree_(tree), rows_(std::move(rows)), clamp_distance_(clamp_distance) {
  MYRIALUX_ASSERT(rows_.size() <= kBlockRows);
}

/// [lights x rows]
std::vector<float> PassErrors::join(std::span<const LightId> lights, std::uint64_t& rays) const {
  const std::size_t n_rows = rows_.size();
  std::vector<float> x(lights.size() * n_rows), entries;
  std::vector<Column> columns;
  for (std::size_t first = 0; first < lights.size(); first += kColumnsAtOnce) {
    const std::size_t n = std::min(kColumnsAtOnce, lights.size() - first);
    columns.clear();
    for (const LightId j : lights.subspan(first, n)) columns.push_back({.light = j});
    SliceVisibility source(frame_.world, frame_.receivers, rows_, frame_.lights, columns, /*cull=*/true);
    BitMatrix visible(n_rows, n);
    trace_all(source, visible);
    rays += source.rays();
    entries.resize(n * kBlockRows);
    shade_entries(frame_.world, frame_.receivers, rows_, frame_.lights, columns, visible,
                  {.clamp_distance = clamp_distance_}, entries);
    for (std::size_t r = 0; r < n_rows; ++r) {
      const float beta = luminance(frame_.receivers.beta[index(rows_[r])]);
      for (std::size_t k = 0; k < n; ++k) x[(first + k) * n_rows + r] = beta * entries[k * kBlockRows + r];
    }
  }
  return x;
}

LightSetEstimates PassErrors::light_set(std::span<const std::uint32_t> nodes, double n_walks, Rng rng) const {
  const std::size_t n_rows = rows_.size();
  std::vector<LightId> lights;  // drawn ones, each within its walk
  struct Draw {
    std::size_t first, end, own;  ///< in `lights`
    double weight;
  };
  std::vector<Draw> draws;
  for (const std::uint32_t node : nodes) {
    const LightId own = draw_light(tree_, node, rng);
    const auto [first, end] = walk_of(frame_.lights, own);
    draws.push_back(
        {lights.size(), lights.size() + (end - first), lights.size() + (index(own) - first), weight(tree_, node, own)});
    for (std::size_t j = first; j < end; ++j) lights.push_back(static_cast<LightId>(j));
  }

  LightSetEstimates result{std::vector<double>(n_rows), std::vector<double>(n_rows)};
  const std::vector<float> x = join(lights, result.rays);
  for (std::size_t r = 0; r < n_rows; ++r) {
    double sum = 0, squares = 0;
    for (const Draw& d : draws) {
      const double own = d.weight * static_cast<double>(x[d.own * n_rows + r]);
      double walk = 0;
      for (std::size_t j = d.first; j < d.end; ++j) walk += static_cast<double>(x[j * n_rows + r]);
      sum += own, squares += own * walk;
    }
    result.radiance[r] = sum;
    if (n_walks > 1) result.variance[r] = std::max(0.0, squares - sum * sum / n_walks) * n_walks / (n_walks - 1);
  }
  return result;
}

RowEstimates PassErrors::clusters(std::span<const std::uint32_t> nodes, std::size_t most, Rng rng) const {
  // A single light stands for itself.
  std::vector<std::uint32_t> inner;
  for (const std::uint32_t node : nodes)
    if (!tree_.is_leaf(node)) inner.push_back(node);
  const std::size_t n_rows = rows_.size(), n = std::min(inner.size(), most);
  std::vector<LightId> lights;  // pairs
  std::vector<double> weights;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t first = k * inner.size() / n, end = (k + 1) * inner.size() / n;
    const std::uint32_t node = inner[first + rng.below(static_cast<std::uint32_t>(end - first))];
    const double stands_for = std::sqrt(static_cast<double>(end - first));
    for (int draw = 0; draw < 2; ++draw) {
      lights.push_back(draw_light(tree_, node, rng));
      weights.push_back(weight(tree_, node, lights.back()) * stands_for);
    }
  }
  RowEstimates result{std::vector<double>(n_rows)};
  const std::vector<float> x = join(lights, result.rays);
  for (std::size_t k = 0; k < lights.size(); k += 2)
    for (std::size_t r = 0; r < n_rows; ++r) {
      const double difference = weights[k] * static_cast<double>(x[k * n_rows + r]) -
                                weights[k + 1] * static_cast<double>(x[(k + 1) * n_rows + r]);
      result.value[r] += 0.5 * difference * difference;
    }
  return result;
}

}  // namespace myrialux
