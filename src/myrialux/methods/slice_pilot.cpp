// The pilot: some slices traced whole tell the frame's mean radiance, how far completion may go, and how wrong it is.
#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/kernels/shadow_ends.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/methods/slice_loop.h"
#include "myrialux/shading/shade.h"
#include "myrialux/visibility/traced_entries.h"

namespace myrialux {
namespace {

/// For the mean radiance: so many slices, but one of so many at most.
constexpr std::size_t kMeanSlices = 256, kMeanStride = 8;

}  // namespace

double on_scale(double x) { return x > 0 ? std::exp2(std::round(std::log2(x) * 64) / 64) : 0; }

std::size_t pilot_stride(std::size_t n_slices) { return std::max<std::size_t>(kPilotStride, n_slices / kPilotSlices); }

std::uint64_t PilotSlice::memory_bytes() const {
  return (source ? source->memory_bytes() : 0) + truth.n_words() * sizeof(std::uint64_t) +
         columns.size() * sizeof(Column) + radiance.size() * sizeof(Rgb);
}

void SliceLoop::run_pilot(Progress& progress) {
  const std::size_t n = slices_.size();
  if (n < kLeastSlices) return;
  pilot_stride_ = pilot_stride(n);
  first_pilot_ = std::min(n, pilot_stride_) / 2;
  pilot_.resize((n - first_pilot_ + pilot_stride_ - 1) / pilot_stride_);
  parallel_for(pilot_.size(), [&](std::size_t k) {
    render_pilot(k);
    progress.advance(1);
  });

  double sum = 0, n_rows = 0;
  for (std::size_t k = 0; k < pilot_.size(); ++k) {
    const std::span<const ReceiverId> rows = slices_.rows(pilot_slice(k));
    for (std::size_t r = 0; r < rows.size(); ++r)
      sum += luminance(frame_.receivers.beta[index(rows[r])] * pilot_[k].radiance[r]), n_rows += 1;
  }
  const double mean = method_.complete_within ? mean_of_slices(sum / n_rows) / samples_per_row() : sum / n_rows;
  mean_radiance_ = static_cast<float>(on_scale(mean));
  guess_limit_ = method_.guard * mean_radiance_;

  parallel_for(pilot_.size(), [&](std::size_t k) {
    ThreadStopwatch cpu;
    prepare(pilot_slice(k), pilot_[k].columns, *pilot_[k].source);
    reports_[pilot_slice(k)].complete_s += cpu.lap();
  });
  if (has_meter()) choose_slack();
  check_pilot();
  for (PilotSlice& slice : pilot_) {
    pilot_bytes_ += slice.memory_bytes();
    slice = {};
  }
}

/// The pilot's slices are few and differ much: a block of rows in each of many more slices tells the frame's mean
/// better.
/// @param pilot_mean mean radiance of the pilot's rows
double SliceLoop::mean_of_slices(double pilot_mean) {
  const std::size_t n = std::min(kMeanSlices, slices_.size() / kMeanStride);
  std::vector<double> means(n);
  parallel_for(n, [&](std::size_t m) {
    const std::size_t s = (2 * m + 1) * slices_.size() / (2 * n);
    SliceReport& report = reports_[s];
    ThreadStopwatch cpu;
    const std::vector<Column> columns = choose_columns_(s);
    const std::span<const ReceiverId> all = slices_.rows(s);
    const std::size_t first = all.size() / 2 / kPacketRows * kPacketRows;
    const std::span<const ReceiverId> rows = all.subspan(first, std::min(kPacketRows, all.size() - first));
    SliceVisibility source(frame_.world, frame_.receivers, rows, frame_.lights, columns, method_.cull);
    BitMatrix visible(rows.size(), columns.size());
    trace_all(source, visible);
    std::vector<Rgb> radiance(rows.size());
    shade_slice(frame_.world, frame_.receivers, rows, frame_.lights, columns, visible,
                {.clamp_distance = params_.cut.clamp_distance}, radiance);
    for (std::size_t r = 0; r < rows.size(); ++r)
      means[m] += static_cast<double>(luminance(frame_.receivers.beta[index(rows[r])] * radiance[r])) /
                  static_cast<double>(rows.size());
    report.mean_rays = source.rays();
    report.mean_s = cpu.lap();
  });
  double sum = pilot_mean * static_cast<double>(pilot_.size());
  for (const double mean : means) sum += mean;
  return sum / static_cast<double>(pilot_.size() + n);
}

void SliceLoop::render_pilot(std::size_t k) {
  const std::size_t s = pilot_slice(k);
  SliceReport& report = reports_[s];
  PilotSlice& slice = pilot_[k];
  const std::span<const ReceiverId> rows = slices_.rows(s);
  ThreadStopwatch cpu;
  slice.columns = choose_columns_(s);
  report.cut_s = cpu.lap();
  slice.source = std::make_unique<SliceVisibility>(frame_.world, frame_.receivers, rows, frame_.lights, slice.columns,
                                                   method_.cull);
  slice.truth = BitMatrix(rows.size(), slice.columns.size());
  report.completion = trace_all(*slice.source, slice.truth);
  report.visibility_s = cpu.lap();
  shade(s, slice.columns, slice.truth);
  for (const ReceiverId i : rows) slice.radiance.push_back(result.radiance[index(i)]);
  report.shade_s = cpu.lap();
  report.rays = slice.source->rays();
  report.columns = slice.columns.size();
}

/// Sum over the pixels that rows belong to of squared differences of luminance, as far as these rows make them.
double SliceLoop::pixel_squares(std::span<const ReceiverId> rows, std::span<const Rgb> truth,
                                std::span<const Rgb> other) const {
  std::vector<std::pair<std::uint32_t, float>> differences;
  differences.reserve(rows.size());
  const auto spp = static_cast<std::uint32_t>(frame_.spp);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::size_t i = index(rows[r]);
    differences.push_back({frame_.receivers.sample[i] / spp, luminance(frame_.receivers.beta[i] * other[r]) -
                                                                 luminance(frame_.receivers.beta[i] * truth[r])});
  }
  std::sort(differences.begin(), differences.end());
  double squares = 0;
  for (std::size_t r = 0; r < differences.size();) {
    const std::uint32_t pixel = differences[r].first;
    double sum = 0;
    for (; r < differences.size() && differences[r].first == pixel; ++r)
      sum += static_cast<double>(differences[r].second);
    squares += sum * sum;
  }
  return squares / (static_cast<double>(spp) * static_cast<double>(spp));
}

