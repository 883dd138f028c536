// Time of completions without rays: whole, by row rate and number of columns, and parts (drawing Omega, matching,
// updating d, the pseudo-inverse). Counter `ns/column`; `traced` is the share of entries asked of the source.
#include <benchmark/benchmark.h>

#include <Eigen/Dense>
#include <utility>

#include "myrialux/completion/amc.h"
#include "myrialux/completion/bamc.h"
#include "myrialux/completion/column_basis.h"
#include "myrialux/completion/gauss_jordan.h"
#include "myrialux/completion/matrix_separation.h"
#include "myrialux/completion/projection.h"
#include "myrialux/completion/row_distribution.h"
#include "myrialux/matrix/known_entries.h"

namespace myrialux {
namespace {

constexpr std::size_t kRows = 1024, kColumns = 1000;

/// n_distinct columns of some ten runs, strewn with single flips if `noisy`; a third of the rows is inactive if
/// `culled`, in runs as well.
KnownEntries shadows(std::size_t n_distinct, bool noisy, bool culled, std::size_t n_columns = kColumns,
                     std::size_t n_groups = 1) {
  Rng rng({1}, Stage::test, n_distinct);
  const auto runs = [&](MutableWords column, std::uint32_t length) {
    bool bit = rng.below(2) == 1;
    for (std::size_t i = 0; i < kRows; ++i) {
      if (rng.below(length) == 0) bit = !bit;
      if (bit) set_bit(column, i);
    }
  };
  BitMatrix basis(kRows, n_distinct), truth(kRows, n_columns), active(kRows, n_columns);
  for (std::size_t q = 0; q < n_distinct; ++q) runs(basis.column(q), 100);
  for (std::size_t j = 0; j < n_columns; ++j) {
    fill_rows(active.column(j), kRows);
    if (culled)
      for (std::size_t i = 0; i < kRows; ++i)
        if ((i + 7 * (j / 50)) % 300 < 100) clear_bit(active.column(j), i);
    const Words from = std::as_const(basis).column(rng.below(static_cast<std::uint32_t>(n_distinct)));
    for (std::size_t w = 0; w < from.size(); ++w) truth.column(j)[w] = from[w];
    if (noisy && rng.below(4) == 0) truth.column(j)[rng.below(16)] ^= 0xffull << rng.below(56);
    for (std::size_t w = 0; w < from.size(); ++w) truth.column(j)[w] &= active.column(j)[w];
  }
  std::vector<std::size_t> group_ends;
  for (std::size_t g = 1; g <= n_groups; ++g) group_ends.push_back(n_columns * g / n_groups);
  return {truth, active, group_ends};
}

void report(benchmark::State& state, double n_columns) {
  state.counters["ns/column"] =
      benchmark::Counter(n_columns * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void completion(benchmark::State& state) {
  KnownEntries source = shadows(static_cast<std::size_t>(state.range(0)), state.range(1) != 0, state.range(2) != 0);
  CompletionStats stats;
  for (auto _ : state) {
    BitMatrix visible(kRows, kColumns);
    Rng rng({1}, Stage::visibility, 0);
    stats = complete_bamc(source, {}, rng, visible);
    benchmark::DoNotOptimize(visible);
  }
  report(state, kColumns);
  state.counters["traced"] = static_cast<double>(stats.traced) / static_cast<double>(stats.entries);
  state.counters["full"] = static_cast<double>(stats.full_columns);
}
BENCHMARK(completion)
    ->ArgNames({"distinct", "noisy", "culled"})
    ->ArgsProduct({{8, 64}, {0, 1}, {0, 1}})
    ->Unit(benchmark::kMicrosecond);

enum Method { kBamc, kAmc, kGaussJordan, kGuesses, kSeparation };

CompletionStats complete(Method method, const RowRates& rates, EntrySource& source, Rng& rng, BitMatrix& visible) {
  switch (method) {
    case kBamc:
      return complete_bamc(source, rates, rng, visible);
    case kAmc:
      return complete_amc(source, {.rows = rates}, rng, visible);
    case kGaussJordan:
      return complete_gauss_jordan(source, rates, rng, visible);
    case kGuesses:
      return complete_separation(source, {.separate = false}, rng, visible);
    case kSeparation:
      return complete_separation(source, {}, rng, visible);
  }
  return {};
}

/// A slice as in a room: eight groups, some columns that are like no other.
void run_slice(benchmark::State& state, Method method, const RowRates& rates, std::size_t n_columns) {
  KnownEntries source = shadows(24, true, true, n_columns, 8);
  CompletionStats stats;
  for (auto _ : state) {
    BitMatrix visible(kRows, n_columns);
    Rng rng({1}, Stage::visibility, 0);
    stats = complete(method, rates, source, rng, visible);
    benchmark::DoNotOptimize(visible);
  }
  state.counters["traced"] = static_cast<double>(stats.traced) / static_cast<double>(stats.entries);
  state.counters["full"] = static_cast<double>(stats.full_columns);
}

/// method: 0 bamc, 1 amc, 2 gauss-jordan, 3 matrix-separation without and 4 with the separation
void slice(benchmark::State& state) { run_slice(state, static_cast<Method>(state.range(0)), {}, kColumns); }
BENCHMARK(slice)->ArgNames({"method"})->DenseRange(0, 4)->Unit(benchmark::kMillisecond);

/// Scaling with the row rate, fixed. [wang20, figure 11 left]
void row_rate(benchmark::State& state) {
  const RowRates rates{.alpha = static_cast<float>(state.range(1)) / 100, .omega = 1, .adaptive = false};
  run_slice(state, static_cast<Method>(state.range(0)), rates, kColumns);
}
BENCHMARK(row_rate)
    ->ArgNames({"method", "percent"})
    ->ArgsProduct({{0, 1, 2}, {3, 5, 10, 20, 40}})
    ->Unit(benchmark::kMillisecond);

/// Scaling with the number of columns at a rate of 10 %. [wang20, figure 11 right]
void column_count(benchmark::State& state) {
  run_slice(state, static_cast<Method>(state.range(0)), {.alpha = 0.1f, .adaptive = false},
            static_cast<std::size_t>(state.range(1)));
}
BENCHMARK(column_count)
    ->ArgNames({"method", "columns"})
    ->ArgsProduct({{0, 1, 2}, {250, 500, 1000, 2000, 4000}})
    ->Unit(benchmark::kMillisecond);

/// One projection onto sampled columns of a room-like slice, by Eigen's SVD and as amc does it.
void projection(benchmark::State& state) {
  const bool by_svd = state.range(0) != 0;
  const auto n_rows = static_cast<std::size_t>(state.range(1)), n_columns = static_cast<std::size_t>(state.range(2));
  const KnownEntries source = shadows(24, true, false);
  const std::size_t words = words_for(n_rows);
  std::vector<std::uint64_t> packed(n_columns * words), x(words);
  Eigen::MatrixXd dense(n_rows, n_columns);
  Eigen::VectorXd right(n_rows);
  for (std::size_t k = 0; k < n_rows; ++k) {
    const std::size_t i = k * kRows / n_rows;
    for (std::size_t j = 0; j < n_columns; ++j) {
      const bool bit = source.truth().test(i, j);
      if (bit) set_bit(MutableWords(packed).subspan(j * words, words), k);
      dense(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(j)) = bit;
    }
    if (source.truth().test(i, n_columns)) set_bit(x, k);
    right[static_cast<Eigen::Index>(k)] = source.truth().test(i, n_columns);
  }
  BitProjection bits;
  for (auto _ : state) {
    if (by_svd) {
      const Eigen::BDCSVD<Eigen::MatrixXd> svd(dense, Eigen::ComputeThinU | Eigen::ComputeThinV);
      benchmark::DoNotOptimize(svd.solve(right).eval().data());
    } else {
      benchmark::DoNotOptimize(bits.solve(n_rows, n_columns, packed, x).data());
    }
  }
}
BENCHMARK(projection)
    ->ArgNames({"svd", "rows", "columns"})
    ->ArgsProduct({{0, 1}, {26, 102, 410}, {20, 100}})
    ->Unit(benchmark::kMicrosecond);

/// d after some full columns, as in the midst of a group.
RowDistribution used_distribution(const KnownEntries& source, std::size_t n_columns) {
  RowDistribution d;
  d.reset(kRows);
  for (std::size_t j = 0; j < n_columns; ++j) d.add_column(source.active(j), source.truth().column(j));
  return d;
}

void draw_omega(benchmark::State& state) {
  const KnownEntries source = shadows(16, true, state.range(1) != 0);
  RowDistribution d = used_distribution(source, 20);
  Rng rng({1}, Stage::visibility, 0);
  std::vector<std::uint64_t> omega(words_for(kRows));
  for (auto _ : state) {
    std::fill(omega.begin(), omega.end(), 0);
    d.draw(static_cast<std::size_t>(state.range(0)), source.active(5), rng, omega);
    benchmark::DoNotOptimize(omega.data());
  }
  report(state, 1);
}
BENCHMARK(draw_omega)->ArgNames({"rows", "culled"})->ArgsProduct({{26, 102, 410}, {0, 1}});

void draw_pi(benchmark::State& state) {
  const KnownEntries source = shadows(16, true, state.range(1) != 0);
  RowDistribution d = used_distribution(source, 1);
  Rng rng({1}, Stage::visibility, 0);
  std::vector<std::uint64_t> pi(words_for(kRows));
  for (auto _ : state) {
    std::fill(pi.begin(), pi.end(), 0);
    d.draw_uniform(static_cast<std::size_t>(state.range(0)), source.active(5), rng, pi);
    benchmark::DoNotOptimize(pi.data());
  }
  report(state, 1);
}
BENCHMARK(draw_pi)->ArgNames({"rows", "culled"})->ArgsProduct({{26}, {0, 1}});

void update_distribution(benchmark::State& state) {
  const KnownEntries source = shadows(64, true, state.range(0) != 0);
  RowDistribution d;
  Rng rng({1}, Stage::visibility, 0);
  std::vector<std::uint64_t> omega(words_for(kRows));
  std::size_t j = 0;
  for (auto _ : state) {
    if (j % kColumns == 0) d.reset(kRows);  // as often as a group begins
    d.add_column(source.active(j % kColumns), source.truth().column(j % kColumns));
    std::fill(omega.begin(), omega.end(), 0);
    d.draw(1, source.active(j++ % kColumns), rng, omega);  // sums are taken at the first draw
  }
  report(state, 1);
}
BENCHMARK(update_distribution)->ArgNames({"culled"})->ArgsProduct({{0, 1}});

void match(benchmark::State& state) {
  const KnownEntries source = shadows(64, true, false);
  const std::size_t n_basis = static_cast<std::size_t>(state.range(0));
  ColumnBasis basis;
  basis.reset(words_for(kRows));
  for (std::size_t j = 0; j < n_basis; ++j) basis.add(source.truth().column(j), source.active(j));
  RowDistribution d = used_distribution(source, 20);
  Rng rng({1}, Stage::visibility, 0);
  std::vector<std::uint64_t> omega(words_for(kRows)), samples(omega.size());
  d.draw(26, source.active(0), rng, omega);
  std::size_t j = 0;
  for (auto _ : state) {
    const Words truth = source.truth().column(++j % kColumns);
    for (std::size_t w = 0; w < omega.size(); ++w) samples[w] = truth[w] & omega[w];
    benchmark::DoNotOptimize(basis.find(samples, omega).size());
  }
  report(state, 1);
}
BENCHMARK(match)->ArgNames({"columns"})->ArgsProduct({{8, 64, 256}});

}  // namespace
}  // namespace myrialux
