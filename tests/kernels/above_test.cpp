// Numbers above a limit as bits, against the plain twin on every instruction set.
#include "myrialux/kernels/above.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/kernels/isa.h"

namespace myrialux {
namespace {

TEST(Above, EqualsItsPlainTwinOnEveryInstructionSet) {
  for (const std::int64_t isa : available_isas()) {
    force_isa(isa);
    Rng rng({1}, Stage::test, 0);
    for (const std::size_t n : {0u, 1u, 3u, 4u, 15u, 16u, 17u, 63u, 64u, 65u, 130u}) {
      std::vector<float> values(n);
      for (float& v : values) v = rng.next();
      if (n > 2) values[1] = std::numeric_limits<float>::quiet_NaN(), values[2] = 0.5f;
      std::vector<std::uint64_t> got((n + 63) / 64 + 1, ~std::uint64_t{0}), expected(got);
      above(values, 0.5f, got);
      above_plain(values, 0.5f, expected);
      EXPECT_EQ(got, expected) << n;
    }
  }
  force_isa(0);
}

TEST(Above, EqualAndNotANumberAreNotAbove) {
  const std::vector<float> values{0.5f, std::numeric_limits<float>::quiet_NaN(), 0.6f, -1};
  std::vector<std::uint64_t> bits(1);
  above(values, 0.5f, bits);
  EXPECT_EQ(bits[0], 4u);
}

}  // namespace
}  // namespace myrialux
