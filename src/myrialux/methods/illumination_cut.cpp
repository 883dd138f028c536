// IlluminationCut: pairs of a point cluster and a light cluster whose error bound stays below a share of the receivers'
// approximate radiance; every receiver of a pair is joined to one light. [bus15]; docs/methods/illumination-cut.md
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/clusters/agglomerative_tree.h"
#include "myrialux/clusters/bounds.h"
#include "myrialux/clusters/pair_walk.h"
#include "myrialux/methods/pair_blocks.h"
#include "myrialux/visibility/approximate_radiance.h"

namespace myrialux {
namespace {

constexpr std::uint32_t kBlockPoints = 64;  ///< largest point cluster whose pairs are shaded together

/// A pair accepted at a point node above the blocks; it holds for all of the node's receivers.
struct WidePair {
  std::uint32_t light;
  bool traced;  ///< every receiver sends a ray; else runs[first_run .. end_run) see the light
  std::uint32_t first_run, end_run;
};

/// What one thread holds between the root and the point node it is at; lists grow on the way down and shrink on the way
/// up.
struct Path {
  PairLists lists;
  std::vector<WidePair> pairs;
  std::vector<VisibleRun> runs;
  std::vector<BlockPair> block;  ///< of the present block
  PairReport report;
  std::uint64_t memory_bytes() const {
    return (lists.waiting.capacity() + lists.stack.capacity()) * sizeof(std::uint32_t) +
           pairs.capacity() * sizeof(WidePair) + runs.capacity() * sizeof(VisibleRun);
  }
};

/// Phase II. [bus15, algorithm 1]
class IlluminationCut {
 public:
  /// @param sampling none: every receiver of a pair sends its own ray
  IlluminationCut(const FrameView& frame, const LightTree& lights, const PointTree& points, float error,
                  float clamp_distance, const std::optional<SamplingParams>& sampling, Progress& progress);
  PairReport run();
  MethodResult result;

 private:
  PairReport visit(std::uint32_t node, std::size_t first_waiting, Path& path);
  PairReport visit_children(const PointNode& point, std::size_t first_waiting, Path& path);
  void judge_all(const PointNode& point, std::size_t first_waiting, Path& path, auto&& accept);
  void accept_wide(const PointNode& point, std::uint32_t light, Path& path);
  void render(const PointNode& block, std::size_t first_waiting, Path& path);
  void refine_in_block(const PointNode& block, const PointNode& point, std::size_t first_waiting, Path& path);
  void accept_in_block(const PointNode& block, const PointNode& point, std::uint32_t light, Path& path);
  std::uint64_t visible_bits(const PointNode& block, std::span<const VisibleRun> runs) const;
  bool traces_all(const PointNode& point, std::uint32_t light) const {
    return !sampling_ || lights_.is_leaf(light) || point.count < sampling_->least;
  }
  PairSampler sampler() const { return {frame_.world, frame_.receivers, frame_.lights, points_.order, *sampling_}; }

