// Random streams, parallel loops, requests to stop, collected mistakes, number of threads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <set>
#include <thread>
#include <vector>

#include "myrialux/base/cancel.h"
#include "myrialux/base/error.h"
#include "myrialux/base/parallel.h"
#include "myrialux/base/rng.h"

namespace myrialux {
namespace {

TEST(Rng, FirstValuesStay) {
  // Philox 4x32-10 of counter 0 and key 0 is a published test vector: 6627e8d5 e169c58d bc57ac4c 9b00dbd8 [salmon11].
  Rng zero({0, 0}, Stage::test, 0);
  EXPECT_EQ(zero.next_uint(), 0x9b00dbd8u);
  EXPECT_EQ(zero.next_uint(), 0xbc57ac4cu);
  EXPECT_EQ(zero.next_uint(), 0xe169c58du);
  EXPECT_EQ(zero.next_uint(), 0x6627e8d5u);
}

TEST(Rng, TheSameStreamGivesTheSameNumbers) {
  Rng a({123456789012345, 7}, Stage::direct, 1ull << 40), b({123456789012345, 7}, Stage::direct, 1ull << 40);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(a.next_uint(), b.next_uint());
}

TEST(Rng, StreamsDifferInSeedPassStageAndItem) {
  std::set<std::uint32_t> first;
  for (const std::uint64_t seed : {0ull, 1ull, 1ull << 32})
    for (const std::uint32_t pass : {0u, 1u})
      for (const Stage stage : {Stage::test, Stage::camera, Stage::film})
        for (const std::uint64_t item : {0ull, 1ull, 1ull << 32})
          first.insert(Rng({seed, pass}, stage, item).next_uint());
  EXPECT_EQ(first.size(), 3u * 2 * 3 * 3);
}

TEST(Rng, StreamsAreUniformAndUncorrelatedWithTheirNeighbours) {
  constexpr int kItems = 50'000;
  double sum = 0, squares = 0, product = 0, along = 0;
  for (int item = 0; item < kItems; ++item) {
    Rng a({5, 0}, Stage::test, static_cast<std::uint64_t>(item)),
        b({5, 0}, Stage::test, static_cast<std::uint64_t>(item) + 1);
    const double x = a.next() - 0.5, y = b.next() - 0.5, z = a.next() - 0.5;
    ASSERT_TRUE(x >= -0.5 && x < 0.5);
    sum += x, squares += x * x, product += x * y, along += x * z;
  }
  // standard errors: sqrt(1/12), sqrt(1/180) and 1/12, each over sqrt(n)
  const double root = std::sqrt(double(kItems));
  EXPECT_LT(std::fabs(sum / kItems), 4 * std::sqrt(1 / 12.0) / root);
  EXPECT_LT(std::fabs(squares / kItems - 1 / 12.0), 4 * std::sqrt(1 / 180.0) / root);
  EXPECT_LT(std::fabs(product / kItems), 4 / 12.0 / root);
  EXPECT_LT(std::fabs(along / kItems), 4 / 12.0 / root);
}

TEST(Rng, BelowIsUniform) {
  Rng rng({6, 0}, Stage::test, 0);
  std::vector<int> counts(7);
  constexpr int kDraws = 70'000;
  for (int i = 0; i < kDraws; ++i) {
    const std::uint32_t k = rng.below(7);
    ASSERT_LT(k, 7u);
    ++counts[k];
  }
  for (const int n : counts) EXPECT_NEAR(n, kDraws / 7, 4 * std::sqrt(kDraws / 7.0));
}

std::vector<float> numbers_of_items(int n_threads, std::size_t grain) {
  const ThreadScope scope(n_threads);
  std::vector<float> found(10'007);
  parallel_for(
      found.size(),
      [&](std::size_t i) {
        found[i] = Rng({9, 0}, Stage::test, i).next() * static_cast<float>(i);
      },
      grain);
  return found;
}

TEST(ParallelFor, GivesTheSameForAnyNumberOfThreads) {
  const std::vector<float> one = numbers_of_items(1, 1);
  for (const int n_threads : {2, 7, available_threads()})
    for (const std::size_t grain : {1u, 64u}) EXPECT_EQ(numbers_of_items(n_threads, grain), one);
}

TEST(ParallelFor, CallsEachItemOnce) {
  for (const std::size_t n : {0u, 1u, 63u, 64u, 65u, 1000u}) {
    std::vector<int> calls(n);
    parallel_for(
        n, [&](std::size_t i) { ++calls[i]; }, 16);
    EXPECT_EQ(std::accumulate(calls.begin(), calls.end(), 0), static_cast<int>(n));
    EXPECT_TRUE(std::all_of(calls.begin(), calls.end(), [](int c) { return c == 1; }));
  }
}

TEST(ParallelFor, PassesErrorsOn) {
  EXPECT_THROW(parallel_for(100,
                            [](std::size_t i) {
                              if (i == 50) throw Error(ErrorKind::limit, "item 50");
                            }),
               Error);
}

#ifdef MYRIALUX_SANITIZE_THREAD
/// Items 0 and 1 on two threads at once: each waits for the other, by means that order nothing else.
template <class Body>
void run_two_items_at_once(const Body& body) {
  std::atomic<int> n_started{0};
  parallel_for(2, [&](std::size_t i) {
    n_started.fetch_add(1, std::memory_order_relaxed);
    const auto begin = std::chrono::steady_clock::now();
    while (n_started.load(std::memory_order_relaxed) < 2)
      if (std::chrono::steady_clock::now() - begin > std::chrono::seconds(20)) throw Error(ErrorKind::limit, "alone");
    body(i);
  });
}

TEST(ThreadSanitizer, SeesARaceBetweenItems) {
  if (available_threads() < 2) GTEST_SKIP() << "needs two processors";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto race = [] {
    int sum = 0;
    run_two_items_at_once([&](std::size_t i) { sum += static_cast<int>(i); });
    std::exit(sum > 5);
  };
  EXPECT_EXIT(race(), ::testing::ExitedWithCode(66), "WARNING: ThreadSanitizer: data race");
}

TEST(ThreadSanitizer, AcceptsWorkHandedToItemsAndBack) {
  if (available_threads() < 2) GTEST_SKIP() << "needs two processors";
  std::vector<int> sums(2);
  for (int round = 0; round < 100; ++round) {
    const std::vector<int> given(2, round);
    run_two_items_at_once([&](std::size_t i) { sums[i] += given[i]; });
    EXPECT_EQ(sums[0], sums[1]);
  }
}
#endif

TEST(Cancel, StopsParallelLoops) {
  std::atomic<int> n_calls{0};
  try {
    parallel_for(1'000'000, [&](std::size_t) {
      ++n_calls;
      request_cancel();
    });
    ADD_FAILURE() << "the loop ran to its end";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::interrupted);
  }
  EXPECT_LT(n_calls, 100'000);
  EXPECT_TRUE(cancel_requested());
  EXPECT_THROW(throw_if_cancelled(), Error);
  clear_cancel();
  EXPECT_FALSE(cancel_requested());
  EXPECT_NO_THROW(throw_if_cancelled());
}

TEST(Diagnostics, ListsAllMistakesWithTheirPlaces) {
  Diagnostics found;
  found.throw_if(Severity::warning);
  found.warning({"a.xml", 3, 4}, "odd");
  EXPECT_FALSE(found.has(Severity::error));
  EXPECT_NO_THROW(found.throw_if(Severity::error));
  found.error({"a.xml", 41, 17}, "radius must be > 0, got -0.1");
  found.error({"b.ply", 0, 0}, "file ends early");
  found.unsupported({}, "hair cannot be rendered");
  EXPECT_TRUE(found.has(Severity::error));
  EXPECT_EQ(found.all().size(), 4u);
  try {
    found.throw_if(Severity::error);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
    EXPECT_STREQ(error.what(), "a.xml:41:17: radius must be > 0, got -0.1\nb.ply: file ends early");
  }
  try {
    found.throw_if(Severity::warning);
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::StartsWith("a.xml:3:4: warning: odd\n"));
    EXPECT_THAT(error.what(), ::testing::EndsWith("hair cannot be rendered"));
  }
}

TEST(Diagnostics, PlacesLeaveOutWhatIsUnknown) {
  EXPECT_EQ(to_string(TextPosition{"a", 1, 2}), "a:1:2");
  EXPECT_EQ(to_string(TextPosition{"a", 1, 0}), "a:1");
  EXPECT_EQ(to_string(TextPosition{"a", 0, 2}), "a");
  EXPECT_EQ(to_string(TextPosition{}), "");
}

TEST(Threads, AtLeastOneAndNoMoreThanTheMachineHas) {
  EXPECT_GE(available_threads(), 1);
  EXPECT_LE(available_threads(), static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
}

}  // namespace
}  // namespace myrialux
