// Arrays that are filled in parallel hold what a plain loop finds, for any size and number of threads.
#include "myrialux/base/array.h"

#include <gtest/gtest.h>

#include "myrialux/base/parallel.h"

namespace myrialux {
namespace {

TEST(Array, KeepsWhatIsGivenAndWhatWasThere) {
  Array<int> a(3, 7);
  EXPECT_EQ(a, (Array<int>{7, 7, 7}));
  a.push_back(9);
  a.resize(2);
  EXPECT_EQ(a, (Array<int>{7, 7}));
  a.assign(2, 1);
  EXPECT_EQ(a, (Array<int>{1, 1}));
}

TEST(Select, FindsInOrderWhatAPlainLoopFinds) {
  const auto keep = [](std::size_t i) { return i * i % 7 < 3; };
  const auto make = [](std::size_t i) { return 3 * i; };
  for (const std::size_t n : {0u, 1u, 16383u, 16384u, 16385u, 100003u}) {
    Array<std::size_t> expected;
    for (std::size_t i = 0; i < n; ++i)
      if (keep(i)) expected.push_back(make(i));
    for (const int threads : {1, 2, 7}) {
      const ThreadScope scope(threads);
      EXPECT_EQ(select<std::size_t>(n, keep, make), expected) << n << " by " << threads;
    }
  }
  EXPECT_TRUE(select<int>(
                  50000, [](std::size_t) { return false; }, [](std::size_t) { return 1; })
                  .empty());
}

}  // namespace
}  // namespace myrialux
