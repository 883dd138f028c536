// Minimises (variance of the light set + of clusters + of visibility) x work over the number of clusters.
#include "myrialux/methods/auto_clusters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/methods/light_sample.h"

namespace myrialux {
namespace {

/// Error that completion is allowed, over the frame's mean.
constexpr double kVisibilityError = 0.005;

constexpr std::size_t kSampledSlices = 64, kSampledRows = 16;
constexpr std::uint32_t kSampledLights = 2048;
/// Of small frames one slice of this many is sampled, but kFewSlices at least.
constexpr std::size_t kSliceStride = 8, kFewSlices = 16;

/// Items of Stage::cut for the choice; slices and lightslice's representatives have theirs below.
constexpr std::uint64_t kChoiceItem = std::uint64_t{1} << 33;

/// One sampled slice: what its cut, grown ever larger, would err by.
struct Probe {
  LightSample sample;
  GrowingCut cut;
  double cluster_variance = 0;
};

/// Sums over all probes, over the number of rows.
struct Moments {
  double radiance = 0, light_set = 0, clusters = 0, n_columns = 0;
};

std::size_t n_sampled_slices(std::size_t n_slices) {
  return std::min(n_slices, std::clamp(n_slices / kSliceStride, kFewSlices, kSampledSlices));
}

/// Evenly spaced, at random places: the receivers at which the cut takes its bounds would flatter it.
std::vector<ReceiverId> draw_rows(std::span<const ReceiverId> rows, Rng& rng) {
  const std::size_t n = std::min(kSampledRows, rows.size());
  std::vector<ReceiverId> drawn;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t first = k * rows.size() / n, end = (k + 1) * rows.size() / n;
    drawn.push_back(rows[first + rng.below(static_cast<std::uint32_t>(end - first))]);
  }
  return drawn;
}

std::vector<Probe> make_probes(const FrameView& frame, const MethodParams& params, const Slices& slices,
                               const LightTree& tree, const WalkClasses& classes) {
  std::vector<std::optional<Probe>> made(n_sampled_slices(slices.size()));
  const std::uint32_t first_class = Rng(params.key, Stage::cut, kChoiceItem).below(classes.n_classes);
  parallel_for(made.size(), [&](std::size_t t) {
    Rng rng(params.key, Stage::cut, kChoiceItem + 1 + t);
    const std::size_t first = t * slices.size() / made.size(), end = (t + 1) * slices.size() / made.size();
    const std::span<const ReceiverId> rows = slices.rows(first + rng.below(static_cast<std::uint32_t>(end - first)));
    const auto sampled_class = static_cast<std::uint32_t>((first_class + t) % classes.n_classes);
    made[t].emplace(LightSample(frame, tree, classes, sampled_class, draw_rows(rows, rng), params.cut.clamp_distance),
                    GrowingCut(frame.world, frame.receivers, rows, tree, params.cut));
  });
  std::vector<Probe> probes;
  for (std::optional<Probe>& probe : made) probes.push_back(std::move(*probe));
  return probes;
}

/// Grows all cuts to n_clusters and sums what they would err by.
Moments grow(std::uint32_t n_clusters, std::vector<Probe>& probes) {
  parallel_for(probes.size(), [&](std::size_t t) {
    Probe& probe = probes[t];
    if (probe.cut.size() >= n_clusters) return;
    probe.cut.grow(n_clusters);
    probe.cluster_variance = probe.sample.cluster_variance(probe.cut.nodes());
  });
  Moments sum;
  double n_rows = 0;
  for (const Probe& probe : probes) {
    sum.radiance += probe.sample.radiance(), sum.light_set += probe.sample.light_set_variance();
    sum.clusters += probe.cluster_variance, sum.n_columns = std::max<double>(sum.n_columns, probe.cut.size());
    n_rows += static_cast<double>(probe.sample.n_rows());
  }
  return {sum.radiance / n_rows, sum.light_set / n_rows, sum.clusters / n_rows, sum.n_columns};
}

}  // namespace

double pass_work(double n_clusters, double lights_per_receiver) {
  constexpr double kReceiver = 600, kLight = 300;
  return kReceiver + kLight * lights_per_receiver + n_clusters;
}

ClusterChoice choose_clusters(const FrameView& frame, const MethodParams& params, const Slices& slices,
                              const LightTree& tree) {
  ClusterChoice best{.visibility_error = kVisibilityError};
  if (slices.size() == 0 || tree.n_lights() == 0) return best;
  const WalkClasses classes = deal_walks(frame.lights, tree, kSampledLights);
  std::vector<Probe> probes = make_probes(frame, params, slices, tree, classes);
  for (const Probe& probe : probes) best.rays += probe.sample.rays();

  // Sizes grow by sqrt(2). A larger cut costs more and cannot err less than by lights and visibility.
  const double lights_per_receiver =
      static_cast<double>(frame.lights.size()) / static_cast<double>(frame.receivers.size());
  double least = 0;
  for (int k = 0;; ++k) {
    const auto n = static_cast<std::uint32_t>(std::lround(kLeastAutoClusters * std::exp2(0.5 * k)));
    if (n > kMostAutoClusters) break;
    const Moments m = grow(n, probes);
    if (!(m.radiance > 0)) break;
    const double floor = m.light_set + std::pow(kVisibilityError * m.radiance, 2);
    const double work = pass_work(n, lights_per_receiver), loss = (floor + m.clusters) * work;
    if (k == 0 || loss < least) {
      least = loss, best.n_clusters = n;
      best.light_set_error = std::sqrt(m.light_set) / m.radiance;
      best.cluster_error = std::sqrt(m.clusters) / m.radiance;
    }
    if (floor * work >= least || m.n_columns < n) break;
  }
  return best;
}

MethodParams with_chosen_clusters(const FrameView& frame, const MethodParams& params, const Slices& slices,
                                  const LightTree& tree, Progress& progress, RenderStats& stats) {
  MethodParams chosen = params;
  if (!params.auto_clusters) return chosen;
  const Stopwatch wall;
  progress.stage("choice of clusters", 0, "");
  const ClusterChoice c = choose_clusters(frame, params, slices, tree);
  progress.note(fmt::format(
      "{} clusters a slice: a pass errs by {:.1f} % through the choice of its {} lights, {:.1f} % through clusters, "
      "and "
      "may by {:.1f} % through visibility",
      c.n_clusters, 100 * c.light_set_error, frame.lights.size(), 100 * c.cluster_error, 100 * c.visibility_error));
  chosen.cut.n_clusters = c.n_clusters;
  stats.clusters_auto = {c.n_clusters, c.light_set_error, c.cluster_error, c.visibility_error};
  stats.rays.shadow += c.rays;
  stats.time_s["cluster"] += wall.elapsed();
  return chosen;
}

}  // namespace myrialux
