// Multidimensional lightcuts: a pixel's receivers and all lights are joined by one cut through the product of a tree
// over either. [walter06]; trees of lights and bounds as in the slice methods. docs/methods/mdlc.md
#include <algorithm>
#include <array>
#include <bit>
#include <memory>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/clusters/bounds.h"
#include "myrialux/clusters/gather_tree.h"
#include "myrialux/methods/render.h"
#include "myrialux/transfer/transfer.h"

namespace myrialux {
namespace {

/// Node of the product graph: all receivers of one node of the gather tree with all lights of one of the light tree.
struct Pair {
  std::uint32_t gather, light;
  Rgb transfer;  ///< between the representatives, visibility included, beta not
};

struct Counts {
  std::uint64_t pairs = 0, evaluated = 0, traced = 0;
  Counts& operator+=(const Counts& c) {
    pairs += c.pairs, evaluated += c.evaluated, traced += c.traced;
    return *this;
  }
};

/// The cut of one pixel. Keeps its memory from pixel to pixel.
class PixelCut {
 public:
  /// @param first, end receivers of the pixel; adds to their radiance
  Counts render(const FrameView& frame, const MethodParams& params, const LightTree& lights, std::size_t first,
                std::size_t end, std::span<Rgb> radiance);

 private:
  void refine(std::size_t place_of_pair);
  /// Which side to split. @param bounds set: of the two halves' pairs
  bool splits_light(const Pair& pair, std::array<float, 2>& bounds) const;
  void put(std::size_t place, const Pair& pair, float bound);
  float bound(std::uint32_t gather, const CutCluster& cluster) const;
  Rgb evaluate(std::uint32_t gather, std::uint32_t light);
  double luminance_of(const Pair& pair) const;
  void hand_out(std::span<Rgb> radiance);

  const GatherNode& gather(const Pair& pair) const { return tree_.nodes[pair.gather]; }
  float receiver_weight(const Pair& pair) const {
    const GatherNode& node = gather(pair);
    return node.strength / max_component(frame_->receivers.beta[index(node.representative)]);
  }
  float light_weight(const Pair& pair) const {
    const LightNode node = lights_->node(pair.light);
    return node.importance / lights_->importance[index(node.representative)];
  }

