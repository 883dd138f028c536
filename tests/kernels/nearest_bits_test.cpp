// The search for the nearest bit column against its plain twin, on every instruction set.
#include "myrialux/kernels/nearest_bits.h"

#include <gtest/gtest.h>

#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/kernels/isa.h"

namespace myrialux {
namespace {

std::vector<std::uint64_t> random_words(std::size_t n, Rng& rng) {
  std::vector<std::uint64_t> words(n);
  for (std::uint64_t& w : words) w = std::uint64_t{rng.next_uint()} << 32 | rng.next_uint();
  return words;
}

TEST(NearestBits, EqualTheirPlainTwinOnEveryInstructionSet) {
  for (const std::int64_t isa : available_isas()) {
    force_isa(isa);
    Rng rng({1}, Stage::test, 0);
    for (const std::size_t words : {1u, 3u, 8u, 16u, 21u})
      for (const std::size_t n : {1u, 2u, 7u, 64u}) {
        std::vector<std::uint64_t> visible = random_words(n * words, rng), known = random_words(n * words, rng);
        for (std::uint64_t& w : known) w |= rng.next_uint();  // most rows known
        std::vector<std::uint64_t> omega = random_words(words, rng), samples = random_words(words, rng);
        for (std::uint64_t& w : omega) w &= random_words(1, rng)[0] & random_words(1, rng)[0];
        for (std::size_t first = 0; first < n; ++first) {
          const BitColumns columns{visible, known, words};
          const NearestColumn got = nearest_column(columns, first, samples, omega),
                              expected = nearest_column_plain(columns, first, samples, omega);
          EXPECT_EQ(got.column, expected.column);
          EXPECT_EQ(got.distance, expected.distance);
        }
      }
  }
  force_isa(0);
}

TEST(NearestBits, RowsThatAreNotKnownCountAsWrong) {
  const std::vector<std::uint64_t> visible{0b0111, 0b0101}, known{0b0011, 0b1111}, omega{0b1111}, samples{0b0111};
  const NearestColumn nearest = nearest_column({visible, known, 1}, 0, samples, omega);
  EXPECT_EQ(nearest.column, 1u);
  EXPECT_EQ(nearest.distance, 1u) << "the first agrees in two rows and does not know the other two";
}

TEST(NearestBits, AmongEqualsTheLatestBeforeTheFirstWins) {
  const std::vector<std::uint64_t> visible{1, 0, 1, 0}, known{1, 1, 1, 1}, omega{1}, samples{1};
  EXPECT_EQ(nearest_column({visible, known, 1}, 1, samples, omega).column, 0u);
  EXPECT_EQ(nearest_column({visible, known, 1}, 3, samples, omega).column, 2u);
  const std::vector<std::uint64_t> none{0};
  EXPECT_EQ(nearest_column({visible, known, 1}, 0, none, omega).column, 3u) << "0 disagrees, then comes the last";
}

}  // namespace
}  // namespace myrialux
