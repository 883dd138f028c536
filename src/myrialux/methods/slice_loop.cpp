// Cuts, traces, completes and shades one slice after another, and adds up what they report.
#include "myrialux/methods/slice_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/shading/shade.h"
#include "myrialux/visibility/column_energies.h"
#include "myrialux/visibility/heavy_entries.h"

namespace myrialux {
namespace {

/// A slice whose estimated error is above this many times the frame's limit is completed again with less slack: errors
/// of slices differ, and a slice's estimate hangs on a few wrong rays, of which there must be some.
constexpr double kRedoneAbove = 3;
constexpr std::uint64_t kLeastWrongRays = 16;
constexpr float kRedoneSlack = 0.25f;

/// Of eight slices the first one, two, four and all are completed before the slack follows the meter.
constexpr std::array<std::size_t, 4> kBatchEnds = {1, 2, 4, 8};

/// The whole frame is completed again so often at most, where its error is above this many times the limit.
constexpr int kMostRounds = 2;
constexpr double kTightenedAbove = 2;

/// Fewer slices do not tell by their scatter how sure their mean is.
constexpr std::uint64_t kLeastMetered = 16;

/// The slack changes by no more than these factors at once: slices that seem good may only have been lucky.
constexpr double kLargestStep = 1.0 / 16, kLargestRise = 1.5;

}  // namespace

void SliceReport::add_cost_of(const SliceReport& before) {
  completion.traced += before.completion.traced;
  rays += before.rays;
  meter.more_rays += before.meter.rays + before.meter.more_rays;
  redone |= before.columns > 0;
  mean_rays = before.mean_rays, mean_s = before.mean_s;
  cut_s += before.cut_s, visibility_s += before.visibility_s, complete_s += before.complete_s,
      shade_s += before.shade_s;
}

SliceLoop::SliceLoop(const FrameView& frame, const MethodParams& params, const SliceMethod& method,
                     const Slices& slices, const LightTree& tree, ChooseColumns choose_columns)
    : frame_(frame),
      params_(params),
      method_(method),
      slices_(slices),
      tree_(tree),
      choose_columns_(std::move(choose_columns)),
      reports_(slices.size()),
      slack_(method.largest_error > 0 ? 1.0f : 0.0f) {
  const std::size_t n = frame.receivers.size();
  result.radiance.resize(n);
  result.slice.resize(n);
  result.cut_size.resize(n);
  result.visibility_fraction.resize(n);
}

void SliceLoop::run(Progress& progress) {
  if (!has_meter()) slack_ = 0;  // without a pilot, or where it is black, nobody knows what copies would do
  // Where no slack is small enough all is traced, and the error is known to be 0.
  if (has_meter()) result.visibility_error.resize(frame_.receivers.size());
  if (!has_meter() || slack_ <= 0) return render_some(0, kBatchEnds.back(), progress);
  std::size_t begin = 0;
  for (const std::size_t end : kBatchEnds) {
    render_some(begin, end, progress);
    begin = end;
    if (end < kBatchEnds.back()) follow_meter();
  }
  for (int round = 0; round < kMostRounds && tighten(); ++round) {
    progress.stage("slices, with less copied", slices_.size() - pilot_.size(), "slices");
    render_some(0, kBatchEnds.back(), progress);
  }
}

/// Slices s with s % 8 in [begin, end).
void SliceLoop::render_some(std::size_t begin, std::size_t end, Progress& progress) {
  parallel_for(slices_.size(), [&](std::size_t s) {
    const std::size_t at = s % kBatchEnds.back();
    if (in_pilot(s) || at < begin || at >= end) return;
    const SliceReport before = std::exchange(reports_[s], {});
    render(s);
    reports_[s].add_cost_of(before);
    progress.advance(1);
  });
}

/// The slack for the slices to come, from what the meter is sure of in those before. The pilot's slices are few, and
/// where few pixels make most of the error, others can err twice as much or half. Errors grow at least with the root of
/// the slack (docs/visibility.md).
void SliceLoop::follow_meter() {
  const RenderStats::Visibility::Meter meter = meter_of_frame(false);
  if (meter.slices < kLeastMetered) return;
  const MeterErrors errors = meter_errors(meter);
  const double limit = static_cast<double>(method_.largest_error);
  const auto [low, high] = errors.error_interval;
  const double ratio = low > limit ? limit / errors.error : high > 0 && high < limit ? limit / high : 1;
  if (ratio == 1) return;
  const double step = std::clamp(ratio * ratio, kLargestStep, kLargestRise);
  slack_ = std::clamp(static_cast<float>(on_scale(static_cast<double>(slack_) * step)), kLeastSlack, kLargestSlack);
}

/// Sets less slack if even the low end of the frame's error is above twice its limit, as can be in small frames.
bool SliceLoop::tighten() {
  if (!has_meter() || slack_ <= 0) return false;
  const MeterErrors errors = meter_errors(meter_of_frame());
  const double limit = static_cast<double>(method_.largest_error);
  if (errors.error_interval.low <= kTightenedAbove * limit) return false;
  const double step = limit / errors.error;
  const auto tighter = static_cast<float>(on_scale(static_cast<double>(slack_) * std::max(kLargestStep, step * step)));
  slack_ = slack_ > kLeastSlack ? std::max(tighter, kLeastSlack) : 0.0f;
  return true;
}

/// One slice from its cut to its radiance.
void SliceLoop::render(std::size_t s) {
  SliceReport& report = reports_[s];
  const std::span<const ReceiverId> rows = slices_.rows(s);
  ThreadStopwatch cpu;
  const std::vector<Column> columns = choose_columns_(s);
  report.cut_s = cpu.lap();

  SliceVisibility source(frame_.world, frame_.receivers, rows, frame_.lights, columns, method_.cull);
  BitMatrix visible(rows.size(), columns.size());
  report.visibility_s = cpu.lap();
  prepare(s, columns, source);
  complete(s, columns, source, visible);
  const double completion_s = cpu.lap();
  report.visibility_s += source.trace_seconds();
  report.complete_s = std::max(0.0, completion_s - source.trace_seconds());

  shade(s, columns, visible);
  report.shade_s = cpu.lap();
  report.rays = source.rays() + report.meter.rays + report.meter.more_rays;
  report.columns = columns.size();
  report.memory_bytes += source.memory_bytes() + visible.n_words() * sizeof(std::uint64_t);
}

CompletionStats SliceLoop::complete_with(EntrySource& source, std::size_t s, float slack, BitMatrix& visible,
                                         BlockDoubts* doubts) const {
  Rng rng(params_.key, Stage::visibility, s);
  if (!method_.complete_within) return method_.complete(source, rng, visible);
  return slack > 0 ? method_.complete_within(source, rng, visible, slack, doubts) : trace_all(source, visible);
}

/// Completes, looks how wrong it went, and does it again where that is too much.
void SliceLoop::complete(std::size_t s, std::span<const Column> columns, SliceVisibility& source, BitMatrix& visible) {
  SliceReport& report = reports_[s];
  const bool is_measured = has_meter() && slack_ > 0;
  if (!is_measured) {
    report.completion = complete_with(source, s, slack_, visible, nullptr);
    return;
  }
  report.slack = slack_;
  BlockDoubts doubts(visible.n_rows(), visible.n_columns());
  report.completion = complete_with(source, s, slack_, visible, &doubts);
  report.memory_bytes = doubts.memory_bytes();
  const CompletedSlice slice = completed_slice(s, columns, source, doubts);
  Rng rng(params_.key, Stage::error_meter, s);
  report.meter = measure_errors(slice, visible, rng);
  if (!is_redone(report.meter, slice.rows.size())) return;
  const std::uint64_t n_rays = report.meter.rays + report.meter.more_rays, n_traced = report.completion.traced;
  visible = BitMatrix(visible.n_rows(), visible.n_columns());
  doubts = BlockDoubts(visible.n_rows(), visible.n_columns());
  report.completion = complete_with(source, s, kRedoneSlack * slack_, visible, &doubts);
  report.completion.traced += n_traced;
  report.meter = measure_errors(slice, visible, rng);
  report.meter.more_rays += n_rays;
  report.redone = true;
}

CompletedSlice SliceLoop::completed_slice(std::size_t s, std::span<const Column> columns, const SliceVisibility& source,
                                          const BlockDoubts& doubts) const {
  return {.world = frame_.world,
          .receivers = frame_.receivers,
          .rows = slices_.rows(s),
          .lights = frame_.lights,
          .columns = columns,
          .energies = *source.known_block_energies(),
          .doubts = doubts,
          .active = source.active_matrix(),
          .clamp_distance = params_.cut.clamp_distance,
          .unit = mean_radiance_,
          .spp = static_cast<std::uint32_t>(frame_.spp)};
}

bool SliceLoop::is_redone(const MeterReading& meter, std::size_t n_rows) const {
  if (meter.wrong_by_energy < kLeastWrongRays) return false;
  const double limit = kRedoneAbove * static_cast<double>(method_.largest_error);
  return mean_square(meter.squares, static_cast<double>(n_rows)) > limit * limit;
}

/// Tells the source what the method wants to know of columns and entries.
void SliceLoop::prepare(std::size_t s, std::span<const Column> columns, SliceVisibility& source) const {
  if (method_.energies)
    source.set_energies(column_energies(frame_.world, frame_.receivers, slices_.rows(s), frame_.lights, columns,
                                        params_.cut.clamp_distance));
  if (has_meter() && slack_ > 0)
    source.set_block_energies(BlockEnergies(frame_.world, frame_.receivers, slices_.rows(s), frame_.lights, tree_,
                                            columns, params_.cut.clamp_distance, mean_radiance_));
  if (guess_limit_ <= 0) return;
  source.require(heavy_entries(frame_.world, frame_.receivers, slices_.rows(s), frame_.lights, tree_, columns,
                               source.active_matrix(), params_.cut.clamp_distance, guess_limit_));
}

void SliceLoop::shade(std::size_t s, std::span<const Column> columns, const BitMatrix& visible) {
  std::vector<Rgb> radiance(slices_.rows(s).size());
  const ShadeResult sums = shade_slice(frame_.world, frame_.receivers, slices_.rows(s), frame_.lights, columns, visible,
                                       {.clamp_distance = params_.cut.clamp_distance}, radiance);
  reports_[s].radiance_sum = sums.radiance_sum, reports_[s].clamped_away_sum = sums.clamped_away_sum;
  store(s, columns.size(), radiance);
}

void SliceLoop::store(std::size_t s, std::size_t n_columns, std::span<const Rgb> radiance) {
  const std::span<const ReceiverId> rows = slices_.rows(s);
  SliceReport& report = reports_[s];
  const CompletionStats& c = report.completion;
  const float fraction = c.entries > 0 ? static_cast<float>(c.traced) / static_cast<float>(c.entries) : 0.0f;
  const double square = mean_square(report.meter.squares, static_cast<double>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::size_t i = index(rows[k]);
    result.radiance[i] = radiance[k];
    report.luminance_sum += static_cast<double>(luminance(frame_.receivers.beta[i] * radiance[k]));
    result.slice[i] = static_cast<std::uint32_t>(s);
    result.cut_size[i] = static_cast<float>(n_columns);
    result.visibility_fraction[i] = fraction;
    if (!result.visibility_error.empty())
      result.visibility_error[i] = static_cast<float>(std::sqrt(std::max(0.0, square)));
  }
}

void SliceLoop::finish(double loop_wall_s, RenderStats& stats, RenderStats::Visibility::Meter& meter) {
  SliceReport sum;
  for (const SliceReport& s : reports_) {
    sum.completion += s.completion;
    sum.rays += s.rays + s.mean_rays, sum.columns += s.columns;
    sum.checked += s.checked, sum.false_visible += s.false_visible, sum.false_occluded += s.false_occluded;
    sum.memory_bytes = std::max({sum.memory_bytes, s.memory_bytes, pilot_bytes_});
    sum.cut_s += s.cut_s, sum.visibility_s += s.visibility_s, sum.complete_s += s.complete_s + s.mean_s,
        sum.shade_s += s.shade_s;
    sum.radiance_sum += s.radiance_sum, sum.clamped_away_sum += s.clamped_away_sum;
  }
  const double cpu_s = sum.cut_s + sum.visibility_s + sum.complete_s + sum.shade_s;
  const double scale = cpu_s > 0 ? loop_wall_s / cpu_s : 0;
  stats.time_s["cluster"] += scale * sum.cut_s;
  stats.time_s["visibility"] += scale * sum.visibility_s;
  stats.time_s["complete"] += scale * sum.complete_s;
  stats.time_s["shade"] += scale * sum.shade_s;
  stats.cpu_s["cluster"] += sum.cut_s, stats.cpu_s["visibility"] += sum.visibility_s;
  stats.cpu_s["complete"] += sum.complete_s, stats.cpu_s["shade"] += sum.shade_s;
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
  const double radiance = sum.radiance_sum + sum.clamped_away_sum;
  stats.clamped_energy_fraction += radiance > 0 ? sum.clamped_away_sum / radiance : 0;
  if (!has_meter()) return;
  meter = meter_of_frame();
  v.meter += meter;
  if (meter.mean_radiance <= 0) return;
  const float unit = mean_radiance_ / static_cast<float>(meter.mean_radiance);
  for (float& error : result.visibility_error) error *= unit;
}

/// Mean radiance from virtual lights as the slices tell that are shaded.
double SliceLoop::mean_of_frame() const {
  double sum = 0, n_rows = 0;
  for (std::size_t s = 0; s < reports_.size(); ++s) {
    if (reports_[s].columns == 0) continue;
    sum += reports_[s].luminance_sum, n_rows += static_cast<double>(slices_.rows(s).size());
  }
  return n_rows > 0 ? sum / (samples_per_row() * n_rows) : 0;
}

/// Squares and bias are sums over slices, whose scatter tells how sure they are.
/// @param with_other_slack false: only of slices completed with the slack at hand
RenderStats::Visibility::Meter SliceLoop::meter_of_frame(bool with_other_slack) const {
  RenderStats::Visibility::Meter meter;
  const double frame_mean = mean_of_frame(),
               unit = frame_mean > 0 ? static_cast<double>(mean_radiance_) / frame_mean : 1;
  double squares = 0, squares2 = 0, squares3 = 0, bias = 0, bias2 = 0, n_rows = 0, n = 0;
  for (std::size_t s = 0; s < reports_.size(); ++s) {
    const SliceReport& r = reports_[s];
    if (!with_other_slack && r.slack != slack_) continue;
    meter.rays += r.meter.rays;
    meter.more_rays += r.meter.more_rays + r.mean_rays;
    meter.wrong += r.meter.false_visible + r.meter.false_occluded;
    meter.redone_slices += r.redone ? 1 : 0;
    squares += r.meter.squares, squares2 += r.meter.squares * r.meter.squares;
    squares3 += r.meter.squares * r.meter.squares * r.meter.squares;
    bias += r.meter.bias, bias2 += r.meter.bias * r.meter.bias;
    n_rows += static_cast<double>(slices_.rows(s).size()), ++n;
  }
  if (n == 0) return meter;
  const double scale = mean_square(unit * unit, n_rows);
  meter.slices = static_cast<std::uint64_t>(n);
  meter.error_square = scale * squares;
  meter.error_square_variance = scale * scale * std::max(0.0, squares2 - squares * squares / n);
  const double mean = squares / n;
  meter.error_square_third = scale * scale * scale * (squares3 - 3 * mean * squares2 + 2 * mean * mean * squares);
  meter.bias = unit * bias / (n_rows * samples_per_row());
  meter.bias_variance = unit * unit * std::max(0.0, bias2 - bias * bias / n) / std::pow(n_rows * samples_per_row(), 2);
  meter.mean_radiance = frame_mean;
  meter.slack = static_cast<double>(slack_);
  meter.pilot_error = pilot_error_;
  return meter;
}

}  // namespace myrialux
