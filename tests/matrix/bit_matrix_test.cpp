// Bits of columns: places, counts, spare bits, loops over set bits.
#include <gtest/gtest.h>

#include "myrialux/base/rng.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/matrix/known_entries.h"

namespace myrialux {
namespace {

class BitMatrixSizes : public ::testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Rows, BitMatrixSizes, ::testing::Values(1, 16, 63, 64, 65, 1000, 1024));

TEST_P(BitMatrixSizes, SetBitsAreFoundAndCountedColumnByColumn) {
  const std::size_t n_rows = GetParam(), n_columns = 5;
  BitMatrix m(n_rows, n_columns);
  std::vector<bool> expected(n_rows * n_columns);
  Rng rng({1}, Stage::test, n_rows);
  for (std::size_t k = 0; k < expected.size(); ++k)
    if (rng.below(3) == 0) expected[k] = true, m.set(k % n_rows, k / n_rows);
  std::size_t n = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_EQ(m.test(k % n_rows, k / n_rows), expected[k]);
    n += expected[k];
  }
  EXPECT_EQ(m.count(), n);
  for (std::size_t j = 0; j < n_columns; ++j) {
    std::size_t next = 0;
    for_each_bit(m.column(j), [&](std::size_t i) {
      for (; next < i; ++next) EXPECT_FALSE(expected[j * n_rows + next]);
      EXPECT_TRUE(expected[j * n_rows + i]);
      next = i + 1;
    });
  }
}

TEST_P(BitMatrixSizes, FilledColumnsHaveNoSpareBits) {
  BitMatrix m(GetParam(), 2);
  fill_rows(m.column(1), GetParam());
  EXPECT_EQ(m.count(), GetParam());
  EXPECT_EQ(m.column(1).back(), m.tail_mask());
  EXPECT_EQ(count_bits(m.column(0)), 0u);
}

TEST(BitMatrix, ClearedBitsAreGone) {
  BitMatrix m(70, 1);
  fill_rows(m.column(0), 70);
  clear_bit(m.column(0), 65);
  EXPECT_FALSE(m.test(65, 0));
  EXPECT_EQ(m.count(), 69u);
}

TEST(BitMatrix, EmptyMatricesHaveNoBits) {
  EXPECT_EQ(BitMatrix().count(), 0u);
  EXPECT_EQ(BitMatrix(0, 3).words_per_column(), 0u);
  EXPECT_EQ(BitMatrix(3, 0).count(), 0u);
}

TEST(KnownEntries, TracesWantedRowsOnly) {
  BitMatrix truth(70, 1), active(70, 1), visible(70, 1);
  truth.set(3, 0), truth.set(69, 0);
  fill_rows(active.column(0), 70);
  visible.set(3, 0), visible.set(4, 0), visible.set(5, 0);
  BitMatrix wanted(70, 1);
  wanted.set(3, 0), wanted.set(4, 0), wanted.set(69, 0);
  KnownEntries source(truth, active);
  source.trace(0, std::as_const(wanted).column(0), visible.column(0));
  EXPECT_TRUE(visible.test(3, 0));
  EXPECT_FALSE(visible.test(4, 0));
  EXPECT_TRUE(visible.test(5, 0)) << "not wanted: stays";
  EXPECT_TRUE(visible.test(69, 0));
}

}  // namespace
}  // namespace myrialux
