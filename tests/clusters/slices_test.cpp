// Slices: every row once, full slices, the same for any number of threads, near and alike rows together.
#include "myrialux/clusters/slices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "myrialux/base/parallel.h"
#include "myrialux/base/rng.h"

namespace myrialux {
namespace {

/// Points on two parallel squares 1 x 1, normals against each other.
Receivers two_sheets(std::size_t n, float distance) {
  Receivers r;
  Rng rng({3}, Stage::test, n);
  for (std::size_t i = 0; i < n; ++i) {
    const bool top = rng.below(2) != 0;
    r.p.push_back({rng.next(), rng.next(), top ? distance : 0.0f});
    r.n.push_back({0, 0, top ? 1.0f : -1.0f});
  }
  return r;
}

double mean_diagonal(const Receivers& receivers, std::span<const ReceiverId> order, std::size_t group) {
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t begin = 0; begin < order.size(); begin += group, ++n) {
    Box3 box;
    for (std::size_t k = begin; k < std::min(begin + group, order.size()); ++k) box.add(receivers.p[index(order[k])]);
    sum += box.diagonal();
  }
  return sum / static_cast<double>(n);
}

TEST(Slices, HoldEveryRowOnceAndAllButOneAreFull) {
  for (const std::size_t n : {0, 1, 15, 16, 17, 1023, 1024, 1025, 2047, 2048, 2049, 10000, 50001, 600001}) {
    const Slices slices = make_slices(two_sheets(n, 0.1f), 1, {});
    Array<ReceiverId> sorted = slices.order;
    std::sort(sorted.begin(), sorted.end());
    ASSERT_EQ(sorted.size(), n);
    for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(index(sorted[i]), i);
    EXPECT_EQ(slices.size(), (n + 1023) / 1024);
    EXPECT_EQ(slices.begin.back(), n);
    for (std::size_t s = 0; s + 1 < slices.size(); ++s) EXPECT_EQ(slices.rows(s).size(), 1024u) << n;
  }
}

TEST(Slices, AreTheSameForAnyNumberOfThreads) {
  for (const std::size_t n : {100003u, 600001u}) {
    const Receivers receivers = two_sheets(n, 0.01f);
    Array<ReceiverId> first;
    for (const int threads : {1, 2, 7}) {
      const ThreadScope scope(threads);
      const Slices slices = make_slices(receivers, 1, {});
      if (first.empty()) first = slices.order;
      EXPECT_EQ(slices.order, first) << threads;
    }
  }
}

TEST(Slices, LargeFramesAreSplitWhereSortingSplitsThem) {
  const std::size_t n = (1 << 18) + 777;
  Receivers receivers = two_sheets(n, 0.01f);
  Rng rng({3}, Stage::test, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const float x = rng.below(3) == 0 ? 1.5f : 4 * rng.next();
    receivers.p[i] = {rng.below(2) ? x : -x, 0.25f * rng.next(), 0}, receivers.n[i] = {0, 0, 1};
  }
  const SliceParams params;
  const Slices slices = make_slices(receivers, 1, params);
  // The first cut is across x, at the multiple of whole slices nearest to the middle.
  const std::size_t middle = (n / params.max_rows + 1) / 2 * params.max_rows;
  const auto key = [&](ReceiverId i) {
    const Vec3 p = receivers.p[index(i)];
    return std::tuple(p.x, p.y, index(i));
  };
  Array<ReceiverId> sorted = slices.order;
  std::sort(sorted.begin(), sorted.end(), [&](ReceiverId a, ReceiverId b) { return key(a) < key(b); });
  const auto lower_half = [&](Array<ReceiverId> order) {
    order.resize(middle);
    std::sort(order.begin(), order.end());
    return order;
  };
  EXPECT_EQ(lower_half(slices.order), lower_half(sorted));
}

TEST(Slices, DoNotDependOnWhereEqualPointsStand) {
  // All rows alike: ties are broken by index, so the order is the rows' own.
  Receivers receivers = two_sheets(3000, 0);
  std::fill(receivers.p.begin(), receivers.p.end(), Vec3{1, 2, 3});
  std::fill(receivers.n.begin(), receivers.n.end(), Vec3{0, 0, 1});
  const Slices slices = make_slices(receivers, 1, {});
  for (std::size_t s = 0; s < slices.size(); ++s)
    for (const ReceiverId i : slices.rows(s)) EXPECT_EQ(index(i) / 1024, s);
}

TEST(Slices, AndBlocksAreCompact) {
  // n points spread over 2 unit squares: a group of g rows covers g / (n / 2) of a square.
  const std::size_t n = 1 << 17;
  const Receivers receivers = two_sheets(n, 2);
  const Slices slices = make_slices(receivers, 2, {});
  for (const std::size_t group : {16, 1024}) {
    const double square = std::sqrt(2.0 * static_cast<double>(group) / (static_cast<double>(n) / 2));
    EXPECT_LT(mean_diagonal(receivers, slices.order, group), 1.4 * square) << group;
  }
}

TEST(Slices, SeparateNormalsWhereTheyDifferMoreThanPositions) {
  Receivers receivers = two_sheets(4096, 0.001f);
  for (Vec3& p : receivers.p) p.x *= 0.05f, p.y *= 0.05f;  // normals weigh 0.05: they lie 0.1 apart
  const Slices slices = make_slices(receivers, 1, {});
  std::size_t minority = 0;
  for (std::size_t s = 0; s < slices.size(); ++s) {
    const auto rows = slices.rows(s);
    const auto up = static_cast<std::size_t>(
        std::count_if(rows.begin(), rows.end(), [&](ReceiverId i) { return receivers.n[index(i)].z > 0; }));
    minority += std::min(up, rows.size() - up);
  }
  // The sheets do not hold whole slices: what one has too many lies with the other.
  const auto up = std::count_if(receivers.n.begin(), receivers.n.end(), [](Vec3 n) { return n.z > 0; });
  EXPECT_EQ(minority, static_cast<std::size_t>(std::abs(up - 2048)));
}

}  // namespace
}  // namespace myrialux