/// Mean square over pixels, over the squared mean radiance, that completion with this slack adds to the pilot.
double SliceLoop::pilot_square(float slack) {
  std::vector<double> squares(pilot_.size());
  double n_pixels = 0;
  for (std::size_t k = 0; k < pilot_.size(); ++k)
    n_pixels += static_cast<double>(slices_.rows(pilot_slice(k)).size()) * samples_per_row() / frame_.spp;
  parallel_for(pilot_.size(), [&](std::size_t k) {
    const PilotSlice& slice = pilot_[k];
    const std::size_t s = pilot_slice(k);
    ThreadStopwatch cpu;
    TracedEntries source(*slice.source, slice.truth);
    BitMatrix completed(slice.truth.n_rows(), slice.truth.n_columns());
    complete_with(source, s, slack, completed, nullptr);
    std::vector<Rgb> radiance(slice.radiance.size());
    shade_slice(frame_.world, frame_.receivers, slices_.rows(s), frame_.lights, slice.columns, completed,
                {.clamp_distance = params_.cut.clamp_distance}, radiance);
    squares[k] = pixel_squares(slices_.rows(s), slice.radiance, radiance);
    reports_[s].complete_s += cpu.lap();
  });
  double sum = 0;
  for (const double square : squares) sum += square;
  return sum / (n_pixels * static_cast<double>(mean_radiance_) * static_cast<double>(mean_radiance_));
}

/// The largest slack whose error stays within the limit, between two of a factor 2 by a straight line in logarithms.
void SliceLoop::choose_slack() {
  const double limit = static_cast<double>(method_.largest_error);
  double good = 0, good_error = 0, bad = 0, bad_error = 0;  // 0: none yet
  for (float slack = 1;;) {
    const double error = std::sqrt(pilot_square(slack));
    const bool is_good = error <= limit;
    (is_good ? good : bad) = static_cast<double>(slack);
    (is_good ? good_error : bad_error) = error;
    if ((good > 0 && bad > 0) || (is_good && slack >= kLargestSlack) || (!is_good && slack <= kLeastSlack)) break;
    slack *= is_good ? 2.0f : 0.5f;
  }
  double slack = good;
  if (good > 0 && bad > 0 && good_error > 0 && bad_error > good_error)
    slack = on_scale(slack * std::pow(bad / good, std::log(limit / good_error) / std::log(bad_error / good_error)));
  // Errors scatter: what lies between the two may err more than the better one.
  const double error = slack > good ? std::sqrt(pilot_square(static_cast<float>(slack))) : good_error;
  slack_ = static_cast<float>(error <= limit ? slack : good);
  pilot_error_ = error <= limit ? error : good_error;
}

/// Completes the pilot's slices as all others will be, only to see what goes wrong.
void SliceLoop::check_pilot() {
  parallel_for(pilot_.size(), [&](std::size_t k) {
    const PilotSlice& slice = pilot_[k];
    const std::size_t s = pilot_slice(k);
    SliceReport& report = reports_[s];
    ThreadStopwatch cpu;
    TracedEntries source(*slice.source, slice.truth);
    BitMatrix completed(slice.truth.n_rows(), slice.truth.n_columns());
    report.checked = complete_with(source, s, slack_, completed, nullptr).entries;
    for (std::size_t j = 0; j < slice.columns.size(); ++j) {
      const Words bits = std::as_const(completed).column(j), true_bits = slice.truth.column(j);
      for (std::size_t w = 0; w < bits.size(); ++w) {
        report.false_visible += static_cast<std::uint64_t>(std::popcount(bits[w] & ~true_bits[w]));
        report.false_occluded += static_cast<std::uint64_t>(std::popcount(true_bits[w] & ~bits[w]));
      }
    }
    report.complete_s += cpu.lap();
  });
}

}  // namespace myrialux
