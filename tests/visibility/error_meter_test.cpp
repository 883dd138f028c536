// The meter's numbers are right in the mean, over many seeds, for wrong bits planted in known places.
#include "myrialux/visibility/error_meter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "myrialux/transfer/transfer.h"
#include "myrialux/visibility/slice_visibility.h"
#include "support/random_room.h"
#include "support/statistics.h"

namespace myrialux {
namespace {

using test::Room;

constexpr float kClamp = 0.05f, kUnit = 0.7f;

/// A slice of a room with its true bits, and the same with some of them wrong.
class PlantedSlice {
 public:
  explicit PlantedSlice(std::size_t n_rows)
      : room_({.n_receivers = n_rows,
               .n_lights = 300,
               .kinds = {LightKind::oriented, LightKind::point, LightKind::directional}}) {
    Rng rng({5}, Stage::test, 1);
    for (Rgb& beta : room_.receivers.beta) beta = Rgb{rng.next(), rng.next(), rng.next()};
    for (std::size_t k = 0; k < n_rows; ++k) rows_.push_back(static_cast<ReceiverId>(k));
    tree_ = build_light_tree(room_.world(), room_.lights, Room::kRadius, {});
    columns_ = light_cut(room_.world(), room_.receivers, rows_, room_.lights, tree_,
                         {.n_clusters = 40, .clamp_distance = kClamp});
    source_ = std::make_unique<SliceVisibility>(world_, room_.receivers, rows_, room_.lights, columns_, true);
    source_->set_block_energies(
        BlockEnergies(world_, room_.receivers, rows_, room_.lights, tree_, columns_, kClamp, kUnit));
    doubts_ = BlockDoubts(n_rows, columns_.size());
    for (std::size_t j = 0; j < columns_.size(); ++j)
      for (std::size_t b = 0; b < doubts_.n_blocks(); ++b) doubts_.set(b, j, j % 3 == 0 ? 0.001f : 0.1f);
    truth = BitMatrix(n_rows, columns_.size());
    for (std::size_t j = 0; j < columns_.size(); ++j) source_->trace(j, source_->active(j), truth.column(j));
    active = source_->active_matrix();
  }
  /// @param spp rows spp * k to spp * k + spp - 1 lie in pixel k
  CompletedSlice slice(std::uint32_t spp = 1) const {
    return {.world = world_,
            .receivers = room_.receivers,
            .rows = rows_,
            .lights = room_.lights,
            .columns = columns_,
            .energies = *source_->known_block_energies(),
            .doubts = doubts_,
            .active = active,
            .clamp_distance = kClamp,
            .unit = kUnit,
            .spp = spp};
  }
  /// Turns over a share of the active bits that grows from row to row, so that rows count as rows.
  BitMatrix with_wrong_bits(float share) const {
    BitMatrix bits = truth;
    Rng rng({5}, Stage::test, 2);
    for (std::size_t j = 0; j < bits.n_columns(); ++j)
      for (std::size_t i = 0; i < bits.n_rows(); ++i) {
        const float wanted = 2 * share * static_cast<float>(i) / static_cast<float>(bits.n_rows());
        if (!active.test(i, j) || rng.next() >= wanted) continue;
        truth.test(i, j) ? clear_bit(bits.column(j), i) : set_bit(bits.column(j), i);
      }
    return bits;
  }
  void put_out(std::size_t row) {
    for (std::size_t j = 0; j < active.n_columns(); ++j)
      clear_bit(active.column(j), row), clear_bit(truth.column(j), row);
  }
  /// Energy of an entry, from its transfer.
  double energy(std::size_t i, std::size_t j) const {
    const Rgb t = transfer(world_, room_.receivers, rows_[i], room_.lights, columns_[j].light, kClamp);
    return static_cast<double>(columns_[j].weight * luminance(room_.receivers.beta[i] * t) / kUnit);
  }

  BitMatrix truth, active;