  const FrameView* frame_ = nullptr;
  const MethodParams* params_ = nullptr;
  const LightTree* lights_ = nullptr;
  float least_distance_squared_ = 0;
  std::vector<ReceiverId> rows_;
  GatherTree tree_;
  std::vector<Pair> pairs_;          ///< the cut
  std::vector<std::uint64_t> heap_;  ///< pairs that can be refined: bits of the bound, then the pair's complement
  std::vector<Rgb> of_node_;         ///< radiance that all receivers of a gather node have in common
  double total_ = 0;                 ///< the pixel's estimate: sum over its receivers, luminance
  Counts counts_;
};

/// @param begin as pixel_ranges() gives them
Counts render_pixels(const FrameView& frame, const MethodParams& params, const LightTree& lights,
                     const std::vector<std::uint32_t>& begin, std::span<Rgb> radiance, Progress& progress);

/// Where the receivers of each pixel that has any begin, and their end.
std::vector<std::uint32_t> pixel_ranges(const Receivers& receivers, int spp);

}  // namespace

MethodResult render_mdlc(const FrameView& frame, const MethodParams& params, Progress& progress, RenderStats& stats) {
  return prepare_mdlc(frame.world, frame.lights, frame.scene_radius, params, progress, stats)(frame, params, progress,
                                                                                              stats);
}

Method prepare_mdlc(const World& world, const VirtualLights& lights, float scene_radius, const MethodParams& params,
                    Progress& progress, RenderStats& stats) {
  Stopwatch wall;
  progress.stage("clusters", 0, "");
  /// What the parts of one pass share.
  struct Pass {
    LightTree lights;
    Counts sum;
    std::size_t n_pixels = 0;       ///< that have receivers
    double clusters_of_passes = 0;  ///< RenderStats::clusters_mean before
  };
  const auto pass = std::make_shared<Pass>(
      Pass{build_light_tree(world, lights, scene_radius, params.tree), {}, 0, stats.clusters_mean});
  stats.time_s["cluster"] += wall.lap();
  return [pass](const FrameView& frame, const MethodParams& own, Progress& part_progress, RenderStats& part_stats) {
    Stopwatch part_wall;
    MethodResult result;
    result.radiance.assign(frame.receivers.size(), Rgb{});
    const std::vector<std::uint32_t> begin = pixel_ranges(frame.receivers, frame.spp);
    const Counts counts = render_pixels(frame, own, pass->lights, begin, result.radiance, part_progress);
    part_stats.time_s["visibility"] += part_wall.lap();
    part_stats.visibility.entries += counts.evaluated, part_stats.visibility.traced += counts.traced;
    part_stats.rays.shadow += counts.traced;
    pass->sum += counts, pass->n_pixels += begin.size() - 1;
    if (pass->n_pixels > 0)
      part_stats.clusters_mean =
          pass->clusters_of_passes + static_cast<double>(pass->sum.pairs) / static_cast<double>(pass->n_pixels);
    return result;
  };
}

namespace {

Counts render_pixels(const FrameView& frame, const MethodParams& params, const LightTree& lights,
                     const std::vector<std::uint32_t>& begin, std::span<Rgb> radiance, Progress& progress) {
  const std::size_t n_pixels = begin.size() - 1;
  constexpr std::size_t kPixels = 8;  // of a work item
  std::vector<Counts> counts((n_pixels + kPixels - 1) / kPixels);
  progress.stage("pixels", n_pixels, "pixels");
  parallel_for(counts.size(), [&](std::size_t block) {
    thread_local PixelCut cut;
    const std::size_t end = std::min(n_pixels, (block + 1) * kPixels);
    for (std::size_t k = block * kPixels; k < end; ++k)
      counts[block] += cut.render(frame, params, lights, begin[k], begin[k + 1], radiance);
    progress.advance(end - block * kPixels);
  });
  Counts sum;
  for (const Counts& c : counts) sum += c;
  return sum;
}

Counts PixelCut::render(const FrameView& frame, const MethodParams& params, const LightTree& lights, std::size_t first,
                        std::size_t end, std::span<Rgb> radiance) {
  frame_ = &frame, params_ = &params, lights_ = &lights;
  least_distance_squared_ = std::max(params.cut.clamp_distance * params.cut.clamp_distance, 1e-20f);
  pairs_.clear(), heap_.clear(), total_ = 0, counts_ = {};
  rows_.clear();
  for (std::size_t i = first; i < end; ++i) rows_.push_back(static_cast<ReceiverId>(i));
  const Receivers& receivers = frame.receivers;
  Rng rng(params.key, Stage::gather_tree,
          (receivers.first_sample + receivers.sample[first]) / static_cast<std::uint64_t>(frame.spp));
  build_gather_tree(frame.world, frame.receivers, rows_, params.slices.normal_weight * frame.scene_radius, rng, tree_);
  if (tree_.nodes.empty()) return counts_;

  // The coarsest cut: all receivers with all lights of a kind.
  for (const std::uint32_t root : lights.roots) {
    const float largest = bound(0, make_cut_cluster(lights, root));
    if (!(largest > 0)) continue;
    pairs_.emplace_back();
    put(pairs_.size() - 1, {0, root, evaluate(0, root)}, largest);
  }
  // Each step replaces the pair of the largest bound by two.
  while (!heap_.empty() && pairs_.size() < params.cut.n_clusters) {
    const std::uint64_t top = heap_.front();
    const auto largest = std::bit_cast<float>(static_cast<std::uint32_t>(top >> 32));
    if (static_cast<double>(largest) <= static_cast<double>(params.mdlc_error) * total_) break;
    std::pop_heap(heap_.begin(), heap_.end());
    heap_.pop_back();
    refine(~static_cast<std::uint32_t>(top));
  }
  hand_out(radiance);
  counts_.pairs = pairs_.size();
  return counts_;
}

/// The side whose halves have the smaller sum of bounds; where the sums are alike, as for boxes that overlap, the
/// larger box: bounds of a small one gain nothing for many splits.
bool PixelCut::splits_light(const Pair& pair, std::array<float, 2>& bounds) const {
  const LightNode light = lights_->node(pair.light);
  const GatherNode& receivers = gather(pair);
  std::array<float, 2> of_lights{}, of_receivers{};
  if (!light.is_leaf())
    for (std::uint32_t k = 0; k < 2; ++k)
      of_lights[k] = bound(pair.gather, make_cut_cluster(*lights_, k == 0 ? light.left : light.right));
  if (!receivers.is_leaf()) {
    const CutCluster cluster = make_cut_cluster(*lights_, pair.light);
    for (std::uint32_t k = 0; k < 2; ++k) of_receivers[k] = bound(receivers.left + k, cluster);
  }
  const float sum_l = of_lights[0] + of_lights[1], sum_r = of_receivers[0] + of_receivers[1];
  constexpr float kAlike = 1.1f;
  bool by_light = light.box.diagonal() > receivers.diagonal;
  if (light.is_leaf() || receivers.is_leaf())
    by_light = receivers.is_leaf();
  else if (std::max(sum_l, sum_r) > kAlike * std::min(sum_l, sum_r))
    by_light = sum_l < sum_r;
  bounds = by_light ? of_lights : of_receivers;
  return by_light;
}

void PixelCut::refine(std::size_t place_of_pair) {
  const Pair parent = pairs_[place_of_pair];
  std::array<float, 2> bounds{};
  const bool by_light = splits_light(parent, bounds);
  const auto representative = [&](const Pair& pair) {
    return by_light ? index(lights_->representative(pair.light)) : index(gather(pair).representative);
  };
  total_ -= luminance_of(parent);
  pairs_[place_of_pair].transfer = {};  // kept only if nothing can come of either half
  for (std::uint32_t k = 0, n = 0; k < 2; ++k) {
    if (!(bounds[k] > 0)) continue;
    Pair child = parent;
    if (by_light)
      child.light = k == 0 ? lights_->inner[parent.light].left : lights_->inner[parent.light].right;
    else
      child.gather = gather(parent).left + k;
    if (representative(child) != representative(parent)) child.transfer = evaluate(child.gather, child.light);
    const std::size_t place = n++ == 0 ? place_of_pair : pairs_.size();
    if (place == pairs_.size()) pairs_.emplace_back();
    put(place, child, bounds[k]);
  }
}

/// A pair of one receiver and one light is exact.
void PixelCut::put(std::size_t place, const Pair& pair, float bound) {
  pairs_[place] = pair;
  total_ += luminance_of(pair);
  if (gather(pair).is_leaf() && lights_->is_leaf(pair.light)) return;
  // Bounds are >= 0, so their bits order as integers do; equal ones by place.
  heap_.push_back(std::uint64_t{std::bit_cast<std::uint32_t>(bound)} << 32 | ~static_cast<std::uint32_t>(place));
  std::push_heap(heap_.begin(), heap_.end());
}

float PixelCut::bound(std::uint32_t gather, const CutCluster& cluster) const {
  const GatherNode& node = tree_.nodes[gather];
  return node.strength * bound_pair(node.bounds, cluster, least_distance_squared_);
}

Rgb PixelCut::evaluate(std::uint32_t gather, std::uint32_t light) {
  const ReceiverId i = tree_.nodes[gather].representative;
  const LightId j = lights_->representative(light);
  ++counts_.evaluated;
  const Rgb entry = transfer(frame_->world, frame_->receivers, i, frame_->lights, j, params_->cut.clamp_distance);
  if (is_black(entry)) return entry;
  ++counts_.traced;
  const Segment s = shadow_segment(frame_->receivers, i, frame_->lights, j);
  const Tracer& tracer = frame_->world.tracer;
  return (s.distant ? tracer.occluded_direction(s.from, s.to) : tracer.occluded(s.from, s.to)) ? Rgb{} : entry;
}

/// Expected value, over the choice of representatives: the sum of beta x transfer over all receivers and lights.
double PixelCut::luminance_of(const Pair& pair) const {
  if (is_black(pair.transfer)) return 0;
  const std::size_t i = index(gather(pair).representative);
  return luminance(frame_->receivers.beta[i] * pair.transfer) * receiver_weight(pair) * light_weight(pair);
}

/// A pair's light goes to all its receivers if they weigh the same (most do: 1), else to the representative: in either
/// case the pixel's sum of beta x radiance is the sum over the pairs.
void PixelCut::hand_out(std::span<Rgb> radiance) {
  of_node_.assign(tree_.nodes.size(), {});
  for (const Pair& pair : pairs_) {
    const Rgb light = pair.transfer * light_weight(pair);
    if (gather(pair).same_beta)
      of_node_[pair.gather] += light;
    else
      radiance[index(gather(pair).representative)] += light * receiver_weight(pair);
  }
  for (std::size_t n = 0; n < tree_.nodes.size(); ++n) {
    const GatherNode& node = tree_.nodes[n];
    if (node.is_leaf())
      radiance[index(node.representative)] += of_node_[n];
    else
      of_node_[node.left] += of_node_[n], of_node_[node.left + 1] += of_node_[n];
  }
}

std::vector<std::uint32_t> pixel_ranges(const Receivers& receivers, int spp) {
  const auto samples = static_cast<std::uint32_t>(spp);
  std::vector<std::uint32_t> begin;
  for (std::size_t i = 0; i < receivers.size(); ++i)
    if (i == 0 || receivers.sample[i] / samples != receivers.sample[i - 1] / samples)
      begin.push_back(static_cast<std::uint32_t>(i));
  begin.push_back(static_cast<std::uint32_t>(receivers.size()));
  return begin;
}

}  // namespace
}  // namespace myrialux
