// Error of the completion on shadow boundaries of discs and half-planes, light leaks and dark patches apart: recorded
// bounds, and importance sampling against uniform sampling.
#include <gtest/gtest.h>

#include <cmath>

#include "myrialux/completion/bamc.h"
#include "support/shadow_matrices.h"

namespace myrialux {
namespace {

using test::bumpy;
using test::count_wrong;
using test::half_plane;
using test::ShadowScene;
using test::two_discs;
using test::WrongBits;

/// Mean over independent matrices and its standard error.
class Mean {
 public:
  void add(double x) { sum_ += x, squares_ += x * x, ++n_; }
  double value() const { return sum_ / n_; }
  double error() const { return std::sqrt(std::max(squares_ / n_ - value() * value(), 0.0) / (n_ - 1)); }

 private:
  double sum_ = 0, squares_ = 0;
  int n_ = 0;
};

struct Result {
  WrongBits wrong;
  CompletionStats stats;
};
Result run(const ShadowScene& scene, const BamcParams& params, std::uint64_t item) {
  Rng make({7}, Stage::test, item), draw({1}, Stage::visibility, item);
  KnownEntries source = scene.entries(make);
  BitMatrix visible(source.n_rows(), source.n_columns());
  const CompletionStats stats = complete_bamc(source, params, draw, visible);
  return {count_wrong(source, visible), stats};
}

struct Bound {
  const char* name;
  ShadowScene scene;
  /// Percent of the active entries, and of them traced; measured over 24 matrices, mean plus 4 standard errors.
  double false_visible, false_occluded, traced;
};

TEST(BamcError, StaysInsideTheRecordedBoundsOfEachKind) {
  // 256 columns are few: each shadow boundary is new to most of them, and most are traced whole.
  const Bound bounds[] = {
      {"discs", two_discs(), 0.052, 0.054, 65.7},
      {"half-plane", half_plane(), 0.035, 0.030, 24.1},
      {"discs, bumpy rows", bumpy(two_discs()), 0.024, 0.096, 54.4},
      {"half-plane, bumpy rows", bumpy(half_plane()), 0.054, 0.044, 36.8},
  };
  for (const Bound& b : bounds) {
    Mean visible, occluded, traced;
    for (std::uint64_t item = 0; item < 24; ++item) {
      const Result r = run(b.scene, {}, item);
      visible.add(100 * r.wrong.visible_rate());
      occluded.add(100 * r.wrong.occluded_rate());
      traced.add(100 * static_cast<double>(r.stats.traced) / static_cast<double>(r.stats.entries));
    }
    EXPECT_LT(visible.value(), b.false_visible) << b.name << ": light leaks, % +- " << visible.error();
    EXPECT_LT(occluded.value(), b.false_occluded) << b.name << ": dark patches, % +- " << occluded.error();
    EXPECT_LT(traced.value(), b.traced) << b.name << ": traced, % +- " << traced.error();
  }
}

TEST(BamcError, ImportanceSamplingBeatsUniformSamplingWithFewerRays) {
  // The same matrices at a fixed rate: only where the samples lie differs.
  for (const ShadowScene& scene : {two_discs(), bumpy(two_discs()), bumpy(half_plane())}) {
    Mean gain, saved;
    for (std::uint64_t item = 0; item < 24; ++item) {
      const Result importance = run(scene, {.alpha = 0.05f, .importance = true, .adaptive = false}, item);
      const Result uniform = run(scene, {.alpha = 0.05f, .importance = false, .adaptive = false}, item);
      gain.add(100 * (uniform.wrong.rate() - importance.wrong.rate()));
      saved.add(static_cast<double>(uniform.stats.traced) - static_cast<double>(importance.stats.traced));
    }
    EXPECT_GT(gain.value(), 3 * gain.error()) << "% fewer wrong entries";
    EXPECT_GT(saved.value(), -saved.error()) << "rays";
  }
}

TEST(BamcError, HigherRatesLeaveFewerErrors) {
  Mean low, high;
  for (std::uint64_t item = 0; item < 12; ++item) {
    low.add(run(bumpy(two_discs()), {.alpha = 0.02f, .adaptive = false}, item).wrong.rate());
    high.add(run(bumpy(two_discs()), {.alpha = 0.2f, .adaptive = false}, item).wrong.rate());
  }
  EXPECT_GT(low.value() - 3 * low.error(), high.value() + 3 * high.error());
}

}  // namespace
}  // namespace myrialux
