// Entries are drawn evenly, by rejection, and by energy and doubt of their blocks; only wrong ones need their transfer.
#include "myrialux/visibility/error_meter.h"

#include <algorithm>
#include <cmath>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/shadow_ends.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/transfer/transfer.h"

namespace myrialux {
namespace {

/// Columns drawn in proportion to what wrong bits of a block of rows may come to: its energy times the root of its
/// doubt, which has the least variance where doubts are right. Some are drawn evenly, as bounds of blocks can be loose
/// by far and doubts too small, and an error found against all odds would count for too much.
class EntryDraw {
 public:
  EntryDraw(const BlockEnergies& energies, const BlockDoubts& doubts);
  /// False: all entries of the row are known or bring nothing.
  bool any(std::size_t row) const { return sum(row / kPacketRows, n_runs_) > 0; }
  /// @param u in [0, 1)
  std::size_t column(std::size_t row, float u) const;
  double probability(std::size_t row, std::size_t j) const;

 private:
  static constexpr float kEvenShare = 0.25f;
  /// So many columns lie between two sums that are kept.
  static constexpr std::size_t kRun = 8;

  /// Added to doubts of blocks that are not traced whole: small ones are not known well.
  static constexpr float kLeastDoubt = 0.01f;

  float weight(std::size_t b, std::size_t j) const {
    const float doubt = doubts_(b, j);
    return energies_.of(j, b) * std::sqrt(doubt + (doubt > 0 ? kLeastDoubt : 0));
  }
  /// Of block b in the first n runs of columns.
  float sum(std::size_t b, std::size_t n) const { return sums_[n * energies_.n_blocks() + b]; }

  const BlockEnergies& energies_;
  const BlockDoubts& doubts_;
  std::size_t n_columns_, n_runs_;
  std::vector<float> sums_;  ///< [(runs + 1) x blocks]
};

EntryDraw::EntryDraw(const BlockEnergies& energies, const BlockDoubts& doubts)
    : energies_(energies), doubts_(doubts), n_columns_(energies.n_columns()), n_runs_((n_columns_ + kRun - 1) / kRun) {
  const std::size_t n_blocks = energies.n_blocks();
  std::vector<float> all(n_blocks);
  sums_.resize((n_runs_ + 1) * n_blocks);
  for (std::size_t j = 0; j < n_columns_; ++j) {
    for (std::size_t b = 0; b < n_blocks; ++b) all[b] += weight(b, j);
    if (j % kRun == kRun - 1 || j == n_columns_ - 1)
      std::copy(all.begin(), all.end(), sums_.begin() + static_cast<std::ptrdiff_t>((j / kRun + 1) * n_blocks));
  }
}

std::size_t EntryDraw::column(std::size_t row, float u) const {
  if (u < kEvenShare)
    return std::min(static_cast<std::size_t>(u / kEvenShare * static_cast<float>(n_columns_)), n_columns_ - 1);
  const std::size_t b = row / kPacketRows;
  float at = (u - kEvenShare) / (1 - kEvenShare) * sum(b, n_runs_);
  std::size_t run = 0, end = n_runs_ - 1;  // the last one whose sum before it is at most `at`
  while (run < end) {
    const std::size_t middle = (run + end + 1) / 2;
    if (sum(b, middle) > at)
      end = middle - 1;
    else
      run = middle;
  }
  at -= sum(b, run);
  const std::size_t last = std::min((run + 1) * kRun, n_columns_) - 1;
  for (std::size_t j = run * kRun; j < last; ++j) {
    at -= weight(b, j);
    if (at < 0) return j;
  }
  return last;
}

double EntryDraw::probability(std::size_t row, std::size_t j) const {
  constexpr double even = static_cast<double>(kEvenShare);
  const std::size_t b = row / kPacketRows;
  return even / static_cast<double>(n_columns_) +
         (1 - even) * static_cast<double>(weight(b, j)) / static_cast<double>(sum(b, n_runs_));
}

class Meter {
 public:
  Meter(const CompletedSlice& slice, const BitMatrix& visible, Rng& rng)
      : s_(slice),
        visible_(visible),
        rng_(rng),
        draw_(slice.energies, slice.doubts),
        has_active_(slice.active.words_per_column()) {
    for (std::size_t j = 0; j < slice.active.n_columns(); ++j)
      for (std::size_t w = 0; w < has_active_.size(); ++w) has_active_[w] |= slice.active.column(j)[w];
  }
  MeterReading read();

 private:
  void look_evenly(std::size_t row);
  void look_by_energy(std::size_t row);
  bool is_wrong(std::size_t row, std::size_t j) const;
  double error(std::size_t row, std::size_t j) const;
  double draw_error(std::size_t row, std::size_t known_row, std::size_t known_column);
  double follow(std::size_t row, std::size_t j);
  std::uint32_t pixel(std::size_t row) const { return s_.receivers.sample[index(s_.rows[row])] / s_.spp; }
  std::span<const std::uint32_t> rows_of_pixel(std::size_t row);

