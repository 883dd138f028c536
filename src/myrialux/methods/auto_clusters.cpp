// Minimises (variance of the light set + of clusters + of visibility) x work over the number of clusters.
#include "myrialux/methods/auto_clusters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/lights/walks.h"
#include "myrialux/methods/pass_errors.h"

namespace myrialux {
namespace {

constexpr std::size_t kSampledSlices = 48, kSampledRows = 16;
/// Of small frames one slice of this many is sampled, but kFewSlices at least.
constexpr std::size_t kSliceStride = 8, kFewSlices = 16;
constexpr std::size_t kMostPairs = 256;  ///< nodes of a cut that pairs of lights are drawn from
constexpr std::uint32_t kWalkCut = 250;  ///< size of the cut that walks are drawn from
constexpr double kLeftOut = 0.01;        ///< share of receivers, those of the largest variance
/// Candidates; no smaller than kLeastAutoClusters, no larger than kMostAutoClusters.
constexpr std::uint32_t kSizes[] = {64, 125, 250, 500, 1000, 2000, 4000, 8000};

/// Items of Stage::cut for the choice; slices and lightslice's representatives have theirs below.
constexpr std::uint64_t kChoiceItem = std::uint64_t{1} << 33;

/// One sampled slice.
struct Probe {
  PassErrors errors;
  GrowingCut cut;
  LightSetEstimates light_set;
  RowEstimates clusters;  ///< of the cut as it is
};

std::size_t n_sampled_slices(std::size_t n_slices) {
  return std::min(n_slices, std::clamp(n_slices / kSliceStride, kFewSlices, kSampledSlices));
}

Rng rng_of(const MethodParams& params, std::size_t probe, std::size_t item) {
  return {params.key, Stage::cut, kChoiceItem + probe * 64 + item};
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
                               const LightTree& tree) {
  const double n_walks = count_walks(frame.lights);
  std::vector<std::optional<Probe>> made(n_sampled_slices(slices.size()));
  parallel_for(made.size(), [&](std::size_t t) {
    Rng rng = rng_of(params, t, 0);
    const std::size_t first = t * slices.size() / made.size(), end = (t + 1) * slices.size() / made.size();
    const std::span<const ReceiverId> rows = slices.rows(first + rng.below(static_cast<std::uint32_t>(end - first)));
    Probe& probe = made[t].emplace(Probe{{frame, tree, draw_rows(rows, rng), params.cut.clamp_distance},
                                         {frame.world, frame.receivers, rows, tree, params.cut},
                                         {},
                                         {}});
    probe.cut.grow(kWalkCut);
    probe.light_set = probe.errors.light_set(probe.cut.nodes(), n_walks, rng_of(params, t, 1));
    probe.cut = GrowingCut(frame.world, frame.receivers, rows, tree, params.cut);
  });
  std::vector<Probe> probes;
  probes.reserve(made.size());
  for (std::optional<Probe>& probe : made) probes.push_back(std::move(*probe));
  return probes;
}

/// Grows all cuts to a size and draws from them. @return whether any became so large
bool grow(std::uint32_t n_clusters, const MethodParams& params, std::size_t step, std::vector<Probe>& probes) {
  parallel_for(probes.size(), [&](std::size_t t) {
    Probe& probe = probes[t];
    probe.cut.grow(n_clusters);
    const std::uint64_t rays = probe.clusters.rays;
    probe.clusters = probe.errors.clusters(probe.cut.nodes(), kMostPairs, rng_of(params, t, 2 + step));
    probe.clusters.rays += rays;
  });
  return std::any_of(probes.begin(), probes.end(), [&](const Probe& p) { return p.cut.size() >= n_clusters; });
}

/// Over all sampled receivers.
struct Moments {
  double radiance = 0, light_set = 0, clusters = 0;
};

/// Without the largest ones: a spark at a few receivers would tell more about the draw than about the frame, and
/// pictures are judged without their worst pixels.
double trimmed_mean(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  values.resize(values.size() - static_cast<std::size_t>(kLeftOut * static_cast<double>(values.size())));
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

Moments moments(const std::vector<Probe>& probes) {
  std::vector<double> radiance, light_set, clusters;
  const auto append = [](std::vector<double>& to, const std::vector<double>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (const Probe& p : probes) {
    append(radiance, p.light_set.radiance), append(light_set, p.light_set.variance);
    append(clusters, p.clusters.value);
  }
  const double mean = std::accumulate(radiance.begin(), radiance.end(), 0.0) / static_cast<double>(radiance.size());
  return {mean, trimmed_mean(std::move(light_set)), trimmed_mean(std::move(clusters))};
}

}  // namespace

double pass_work(double n_clusters, double lights_per_receiver) {
  constexpr double kReceiver = 400, kLight = 300;  // of tools/measure_auto.py's cost, rounded; all methods alike
  return kReceiver + kLight * lights_per_receiver + n_clusters;
}

ClusterChoice choose_clusters(const FrameView& frame, const MethodParams& params, const Slices& slices,
                              const LightTree& tree) {
  const double visibility_error = static_cast<double>(params.visibility_error);
  ClusterChoice best{.visibility_error = visibility_error};
  if (slices.size() == 0 || tree.n_lights() == 0) return best;
  std::vector<Probe> probes = make_probes(frame, params, slices, tree);

  // A larger cut costs more and cannot err less than by lights and visibility: then the search ends.
  const double lights_per_receiver =
      static_cast<double>(frame.lights.size()) / static_cast<double>(frame.receivers.size());
  double least = 0;
  for (std::size_t k = 0; k < std::size(kSizes); ++k) {
    const bool whole = grow(kSizes[k], params, k, probes);
    const Moments m = moments(probes);
    if (!(m.radiance > 0)) break;
    const double floor = m.light_set + std::pow(visibility_error * m.radiance, 2);
    const double work = pass_work(kSizes[k], lights_per_receiver), loss = (floor + m.clusters) * work;
    if (k == 0 || loss < least) {
      least = loss, best.n_clusters = kSizes[k];
      best.light_set_error = std::sqrt(m.light_set) / m.radiance;
      best.cluster_error = std::sqrt(m.clusters) / m.radiance;
    }
    if (floor * work >= least || !whole) break;
  }
  for (const Probe& probe : probes) best.rays += probe.light_set.rays + probe.clusters.rays;
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
      "{} clusters a slice: a pass errs by {:.1f} % because it has these {} lights and no others, by {:.1f} % because "
      "clusters stand for them; completion of visibility may add {:.1f} %",
      c.n_clusters, 100 * c.light_set_error, frame.lights.size(), 100 * c.cluster_error, 100 * c.visibility_error));
  chosen.cut.n_clusters = c.n_clusters;
  stats.clusters_auto = {c.n_clusters, c.light_set_error, c.cluster_error, c.visibility_error};
  stats.rays.shadow += c.rays;
  stats.time_s["choice"] += wall.elapsed();
  return chosen;
}

}  // namespace myrialux
