// Slices, a reduced matrix of one row a slice, its columns clustered globally and refined for each slice, every entry
// of the slice and its columns traced. [ou11]  Deviations from the paper: docs/methods/lightslice.md.
#include <algorithm>
#include <memory>
#include <tuple>

#include "myrialux/base/clock.h"
#include "myrialux/clusters/refined_clusters.h"
#include "myrialux/methods/reduced_rows.h"
#include "myrialux/methods/slice_driver.h"

namespace myrialux {
namespace {

constexpr std::uint32_t kLeastRows = 64;  ///< a slice; one word of bits, four packets

/// What all slices draw their columns from.
struct LightSlices {
  ReducedMatrix matrix;
  std::vector<float> norm, importance;  ///< by column of the matrix
  ColumnClusters clusters;
  std::vector<Neighbours> neighbours;  ///< by slice
  std::uint64_t memory_bytes() const {
    return matrix.memory_bytes() + (norm.size() + importance.size()) * sizeof(float) +
           (clusters.order.size() + clusters.begin.size()) * sizeof(std::uint32_t);
  }
};

std::shared_ptr<const LightSlices> cluster_lights(const SliceFrame& slices, Progress& progress, RenderStats& stats);
std::vector<Column> slice_columns(const SliceFrame& slices, const LightSlices& all, std::size_t s);

}  // namespace

MethodResult render_lightslice(const FrameView& frame, const MethodParams& params, Progress& progress,
                               RenderStats& stats) {
  MethodParams own = params;
  own.slices.max_rows = lightslice_rows(frame.receivers.size(), params.lightslice.n_slices, params.slices.block_rows);
  SliceMethod method;
  method.complete = [](EntrySource& source, Rng&, BitMatrix& visible) { return trace_all(source, visible); };
  method.columns = [&](const SliceFrame& slices) -> ChooseColumns {
    const std::shared_ptr<const LightSlices> all = cluster_lights(slices, progress, stats);
    return [slices, all](std::size_t s) { return slice_columns(slices, *all, s); };
  };
  return render_slices(frame, own, method, progress, stats);
}

std::uint32_t lightslice_rows(std::uint64_t n_receivers, std::uint32_t n_slices, std::uint32_t block_rows) {
  const std::uint64_t rows = std::max<std::uint64_t>((n_receivers + n_slices - 1) / n_slices, kLeastRows);
  return static_cast<std::uint32_t>((rows + block_rows - 1) / block_rows * block_rows);
}

namespace {

std::shared_ptr<const LightSlices> cluster_lights(const SliceFrame& slices, Progress& progress, RenderStats& stats) {
  const LightSliceParams& own = slices.params.lightslice;
  auto all = std::make_shared<LightSlices>();
  all->matrix = trace_reduced_rows(slices.frame, slices.params, slices.slices, slices.tree, progress, stats).matrix;

  Stopwatch wall;
  progress.stage("columns", 0, "");
  all->norm = column_norms(all->matrix);
  for (const LightId j : slices.tree.order) all->importance.push_back(slices.tree.importance[index(j)]);
  const float n_global = own.global_share * static_cast<float>(slices.params.cut.n_clusters);
  all->clusters = sample_clusters(project_columns(all->matrix, own.n_dimensions, slices.params.key),
                                  std::max(1u, static_cast<std::uint32_t>(n_global)), slices.params.key);
  all->neighbours = find_neighbours(slices.frame.receivers, slices.slices,
                                    slices.params.slices.normal_weight * slices.frame.scene_radius, own.n_neighbours);
  stats.time_s["cluster"] += wall.lap();
  stats.memory.slices_peak = std::max(stats.memory.slices_peak, all->memory_bytes());
  return all;
}

/// The slice's clusters, each stood for by one light; ordered as cut.h says.
std::vector<Column> slice_columns(const SliceFrame& slices, const LightSlices& all, std::size_t s) {
  std::vector<LocalColumn> local = local_columns(all.matrix, all.norm, all.neighbours[s], all.clusters);
  const std::vector<std::uint32_t> begins = refine_clusters(local, all.clusters.begin, slices.params.cut.n_clusters);
  const LightSliceParams& own = slices.params.lightslice;
  const Vec3 centre = slice_centre(slices.frame.receivers, slices.slices.rows(s));
  Rng rng(slices.params.key, Stage::cut, s);
  std::vector<std::pair<std::uint32_t, Column>> drawn;
  for (std::size_t c = 0; c + 1 < begins.size(); ++c) {
    const auto cluster = std::span<const LocalColumn>(local).subspan(begins[c], begins[c + 1] - begins[c]);
    const Drawn d = draw_representative(cluster, all.importance,
                                        {.local_share = own.local_share, .power_share = own.power_share}, rng.next());
    if (d.weight <= 0) continue;
    const LightId light = slices.tree.order[d.column];
    drawn.push_back({d.column,
                     {.light = light,
                      .weight = d.weight,
                      .count = static_cast<std::uint32_t>(cluster.size()),
                      .octant = static_cast<std::uint8_t>(octant(centre, slices.frame.lights, light))}});
  }
  // The tree's order keeps kinds together.
  const auto place = [&](const std::pair<std::uint32_t, Column>& d) {
    return std::tuple(slices.frame.lights.kind[index(d.second.light)], d.second.octant, d.first);
  };
  std::sort(drawn.begin(), drawn.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  std::vector<Column> columns;
  columns.reserve(drawn.size());
  for (const auto& d : drawn) columns.push_back(d.second);
  return columns;
}

}  // namespace
}  // namespace myrialux
