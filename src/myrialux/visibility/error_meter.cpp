// Entries are drawn by rejection among a row's columns; only wrong ones need their transfer.
#include "myrialux/visibility/error_meter.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "myrialux/base/assert.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/transfer/transfer.h"

namespace myrialux {
namespace {

class Meter {
 public:
  Meter(const CompletedSlice& slice, const BitMatrix& visible, Rng& rng)
      : s_(slice), visible_(visible), rng_(rng), n_active_(bits_of_rows(slice.active)) {}
  MeterReading read();

 private:
  std::size_t draw_column(std::size_t row);
  bool is_wrong(std::size_t row, std::size_t j) const;
  double error(std::size_t row, std::size_t j) const;
  double follow(std::size_t row, std::size_t j);
  std::uint32_t pixel(std::size_t row) const { return s_.receivers.sample[index(s_.rows[row])] / s_.spp; }
  std::span<const std::uint32_t> rows_of_pixel(std::size_t row);

  const CompletedSlice& s_;
  const BitMatrix& visible_;
  Rng& rng_;
  const std::vector<std::uint32_t> n_active_;
  std::vector<std::uint32_t> by_pixel_;  ///< rows that have active entries, pixel by pixel; made when first needed
  MeterReading reading_;
};

MeterReading Meter::read() {
  for (std::size_t row = 0; row < s_.rows.size(); ++row) {
    if (n_active_[row] == 0) continue;
    const std::size_t j = draw_column(row);
    ++reading_.rays;
    if (!is_wrong(row, j)) continue;
    ++(visible_.test(row, j) ? reading_.false_visible : reading_.false_occluded);
    const double e = n_active_[row] * error(row, j);
    reading_.bias += e;
    reading_.squares += e * follow(row, j);
  }
  return reading_;
}

/// One of the row's active columns.
std::size_t Meter::draw_column(std::size_t row) {
  const auto n_columns = static_cast<std::uint32_t>(s_.columns.size());
  std::size_t j = rng_.below(n_columns);
  while (!s_.active.test(row, j)) j = rng_.below(n_columns);
  return j;
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

/// Estimates the error of the row's pixel. That of entry (row, j), found wrong, is known; all others are drawn, the
/// same number in each of the pixel's rows.
double Meter::follow(std::size_t row, std::size_t j) {
  const std::span<const std::uint32_t> rows = rows_of_pixel(row);
  const std::uint32_t n_rays = std::max(1u, kFollowingRays / static_cast<std::uint32_t>(rows.size()));
  double sum = 0;
  for (const std::uint32_t other : rows) {
    double errors = 0;
    for (std::uint32_t k = 0; k < n_rays; ++k) {
      const std::size_t column = draw_column(other);
      const bool is_known = other == row && column == j;
      if (!is_known && is_wrong(other, column)) errors += error(other, column);
    }
    sum += errors * n_active_[other] / n_rays;
  }
  reading_.more_rays += rows.size() * n_rays;
  return error(row, j) + sum;
}

std::span<const std::uint32_t> Meter::rows_of_pixel(std::size_t row) {
  const auto less = [&](std::uint32_t a, std::uint32_t b) { return pixel(a) < pixel(b); };
  if (by_pixel_.empty()) {
    for (std::uint32_t r = 0; r < n_active_.size(); ++r)
      if (n_active_[r] > 0) by_pixel_.push_back(r);
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

/// Counters of 64 rows at a time, bit by bit: plane k holds bit k of the counts.
std::vector<std::uint32_t> bits_of_rows(const BitMatrix& bits) {
  const std::size_t words = bits.words_per_column(), n_planes = std::bit_width(bits.n_columns());
  std::vector<std::uint64_t> planes(n_planes * words);
  for (std::size_t j = 0; j < bits.n_columns(); ++j) {
    const Words column = bits.column(j);
    for (std::size_t w = 0; w < words; ++w) {
      std::uint64_t carry = column[w];
      for (std::size_t k = 0; carry != 0; ++k)
        carry &= std::exchange(planes[k * words + w], planes[k * words + w] ^ carry);
    }
  }
  std::vector<std::uint32_t> counts(bits.n_rows());
  for (std::size_t row = 0; row < counts.size(); ++row)
    for (std::size_t k = 0; k < n_planes; ++k)
      counts[row] |= static_cast<std::uint32_t>(planes[k * words + row / 64] >> row % 64 & 1) << k;
  return counts;
}

}  // namespace myrialux