  const FrameView& frame_;
  const LightTree& lights_;
  const PointTree& points_;
  float error_, clamp_distance_, least_distance_squared_, far_;
  std::optional<SamplingParams> sampling_;
  Progress& progress_;
};

MethodResult render_pairs(const FrameView& frame, const MethodParams& params, float error,
                          const std::optional<SamplingParams>& sampling, Progress& progress, RenderStats& stats);
void add_to_stats(const PairReport& report, std::size_t n_receivers, double wall_s, RenderStats& stats);

}  // namespace

MethodResult render_illumination_cut(const FrameView& frame, const MethodParams& params, Progress& progress,
                                     RenderStats& stats) {
  return render_pairs(frame, params, params.illumination_cut.error, {}, progress, stats);
}

MethodResult render_illumination_cut_sampling(const FrameView& frame, const MethodParams& params, Progress& progress,
                                              RenderStats& stats) {
  const IlluminationCutParams& p = params.illumination_cut;
  return render_pairs(frame, params, p.sampling_error, p.sampling, progress, stats);
}

namespace {

LightTree build_tree(const FrameView& frame, const MethodParams& params) {
  if (params.illumination_cut.tree == TreeKind::divisive)
    return build_light_tree(frame.world, frame.lights, frame.scene_radius, params.tree);
  return build_agglomerative_tree(frame.world, frame.lights, frame.scene_radius, {.key = params.tree.key});
}

MethodResult render_pairs(const FrameView& frame, const MethodParams& params, float error,
                          const std::optional<SamplingParams>& sampling, Progress& progress, RenderStats& stats) {
  // Rows and columns are grouped first: both depend only on where things are, not on who sees whom.
  Stopwatch wall;
  progress.stage("clusters", 0, "");
  const LightTree lights = build_tree(frame, params);
  PointTree points = build_point_tree(frame.world, frame.receivers,
                                      {.normal_levels = params.illumination_cut.normal_levels, .key = params.key});

  // Phase I: about how bright everything is, which says how large an error may be.
  ApproximationParams approximation = params.illumination_cut.approximation;
  approximation.clamp_distance = params.cut.clamp_distance, approximation.scene_radius = frame.scene_radius;
  progress.stage("approximate image", 0, "");
  const std::uint64_t rays =
      approximate_radiance(frame.world, frame.receivers, frame.lights, lights, approximation, points).rays;
  stats.rays.shadow += rays, stats.refinement.approximate_rays += rays;
  stats.time_s["cluster"] += wall.lap();

  // Phase II: the pairs that this allows, and their light.
  IlluminationCut cut(frame, lights, points, error, params.cut.clamp_distance, sampling, progress);
  progress.stage("pairs", frame.receivers.size(), "receivers");
  const PairReport report = cut.run();
  add_to_stats(report, frame.receivers.size(), wall.lap(), stats);
  stats.memory.slices_peak = std::max(stats.memory.slices_peak, report.memory_bytes);
  stats.memory.trees = std::max(stats.memory.trees, lights.memory_bytes() + points.memory_bytes());
  return std::move(cut.result);
}

IlluminationCut::IlluminationCut(const FrameView& frame, const LightTree& lights, const PointTree& points, float error,
                                 float clamp_distance, const std::optional<SamplingParams>& sampling,
                                 Progress& progress)
    : frame_(frame),
      lights_(lights),
      points_(points),
      error_(error),
      clamp_distance_(clamp_distance),
      least_distance_squared_(std::max(clamp_distance * clamp_distance, 1e-20f)),
      far_(2 * frame.scene_radius),
      sampling_(sampling),
      progress_(progress) {
  const std::size_t n = frame.receivers.size();
  result.radiance.resize(n);
  result.slice.resize(n);
  result.cut_size.resize(n);
  result.visibility_fraction.resize(n);
}

PairReport IlluminationCut::run() {
  if (points_.nodes.empty()) return {};
  Path path;
  path.lists.waiting = lights_.roots;
  return visit(0, 0, path);
}

/// The point node with light nodes waiting[first_waiting ..] and everything below it.
PairReport IlluminationCut::visit(std::uint32_t index, std::size_t first_waiting, Path& path) {
  const PointNode& point = points_.nodes[index];
  if (point.count <= kBlockPoints) {
    render(point, first_waiting, path);
    return std::exchange(path.report, {});
  }
  const std::size_t end = path.lists.waiting.size(), n_pairs = path.pairs.size(), n_runs = path.runs.size();
  ThreadStopwatch cpu;
  judge_all(point, first_waiting, path, [&](std::uint32_t light) { accept_wide(point, light, path); });
  path.report.cut_s += cpu.lap();
  PairReport report = std::exchange(path.report, {});
  report += visit_children(point, end, path);
  report.memory_bytes = std::max(report.memory_bytes, path.memory_bytes());
  path.lists.waiting.resize(end), path.pairs.resize(n_pairs), path.runs.resize(n_runs);
  return report;
}

PairReport IlluminationCut::visit_children(const PointNode& point, std::size_t first_waiting, Path& path) {
  std::array<PairReport, 8> reports;
  if (point.count > kWalkTaskPoints) {
    parallel_for(point.n_children, [&](std::size_t k) {
      Path own;
      const auto& waiting = path.lists.waiting;
      own.lists.waiting.assign(waiting.begin() + static_cast<std::ptrdiff_t>(first_waiting), waiting.end());
      own.pairs = path.pairs, own.runs = path.runs;
      reports[k] = visit(point.children + static_cast<std::uint32_t>(k), 0, own);
    });
  } else {
    for (std::uint32_t k = 0; k < point.n_children; ++k) reports[k] = visit(point.children + k, first_waiting, path);
  }
  PairReport sum;
  for (std::uint32_t k = 0; k < point.n_children; ++k) sum += reports[k];
  return sum;
}

/// Calls accept(light node) for pairs within the error. A single light is no approximation, so it needs no bound but
/// that of being lit at all; otherwise the larger cluster is divided. [bus15, algorithm 1]
void IlluminationCut::judge_all(const PointNode& point, std::size_t first_waiting, Path& path, auto&& accept) {
  if (first_waiting == path.lists.waiting.size()) return;
  const PairReceivers receivers = make_pair_receivers(point);
  const float limit = error_ * point.colour, radius = Ball(point.box).radius;
  judge_pairs(lights_, first_waiting, path.lists, [&](std::uint32_t index) {
    const LightNode light = lights_.node(index);
    const float bound = bound_pair(receivers, make_cut_cluster(lights_, index), least_distance_squared_);
    ++path.report.bounds;
    if (bound == 0) return PairVerdict::done;
    if (light.is_leaf() || bound < limit) {
      ++path.report.pairs;
      accept(index);
      return PairVerdict::done;
    }
    return point.is_leaf() || light_ball(light, far_).radius > radius ? PairVerdict::split_lights
                                                                      : PairVerdict::split_points;
  });
}

void IlluminationCut::accept_wide(const PointNode& point, std::uint32_t light, Path& path) {
  WidePair pair{light, traces_all(point, light), 0, 0};
  if (!pair.traced) {
    pair.first_run = static_cast<std::uint32_t>(path.runs.size());
    PairSampler one = sampler();
    one.sample(point.first, point.count, lights_.representative(light), path.runs);
    path.report.rays += one.rays(), path.report.traced += one.rays();
    pair.end_run = static_cast<std::uint32_t>(path.runs.size());
  }
  path.pairs.push_back(pair);
}

std::uint64_t bits_of(const PointNode& block, std::uint32_t first, std::uint32_t end) {
  const std::uint32_t n = end - first;
  return (n == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1) << (first - block.first);
}

/// Bits of the block's receivers that lie in the runs, which are in order.
std::uint64_t IlluminationCut::visible_bits(const PointNode& block, std::span<const VisibleRun> runs) const {
  const std::uint32_t end = block.first + block.count;
  std::uint64_t bits = 0;
  auto run = std::partition_point(runs.begin(), runs.end(), [&](const VisibleRun& r) { return r.end <= block.first; });
  for (; run != runs.end() && run->first < end; ++run)
    bits |= bits_of(block, std::max(run->first, block.first), std::min(run->end, end));
  return bits;
}

void IlluminationCut::render(const PointNode& block, std::size_t first_waiting, Path& path) {
  ThreadStopwatch cpu;
  path.block.clear();
  const std::uint64_t all = bits_of(block, block.first, block.first + block.count);
  for (const WidePair& pair : path.pairs) {
    const auto runs = std::span(path.runs).subspan(pair.first_run, pair.end_run - pair.first_run);
    path.block.push_back({pair.light, all, pair.traced ? all : 0, pair.traced ? 0 : visible_bits(block, runs)});
  }
  refine_in_block(block, block, first_waiting, path);
  path.report.cut_s += cpu.lap();
  render_block(frame_, lights_, block, points_.rows(block), clamp_distance_, path.block, result, path.report);
  progress_.advance(block.count);
}

void IlluminationCut::refine_in_block(const PointNode& block, const PointNode& point, std::size_t first_waiting,
                                      Path& path) {
  const std::size_t end = path.lists.waiting.size();
  judge_all(point, first_waiting, path, [&](std::uint32_t light) { accept_in_block(block, point, light, path); });
  if (path.lists.waiting.size() == end) return;
  for (std::uint32_t k = 0; k < point.n_children; ++k)
    refine_in_block(block, points_.nodes[point.children + k], end, path);
  path.lists.waiting.resize(end);
}

void IlluminationCut::accept_in_block(const PointNode& block, const PointNode& point, std::uint32_t light, Path& path) {
  const std::uint64_t covered = bits_of(block, point.first, point.first + point.count);
  if (traces_all(point, light)) {
    path.block.push_back({light, covered, covered, 0});
    return;
  }
  const std::size_t n_runs = path.runs.size();
  PairSampler one = sampler();
  one.sample(point.first, point.count, lights_.representative(light), path.runs);
  path.report.rays += one.rays(), path.report.traced += one.rays();
  path.block.push_back({light, covered, 0, visible_bits(block, std::span(path.runs).subspan(n_runs))});
  path.runs.resize(n_runs);
}

void add_to_stats(const PairReport& report, std::size_t n_receivers, double wall_s, RenderStats& stats) {
  const double cpu_s = report.cut_s + report.visibility_s + report.shade_s;
  const double scale = cpu_s > 0 ? wall_s / cpu_s : 0;
  stats.time_s["cluster"] += scale * report.cut_s;
  stats.time_s["visibility"] += scale * report.visibility_s;
  stats.time_s["shade"] += scale * report.shade_s;
  stats.visibility.entries += report.entries, stats.visibility.traced += report.traced;
  stats.rays.shadow += report.rays;
  stats.slices += report.blocks, stats.refinement.bounds += report.bounds;
  // Means over passes: each pass adds its own share, the pipeline divides.
  const double n = static_cast<double>(std::max<std::size_t>(1, n_receivers));
  stats.clusters_mean += static_cast<double>(report.covered) / n;
  const double all = report.radiance + report.clamped_away;
  stats.clamped_energy_fraction += all > 0 ? report.clamped_away / all : 0;
}

}  // namespace
}  // namespace myrialux
