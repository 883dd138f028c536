// Cuts, traces, completes and shades one slice after another, and adds up what they report.
#include "myrialux/methods/slice_driver.h"

#include <algorithm>
#include <utility>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/methods/auto_clusters.h"
#include "myrialux/shading/shade.h"
#include "myrialux/visibility/column_energies.h"
#include "myrialux/visibility/heavy_entries.h"

namespace myrialux {
namespace {

/// Frames with fewer slices have no pilot.
constexpr std::size_t kLeastSlices = 8;

/// What one slice leaves behind for the statistics.
struct SliceReport {
  CompletionStats completion;
  ShadeResult shade;
  std::uint64_t rays = 0, columns = 0, memory_bytes = 0;
  std::uint64_t checked = 0, false_visible = 0, false_occluded = 0;  ///< entries; pilot only
  double cut_s = 0, visibility_s = 0, complete_s = 0, shade_s = 0;   ///< CPU seconds
};

/// What the slices share, and what they leave behind. Slices are independent, so each thread takes one whole.
class SliceLoop {
 public:
  SliceLoop(const FrameView& frame, const MethodParams& params, const SliceMethod& method, const Slices& slices,
            const LightTree& tree, ChooseColumns choose_columns);
  /// Traces some slices whole; their mean radiance sets the limit of what may be guessed in the others.
  void run_pilot(Progress& progress);
  /// All other slices; pilot slices are completed, too, only to count wrong bits.
  void run(Progress& progress);
  void add_to_stats(double loop_wall_s, RenderStats& stats) const;

  MethodResult result;

 private:
  void render(std::size_t s, const CompleteSlice& complete, BitMatrix& visible);
  void check_completion(std::size_t s, const BitMatrix& truth);
  void prepare(std::size_t s, std::span<const Column> columns, SliceVisibility& source);
  void shade(std::size_t s, std::span<const Column> columns, const BitMatrix& visible);
  bool in_pilot(std::size_t s) const { return !pilot_.empty() && s % kPilotStride == first_pilot_; }
  Rng completion_rng(std::size_t s) const { return Rng(params_.key, Stage::visibility, s); }

