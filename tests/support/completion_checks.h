// What must hold of every completion, whatever the matrix and the algorithm.
#pragma once

#include <gtest/gtest.h>

#include <utility>

#include "myrialux/completion/completion_stats.h"
#include "support/logging_entries.h"
#include "support/shadow_matrices.h"

namespace myrialux::test {

struct Completed {
  BitMatrix visible;
  CompletionStats stats;
};

inline LoggingEntries all_active(const BitMatrix& truth, std::vector<std::size_t> groups = {}) {
  return LoggingEntries(truth, all_ones(truth.n_rows(), truth.n_columns()), std::move(groups));
}

/// The truth only where active.
inline LoggingEntries masked(BitMatrix truth, const BitMatrix& active, std::vector<std::size_t> groups = {}) {
  for (std::size_t j = 0; j < truth.n_columns(); ++j)
    for (std::size_t w = 0; w < truth.words_per_column(); ++w) truth.column(j)[w] &= active.column(j)[w];
  return LoggingEntries(std::move(truth), active, std::move(groups));
}

/// No entry asked for twice, none that does not matter; traced bits stay, don't-care bits are 0; counts are true.
inline void expect_sound(const LoggingEntries& source, const Completed& c) {
  EXPECT_EQ(source.n_asked_twice, 0u);
  EXPECT_EQ(source.n_asked_inactive, 0u);
  EXPECT_EQ(c.stats.entries, source.active_matrix().count());
  EXPECT_EQ(c.stats.traced, source.asked().count());
  for (std::size_t j = 0; j < source.n_columns(); ++j)
    for (std::size_t w = 0; w < c.visible.words_per_column(); ++w) {
      const std::uint64_t got = c.visible.column(j)[w], asked = source.asked().column(j)[w];
      ASSERT_EQ((got ^ source.truth().column(j)[w]) & asked, 0u) << "a traced bit changed, column " << j;
      ASSERT_EQ(got & ~source.active(j)[w], 0u) << "a don't-care bit is set, column " << j;
    }
}

/// Every seventh active entry must be traced, and all of the first 40 rows of column 3.
class DemandingEntries : public LoggingEntries {
 public:
  explicit DemandingEntries(const KnownEntries& known) : LoggingEntries(known), required_(n_rows(), n_columns()) {
    for (std::size_t j = 0; j < n_columns(); ++j)
      for (std::size_t i = 0; i < n_rows(); ++i)
        if (test_bit(active(j), i) && ((i + 3 * j) % 7 == 0 || (j == 3 && i < 40))) required_.set(i, j);
  }
  Words required(std::size_t j) const override { return std::as_const(required_).column(j); }

 private:
  BitMatrix required_;
};

}  // namespace myrialux::test
