// Time of boolean completion without rays: whole, and its parts (drawing Omega, matching, updating d). Counter
// `ns/column`; `traced` is the share of entries asked of the source.
#include <benchmark/benchmark.h>

#include <utility>

#include "myrialux/completion/bamc.h"
#include "myrialux/completion/column_basis.h"
#include "myrialux/completion/row_distribution.h"
#include "myrialux/matrix/known_entries.h"

namespace myrialux {
namespace {

constexpr std::size_t kRows = 1024, kColumns = 1000;

/// n_distinct columns of some ten runs, strewn with single flips if `noisy`; a third of the rows is inactive if
/// `culled`, in runs as well.
KnownEntries shadows(std::size_t n_distinct, bool noisy, bool culled) {
  Rng rng({1}, Stage::test, n_distinct);
  const auto runs = [&](MutableWords column, std::uint32_t length) {
    bool bit = rng.below(2) == 1;
    for (std::size_t i = 0; i < kRows; ++i) {
      if (rng.below(length) == 0) bit = !bit;
      if (bit) set_bit(column, i);
    }
  };
  BitMatrix basis(kRows, n_distinct), truth(kRows, kColumns), active(kRows, kColumns);
  for (std::size_t q = 0; q < n_distinct; ++q) runs(basis.column(q), 100);
  for (std::size_t j = 0; j < kColumns; ++j) {
    fill_rows(active.column(j), kRows);
    if (culled)
      for (std::size_t i = 0; i < kRows; ++i)
        if ((i + 7 * (j / 50)) % 300 < 100) clear_bit(active.column(j), i);
    const Words from = std::as_const(basis).column(rng.below(static_cast<std::uint32_t>(n_distinct)));
    for (std::size_t w = 0; w < from.size(); ++w) truth.column(j)[w] = from[w];
    if (noisy && rng.below(4) == 0) truth.column(j)[rng.below(16)] ^= 0xffull << rng.below(56);
    for (std::size_t w = 0; w < from.size(); ++w) truth.column(j)[w] &= active.column(j)[w];
  }
  return {truth, active};
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
