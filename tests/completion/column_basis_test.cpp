// Matching of samples against columns of Q and their complements.
#include "myrialux/completion/column_basis.h"

#include <gtest/gtest.h>

#include "support/shadow_matrices.h"

namespace myrialux {
namespace {

using test::all_ones;
using test::random_bits;

TEST(ColumnBasis, FindsWhatAPlainLoopFinds) {
  Rng rng({1}, Stage::test, 0);
  for (const std::size_t n_rows : {1u, 63u, 64u, 65u, 1000u}) {
    const BitMatrix columns = random_bits(n_rows, 40, rng), known = random_bits(n_rows, 40, rng, 0.9f);
    ColumnBasis basis;
    basis.reset(columns.words_per_column());
    for (std::size_t q = 0; q < 40; ++q) basis.add(columns.column(q), known.column(q));
    for (int round = 0; round < 50; ++round) {
      const BitMatrix sample = random_bits(n_rows, 1, rng);
      BitMatrix omega(n_rows, 1);
      for (int k = 0; k < 4; ++k) omega.set(rng.below(static_cast<std::uint32_t>(n_rows)), 0);
      std::vector<std::pair<std::uint32_t, bool>> expected, found;
      for (std::uint32_t q = 0; q < 40; ++q) {
        bool same = true, opposite = true;
        for_each_bit(omega.column(0), [&](std::size_t i) {
          const bool equal = columns.test(i, q) == sample.test(i, 0);
          same &= equal && known.test(i, q);
          opposite &= !equal && known.test(i, q);
        });
        if (same) expected.emplace_back(q, false);
        if (opposite) expected.emplace_back(q, true);
      }
      for (const BasisMatch& m : basis.find(sample.column(0), omega.column(0)))
        found.emplace_back(m.column, m.complemented);
      EXPECT_EQ(found, expected);
    }
  }
}

TEST(ColumnBasis, ForgetsTheGroupBefore) {
  const BitMatrix one = all_ones(64, 1);
  ColumnBasis basis;
  basis.reset(1);
  basis.add(one.column(0), one.column(0));
  basis.reset(1);
  EXPECT_TRUE(basis.empty());
  EXPECT_TRUE(basis.find(one.column(0), one.column(0)).empty());
}

}  // namespace
}  // namespace myrialux
