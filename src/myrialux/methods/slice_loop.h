// One frame's slices, one after another: what the slice driver keeps while it runs.
#pragma once

#include <memory>

#include "myrialux/methods/slice_driver.h"
#include "myrialux/visibility/error_meter.h"

namespace myrialux {

/// What one slice leaves behind for the statistics.
struct SliceReport {
  CompletionStats completion;
  double radiance_sum = 0, clamped_away_sum = 0;
  double luminance_sum = 0;  ///< of the rows, beta included
  std::uint64_t rays = 0, columns = 0, memory_bytes = 0;
  std::uint64_t checked = 0, false_visible = 0, false_occluded = 0;  ///< entries; pilot only
  MeterReading meter;
  bool redone = false;
  float slack = 0;              ///< it was completed with, at first
  std::uint64_t mean_rays = 0;  ///< of a block of rows traced beforehand, for the frame's mean
  double mean_s = 0;            ///< CPU seconds of that
  double cut_s = 0, visibility_s = 0, complete_s = 0, shade_s = 0;  ///< CPU seconds

  /// What was done beforehand: for the frame's mean, or with a slack that was too large.
  void add_cost_of(const SliceReport& before);
};

/// The slack is looked for between these; where the least one is too large, all is traced (0).
inline constexpr float kLeastSlack = 1.0f / 64, kLargestSlack = 8;

/// The nearest number on a scale of 64 steps an octave; 0 for what is not positive. What decides which entries are
/// traced must not hang on how sums were rounded, which differs between instruction sets.
double on_scale(double x);

/// A slice of the pilot, traced whole.
struct PilotSlice {
  std::vector<Column> columns;
  std::unique_ptr<SliceVisibility> source;
  BitMatrix truth;
  std::vector<Rgb> radiance;
  std::uint64_t memory_bytes() const;
};

/// What the slices share, and what they leave behind. Slices are independent, so each thread takes one whole.
class SliceLoop {
 public:
  SliceLoop(const FrameView& frame, const MethodParams& params, const SliceMethod& method, const Slices& slices,
            const LightTree& tree, ChooseColumns choose_columns);

  /// Traces some slices whole; their mean radiance (complete_within: with that of rows of many more) sets the limit of
  /// what may be guessed in the others, and their errors set the slack.
  void run_pilot(Progress& progress);
  /// All other slices; the slack follows what the meter says of the first ones. All again, with less slack, where it is
  /// sure that they err far more than they may.
  void run(Progress& progress);
  /// Adds counters, and times in proportion to CPU time, as threads work on different stages
  /// at the same time.
  /// @param meter set to what this pass measured, if it did; also added to stats
  void finish(double loop_wall_s, RenderStats& stats, RenderStats::Visibility::Meter& meter);

  MethodResult result;

 private:
  void render_some(std::size_t begin, std::size_t end, Progress& progress);
  void follow_meter();
  void render(std::size_t s);
  bool tighten();
  void render_pilot(std::size_t k);
  double mean_of_slices(double pilot_mean);
  void complete(std::size_t s, std::span<const Column> columns, SliceVisibility& source, BitMatrix& visible);
  CompletionStats complete_with(EntrySource& source, std::size_t s, float slack, BitMatrix& visible,
                                BlockDoubts* doubts) const;
  CompletedSlice completed_slice(std::size_t s, std::span<const Column> columns, const SliceVisibility& source,
                                 const BlockDoubts& doubts) const;
  bool is_redone(const MeterReading& meter, std::size_t n_rows) const;
  void prepare(std::size_t s, std::span<const Column> columns, SliceVisibility& source) const;
  void shade(std::size_t s, std::span<const Column> columns, const BitMatrix& visible);
  void store(std::size_t s, std::size_t n_columns, std::span<const Rgb> radiance);

  void choose_slack();
  double pilot_square(float slack);
  void check_pilot();
  double pixel_squares(std::span<const ReceiverId> rows, std::span<const Rgb> truth, std::span<const Rgb> other) const;
  std::size_t pilot_slice(std::size_t k) const { return first_pilot_ + k * pilot_stride_; }
  bool in_pilot(std::size_t s) const { return !pilot_.empty() && s % pilot_stride_ == first_pilot_; }
  /// Mean over pixels, from the sum of their squares.
  double mean_square(double squares, double n_rows) const {
    return squares / (n_rows * samples_per_row() * frame_.spp);
  }
  /// Samples without a receiver are black.
  double samples_per_row() const {
    const std::size_t n_rows = std::max<std::size_t>(1, frame_.receivers.size());
    return static_cast<double>(std::max(n_rows, frame_.n_samples)) / static_cast<double>(n_rows);
  }
  bool has_meter() const { return method_.complete_within && mean_radiance_ > 0; }

  double mean_of_frame() const;
  RenderStats::Visibility::Meter meter_of_frame(bool with_other_slack = true) const;

  const FrameView& frame_;
  const MethodParams& params_;
  const SliceMethod& method_;
  const Slices& slices_;
  const LightTree& tree_;
  const ChooseColumns choose_columns_;
  std::vector<SliceReport> reports_;  ///< by slice
  std::vector<PilotSlice> pilot_;     ///< empty slices once the pilot is over
  std::size_t pilot_stride_ = 1, first_pilot_ = 0;
  std::uint64_t pilot_bytes_ = 0;
  /// Of the frame as the pilot tells, to a hundredth, beta included: of its pixels where completion keeps to an error,
  /// else of its receivers. 0: no pilot.
  float mean_radiance_ = 0;
  float guess_limit_ = 0;   ///< weight of an entry, radiance; 0: all may be guessed
  float slack_ = 1;         ///< of complete_within; 0: all is traced
  double pilot_error_ = 0;  ///< of the pilot with that slack: root mean square over pixels, over the mean radiance
};

}  // namespace myrialux
