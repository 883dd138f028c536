// Entries are drawn by rejection among a row's columns; only wrong ones need their transfer.
#include "myrialux/visibility/error_meter.h"

#include <bit>
#include <utility>

#include "myrialux/base/assert.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/transfer/transfer.h"

namespace myrialux {
namespace {

float energy(const CompletedSlice& s, std::size_t row, std::size_t j) {
  const ReceiverId i = s.rows[row];
  const Rgb t = transfer(s.world, s.receivers, i, s.lights, s.columns[j].light, s.clamp_distance);
  return s.columns[j].weight * luminance(s.receivers.beta[index(i)] * t) / s.unit;
}

bool is_visible(const CompletedSlice& s, std::size_t row, std::size_t j) {
  const Segment segment = shadow_segment(s.receivers, s.rows[row], s.lights, s.columns[j].light);
  return segment.distant ? !s.world.tracer.occluded_direction(segment.from, segment.to)
                         : !s.world.tracer.occluded(segment.from, segment.to);
}

}  // namespace

MeterReading measure_errors(const CompletedSlice& s, const BitMatrix& visible, Rng& rng) {
  MYRIALUX_ASSERT(visible.n_rows() == s.rows.size() && visible.n_columns() == s.columns.size() && s.unit > 0);
  const auto n_columns = static_cast<std::uint32_t>(s.columns.size());
  const std::vector<std::uint32_t> n_active = bits_of_rows(s.active);
  MeterReading reading;
  for (std::size_t row = 0; row < s.rows.size(); ++row) {
    if (n_active[row] == 0) continue;
    std::size_t j = rng.below(n_columns);
    while (!s.active.test(row, j)) j = rng.below(n_columns);
    ++reading.rays;
    const bool truth = is_visible(s, row, j), completed = visible.test(row, j);
    if (truth == completed) continue;
    ++(completed ? reading.false_visible : reading.false_occluded);
    const double e = energy(s, row, j), n = n_active[row];
    reading.squares += n * e * e;
    reading.bias += completed ? n * e : -n * e;
  }
  return reading;
}

double sum_wrong_squares(const CompletedSlice& s, const BitMatrix& visible, const BitMatrix& truth) {
  double sum = 0;
  for (std::size_t j = 0; j < s.columns.size(); ++j) {
    const Words a = visible.column(j), b = truth.column(j);
    for (std::size_t w = 0; w < a.size(); ++w)
      for (std::uint64_t wrong = a[w] ^ b[w]; wrong != 0; wrong &= wrong - 1) {
        const double e = energy(s, w * 64 + static_cast<std::size_t>(std::countr_zero(wrong)), j);
        sum += e * e;
      }
  }
  return sum;
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