 private:
  Room room_;
  World world_ = room_.world();
  std::vector<ReceiverId> rows_;
  LightTree tree_;
  std::vector<Column> columns_;
  std::unique_ptr<SliceVisibility> source_;
  BlockDoubts doubts_{0, 0};
};

struct Sums {
  double rows = 0, false_visible = 0, false_occluded = 0, squares = 0, bias = 0;
};

/// What a reading is in the mean, entry by entry.
Sums plain_sums(const PlantedSlice& planted, const BitMatrix& bits, std::uint32_t spp = 1) {
  Sums sums;
  std::vector<double> errors((bits.n_rows() + spp - 1) / spp);
  for (std::size_t i = 0; i < bits.n_rows(); ++i) {
    double n = 0, visible = 0, occluded = 0;
    for (std::size_t j = 0; j < bits.n_columns(); ++j) {
      if (!planted.active.test(i, j)) continue;
      ++n;
      const bool completed = bits.test(i, j), truth = planted.truth.test(i, j);
      if (completed == truth) continue;
      const double e = planted.energy(i, j);
      ++(completed ? visible : occluded);
      sums.bias += completed ? e : -e;
      errors[i / spp] += completed ? e : -e;
    }
    if (n > 0) ++sums.rows, sums.false_visible += visible / n, sums.false_occluded += occluded / n;
  }
  for (const double e : errors) sums.squares += e * e;
  return sums;
}

TEST(ErrorMeter, IsRightInTheMean) {
  PlantedSlice planted(200);
  for (const std::size_t row : {6u, 7u, 8u, 150u}) planted.put_out(row);  // a part of a pixel, where it has some rows
  const BitMatrix bits = planted.with_wrong_bits(0.05f);
  for (const std::uint32_t spp : {1u, 4u, 12u}) {
    const Sums expected = plain_sums(planted, bits, spp);
    ASSERT_GT(expected.false_visible, 0.5);
    ASSERT_GT(expected.false_occluded, 0.5);
    test::Sample visible, occluded, squares, bias;
    for (std::uint64_t seed = 0; seed < 20000; ++seed) {
      Rng rng({seed}, Stage::error_meter, 0);
      const MeterReading r = measure_errors(planted.slice(spp), bits, rng);
      ASSERT_EQ(static_cast<double>(r.rays), expected.rows);
      visible.add(static_cast<double>(r.false_visible)), occluded.add(static_cast<double>(r.false_occluded));
      squares.add(r.squares), bias.add(r.bias);
    }
    // Level 6e-5 each.
    EXPECT_LT(std::fabs(test::z_score(visible, expected.false_visible)), 4) << spp << " " << visible.mean;
    EXPECT_LT(std::fabs(test::z_score(occluded, expected.false_occluded)), 4) << spp << " " << occluded.mean;
    EXPECT_LT(std::fabs(test::z_score(squares, expected.squares)), 4)
        << spp << " " << squares.mean << " " << expected.squares;
    EXPECT_LT(std::fabs(test::z_score(bias, expected.bias)), 4) << spp << " " << bias.mean << " " << expected.bias;
    // And sure enough to tell an error of some percent.
    EXPECT_LT(std::sqrt(squares.variance_of_mean()), 0.1 * expected.squares) << spp;
    EXPECT_LT(std::sqrt(visible.variance_of_mean()), 0.05 * expected.false_visible) << spp;
  }
}

TEST(ErrorMeter, WrongRaysAreFollowedByTheSameNumberInEachRowOfTheirPixel) {
  const PlantedSlice planted(192);
  const BitMatrix bits = planted.with_wrong_bits(0.1f);
  for (const auto& [spp, following] : {std::pair{1u, 32u}, {4u, 32u}, {96u, 96u}}) {
    Rng rng({1}, Stage::error_meter, 0);
    const MeterReading r = measure_errors(planted.slice(spp), bits, rng);
    ASSERT_GT(r.wrong_by_energy, 0u);
    // Entries that are drawn and not active cost no ray.
    const std::uint64_t drawn = 192 / kRowsByEnergy + following * r.wrong_by_energy;
    EXPECT_LE(r.more_rays, drawn) << spp;
    EXPECT_GT(r.more_rays, following * r.wrong_by_energy / 4) << spp;
  }
}

TEST(ErrorMeter, SkipsRowsWithoutActiveEntries) {
  PlantedSlice planted(100);
  for (const std::size_t row : {0u, 63u, 64u, 99u}) planted.put_out(row);
  const double rows = plain_sums(planted, planted.truth).rows;
  ASSERT_LE(rows, 96);
  Rng rng({1}, Stage::error_meter, 0);
  EXPECT_EQ(static_cast<double>(measure_errors(planted.slice(), planted.truth, rng).rays), rows);
}

TEST(ErrorMeter, FindsNothingInTrueBitsAndAllInTheirOpposite) {
  const PlantedSlice planted(130);
  BitMatrix opposite = planted.truth;
  for (std::size_t j = 0; j < opposite.n_columns(); ++j)
    for (std::size_t w = 0; w < opposite.words_per_column(); ++w) opposite.column(j)[w] ^= planted.active.column(j)[w];
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng({seed}, Stage::error_meter, 0);
    const MeterReading none = measure_errors(planted.slice(), planted.truth, rng);
    EXPECT_EQ(none.false_visible + none.false_occluded, 0u) << "packets and single rays see the same";
    EXPECT_EQ(none.squares, 0);
    EXPECT_EQ(none.bias, 0);
    const MeterReading all = measure_errors(planted.slice(), opposite, rng);
    EXPECT_EQ(all.false_visible + all.false_occluded, all.rays);
  }
}

}  // namespace
}  // namespace myrialux