  const FrameView& frame_;
  const MethodParams& params_;
  const SliceMethod& method_;
  const Slices& slices_;
  const LightTree& tree_;
  const ChooseColumns choose_columns_;
  std::vector<SliceReport> reports_;  ///< by slice
  std::vector<BitMatrix> pilot_;      ///< true bits of the pilot's slices
  std::size_t first_pilot_ = 0;
  float mean_radiance_ = 0;  ///< of the pilot, beta included; 0: no pilot
  float guess_limit_ = 0;    ///< weight of an entry, radiance; 0: all may be guessed
};

/// Lightcuts' choice: each slice refines the tree where its own bounds are largest.
ChooseColumns by_light_cut(const SliceFrame& f) {
  return [f](std::size_t s) {
    return light_cut(f.frame.world, f.frame.receivers, f.slices.rows(s), f.frame.lights, f.tree, f.params.cut);
  };
}

}  // namespace

MethodResult render_slices(const FrameView& frame, const MethodParams& params, const SliceMethod& method,
                           Progress& progress, RenderStats& stats) {
  // Rows and columns are grouped first: both depend only on where things are, not on who sees whom.
  Stopwatch wall;
  progress.stage("clusters", 0, "");
  const Slices slices = make_slices(frame.receivers, frame.scene_radius, params.slices);
  const LightTree tree = build_light_tree(frame.world, frame.lights, frame.scene_radius, params.tree);
  stats.time_s["cluster"] += wall.lap();

  // Which lights stand for all, slice by slice; methods may look at the whole frame first.
  const MethodParams chosen = with_chosen_clusters(frame, params, slices, tree, progress, stats);
  const SliceFrame grouped{frame, chosen, slices, tree};
  SliceLoop loop(frame, chosen, method, slices, tree, method.columns ? method.columns(grouped) : by_light_cut(grouped));
  wall.lap();
  progress.stage("slices", slices.size(), "slices");
  if (method.guard > 0 || method.block_energies) loop.run_pilot(progress);
  loop.run(progress);
  loop.add_to_stats(wall.lap(), stats);
  return std::move(loop.result);
}

namespace {

SliceLoop::SliceLoop(const FrameView& frame, const MethodParams& params, const SliceMethod& method,
                     const Slices& slices, const LightTree& tree, ChooseColumns choose_columns)
    : frame_(frame),
      params_(params),
      method_(method),
      slices_(slices),
      tree_(tree),
      choose_columns_(std::move(choose_columns)),
      reports_(slices.size()) {
  const std::size_t n = frame.receivers.size();
  result.radiance.resize(n);
  result.slice.resize(n);
  result.cut_size.resize(n);
  result.visibility_fraction.resize(n);
}

void SliceLoop::run_pilot(Progress& progress) {
  const std::size_t n = slices_.size();
  if (n < kLeastSlices) return;
  first_pilot_ = std::min(n, kPilotStride) / 2;
  pilot_.resize((n - first_pilot_ + kPilotStride - 1) / kPilotStride);
  const auto trace_whole = [](EntrySource& source, Rng&, BitMatrix& visible) { return trace_all(source, visible); };
  parallel_for(pilot_.size(), [&](std::size_t k) {
    render(first_pilot_ + k * kPilotStride, trace_whole, pilot_[k]);
    progress.advance(1);
  });

  double sum = 0, n_rows = 0;
  for (std::size_t k = 0; k < pilot_.size(); ++k)
    for (const ReceiverId i : slices_.rows(first_pilot_ + k * kPilotStride)) {
      sum += luminance(frame_.receivers.beta[index(i)] * result.radiance[index(i)]);
      n_rows += 1;
    }
  mean_radiance_ = static_cast<float>(sum / n_rows);
  guess_limit_ = method_.guard * mean_radiance_;
}

void SliceLoop::run(Progress& progress) {
  parallel_for(slices_.size(), [&](std::size_t s) {
    if (in_pilot(s)) return check_completion(s, pilot_[s / kPilotStride]);
    BitMatrix visible;
    render(s, method_.complete, visible);
    progress.advance(1);
  });
}

/// One slice from its cut to its radiance; `visible` is set.
void SliceLoop::render(std::size_t s, const CompleteSlice& complete, BitMatrix& visible) {
  SliceReport& report = reports_[s];
  const std::span<const ReceiverId> rows = slices_.rows(s);
  ThreadStopwatch cpu;
  const std::vector<Column> columns = choose_columns_(s);
  report.cut_s = cpu.lap();

  SliceVisibility source(frame_.world, frame_.receivers, rows, frame_.lights, columns, method_.cull);
  visible = BitMatrix(rows.size(), columns.size());
  report.visibility_s = cpu.lap();
  prepare(s, columns, source);
  Rng rng = completion_rng(s);
  report.completion = complete(source, rng, visible);
  const double completion_s = cpu.lap();
  report.visibility_s += source.trace_seconds();
  report.complete_s = std::max(0.0, completion_s - source.trace_seconds());

  shade(s, columns, visible);
  report.shade_s = cpu.lap();
  report.rays = source.rays();
  report.columns = columns.size();
  report.memory_bytes = source.memory_bytes() + visible.n_words() * sizeof(std::uint64_t);
}

void SliceLoop::shade(std::size_t s, std::span<const Column> columns, const BitMatrix& visible) {
  const std::span<const ReceiverId> rows = slices_.rows(s);
  std::vector<Rgb> radiance(rows.size());
  reports_[s].shade = shade_slice(frame_.world, frame_.receivers, rows, frame_.lights, columns, visible,
                                  {.clamp_distance = params_.cut.clamp_distance}, radiance);
  const CompletionStats& completion = reports_[s].completion;
  const float fraction =
      completion.entries > 0 ? static_cast<float>(completion.traced) / static_cast<float>(completion.entries) : 0.0f;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::size_t i = index(rows[k]);
    result.radiance[i] = radiance[k];
    result.slice[i] = static_cast<std::uint32_t>(s);
    result.cut_size[i] = static_cast<float>(columns.size());
    result.visibility_fraction[i] = fraction;
  }
}

/// Tells the source what the method wants to know of columns and entries.
void SliceLoop::prepare(std::size_t s, std::span<const Column> columns, SliceVisibility& source) {
  if (method_.energies)
    source.set_energies(column_energies(frame_.world, frame_.receivers, slices_.rows(s), frame_.lights, columns,
                                        params_.cut.clamp_distance));
  if (method_.block_energies && mean_radiance_ > 0)
    source.set_block_energies(BlockEnergies(frame_.world, frame_.receivers, slices_.rows(s), frame_.lights, tree_,
                                            columns, params_.cut.clamp_distance, mean_radiance_));
  if (guess_limit_ <= 0) return;
  source.require(heavy_entries(frame_.world, frame_.receivers, slices_.rows(s), frame_.lights, tree_, columns,
                               source.active_matrix(), params_.cut.clamp_distance, guess_limit_));
}

/// The bits of a slice traced whole, in place of rays.
class TracedEntries final : public EntrySource {
 public:
  TracedEntries(const EntrySource& slice, const BitMatrix& truth) : slice_(slice), truth_(truth) {}
  std::size_t n_rows() const override { return slice_.n_rows(); }
  std::size_t n_columns() const override { return slice_.n_columns(); }
  Words active(std::size_t j) const override { return slice_.active(j); }
  Words required(std::size_t j) const override { return slice_.required(j); }
  float energy(std::size_t j) const override { return slice_.energy(j); }
  void block_energies(std::size_t j, std::span<float> energies) const override { slice_.block_energies(j, energies); }
  std::span<const RowPoint> row_points() const override { return slice_.row_points(); }
  std::size_t n_groups() const override { return slice_.n_groups(); }
  std::size_t group_end(std::size_t g) const override { return slice_.group_end(g); }
  void trace(std::size_t j, Words wanted, MutableWords visible) override {
    const Words truth = truth_.column(j);
    for (std::size_t w = 0; w < wanted.size(); ++w) visible[w] = (visible[w] & ~wanted[w]) | (truth[w] & wanted[w]);
  }