  const CompletedSlice& s_;
  const BitMatrix& visible_;
  Rng& rng_;
  const EntryDraw draw_;
  std::vector<std::uint64_t> has_active_;  ///< bits of rows
  std::vector<std::uint32_t> by_pixel_;    ///< rows that have active entries, pixel by pixel; made when first needed
  MeterReading reading_;
};

MeterReading Meter::read() {
  const std::uint32_t first = rng_.below(kRowsByEnergy);
  for_each_bit(has_active_, [&](std::size_t row) {
    look_evenly(row);
    if (row % kRowsByEnergy == first) look_by_energy(row);
  });
  return reading_;
}

void Meter::look_evenly(std::size_t row) {
  const auto n_columns = static_cast<std::uint32_t>(s_.columns.size());
  std::size_t j = rng_.below(n_columns);
  while (!s_.active.test(row, j)) j = rng_.below(n_columns);
  ++reading_.rays;
  if (is_wrong(row, j)) ++(visible_.test(row, j) ? reading_.false_visible : reading_.false_occluded);
}

void Meter::look_by_energy(std::size_t row) {
  if (!draw_.any(row)) return;
  const std::size_t j = draw_.column(row, rng_.next());
  if (!s_.active.test(row, j)) return;  // its error is 0
  ++reading_.more_rays;
  if (!is_wrong(row, j)) return;
  ++reading_.wrong_by_energy;
  const double e = kRowsByEnergy * error(row, j) / draw_.probability(row, j);
  reading_.bias += e;
  reading_.squares += e * follow(row, j);
}

bool Meter::is_wrong(std::size_t row, std::size_t j) const {
  const Segment segment = shadow_segment(s_.receivers, s_.rows[row], s_.lights, s_.columns[j].light);
  const bool occluded = segment.distant ? s_.world.tracer.occluded_direction(segment.from, segment.to)
                                        : s_.world.tracer.occluded(segment.from, segment.to);
  return visible_.test(row, j) == occluded;
}

/// What an entry that is wrong adds to its row.
double Meter::error(std::size_t row, std::size_t j) const {
  const ReceiverId i = s_.rows[row];
  const Rgb t = transfer(s_.world, s_.receivers, i, s_.lights, s_.columns[j].light, s_.clamp_distance);
  const float energy = s_.columns[j].weight * luminance(s_.receivers.beta[index(i)] * t) / s_.unit;
  return static_cast<double>(visible_.test(row, j) ? energy : -energy);
}

/// Estimates the error of a row by one entry, that of an entry known left out.
double Meter::draw_error(std::size_t row, std::size_t known_row, std::size_t known_column) {
  if (!draw_.any(row)) return 0;
  const std::size_t j = draw_.column(row, rng_.next());
  if (!s_.active.test(row, j) || (row == known_row && j == known_column)) return 0;
  ++reading_.more_rays;
  return is_wrong(row, j) ? error(row, j) / draw_.probability(row, j) : 0;
}

/// Estimates the error of the row's pixel. That of entry (row, j), found wrong, is known; all others are drawn, the
/// same number in each of the pixel's rows.
double Meter::follow(std::size_t row, std::size_t j) {
  const std::span<const std::uint32_t> rows = rows_of_pixel(row);
  const std::uint32_t n_rays = std::max(1u, kFollowingRays / static_cast<std::uint32_t>(rows.size()));
  double sum = 0;
  for (const std::uint32_t other : rows)
    for (std::uint32_t k = 0; k < n_rays; ++k) sum += draw_error(other, row, j);
  return error(row, j) + sum / n_rays;
}

std::span<const std::uint32_t> Meter::rows_of_pixel(std::size_t row) {
  const auto less = [&](std::uint32_t a, std::uint32_t b) { return pixel(a) < pixel(b); };
  if (by_pixel_.empty()) {
    for_each_bit(has_active_, [&](std::size_t r) { by_pixel_.push_back(static_cast<std::uint32_t>(r)); });
    std::stable_sort(by_pixel_.begin(), by_pixel_.end(), less);
  }
  const auto [begin, end] = std::equal_range(by_pixel_.begin(), by_pixel_.end(), static_cast<std::uint32_t>(row), less);
  return {begin, end};
}

}  // namespace

MeterReading measure_errors(const CompletedSlice& s, const BitMatrix& visible, Rng& rng) {
  MYRIALUX_ASSERT(visible.n_rows() == s.rows.size() && visible.n_columns() == s.columns.size());
  MYRIALUX_ASSERT(s.unit > 0 && s.spp > 0);
  return Meter(s, visible, rng).read();
}

}  // namespace myrialux