 private:
  const EntrySource& slice_;
  const BitMatrix& truth_;
};

void SliceLoop::check_completion(std::size_t s, const BitMatrix& truth) {
  SliceReport& report = reports_[s];
  ThreadStopwatch cpu;
  const std::vector<Column> columns = choose_columns_(s);
  SliceVisibility slice(frame_.world, frame_.receivers, slices_.rows(s), frame_.lights, columns, method_.cull);
  prepare(s, columns, slice);
  TracedEntries source(slice, truth);
  BitMatrix completed(truth.n_rows(), truth.n_columns());
  Rng rng = completion_rng(s);
  report.checked = method_.complete(source, rng, completed).entries;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const Words bits = std::as_const(completed).column(j), true_bits = truth.column(j);
    for (std::size_t w = 0; w < bits.size(); ++w) {
      report.false_visible += static_cast<std::uint64_t>(std::popcount(bits[w] & ~true_bits[w]));
      report.false_occluded += static_cast<std::uint64_t>(std::popcount(true_bits[w] & ~bits[w]));
    }
  }
  report.complete_s += cpu.lap();
}

/// Threads work on different stages at the same time: the loop's wall time is split in proportion to CPU time.
void SliceLoop::add_to_stats(double loop_wall_s, RenderStats& stats) const {
  SliceReport sum;
  double radiance = 0, clamped_away = 0;
  for (const SliceReport& s : reports_) {
    sum.completion += s.completion;
    sum.rays += s.rays, sum.columns += s.columns;
    sum.checked += s.checked, sum.false_visible += s.false_visible, sum.false_occluded += s.false_occluded;
    sum.memory_bytes = std::max(sum.memory_bytes, s.memory_bytes);
    sum.cut_s += s.cut_s, sum.visibility_s += s.visibility_s, sum.complete_s += s.complete_s, sum.shade_s += s.shade_s;
    radiance += s.shade.radiance_sum, clamped_away += s.shade.clamped_away_sum;
  }
  for (const BitMatrix& bits : pilot_) sum.memory_bytes += bits.n_words() * sizeof(std::uint64_t);
  const double cpu_s = sum.cut_s + sum.visibility_s + sum.complete_s + sum.shade_s;
  const double scale = cpu_s > 0 ? loop_wall_s / cpu_s : 0;
  stats.time_s["cluster"] += scale * sum.cut_s;
  stats.time_s["visibility"] += scale * sum.visibility_s;
  stats.time_s["complete"] += scale * sum.complete_s;
  stats.time_s["shade"] += scale * sum.shade_s;
  RenderStats::Visibility& v = stats.visibility;
  v.entries += sum.completion.entries, v.traced += sum.completion.traced;
  v.fully_sampled_columns += sum.completion.full_columns;
  v.verified_columns += sum.completion.verified_columns;
  v.checked += sum.checked, v.false_visible += sum.false_visible, v.false_occluded += sum.false_occluded;
  stats.rays.shadow += sum.rays;
  const std::size_t n = reports_.size();
  stats.slices += n;
  stats.memory.slices_peak = std::max(stats.memory.slices_peak, sum.memory_bytes);
  // Means over passes: each pass adds its own share, the pipeline divides.
  if (n > 0) stats.clusters_mean += static_cast<double>(sum.columns) / static_cast<double>(n);
  stats.clamped_energy_fraction += radiance + clamped_away > 0 ? clamped_away / (radiance + clamped_away) : 0;
}

}  // namespace
}  // namespace myrialux
