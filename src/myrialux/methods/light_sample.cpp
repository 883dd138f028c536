// Variances from sampled walks. Walks are independent and alike, so n of them vary n times as much as one; the
// representatives of a cut's nodes are drawn independently, so their variances add up.
#include "myrialux/methods/light_sample.h"

#include <algorithm>

#include "myrialux/base/assert.h"
#include "myrialux/kernels/shade_block.h"
#include "myrialux/shading/shade_entries.h"
#include "myrialux/visibility/slice_visibility.h"

namespace myrialux {
namespace {

constexpr std::size_t kColumnsAtOnce = 256;
constexpr std::uint32_t kLeastWalks = 64;  ///< of a class: a variance from fewer is worth little

/// Lights of the class joined at a time, and where their entries go.
struct Batch {
  std::span<const ReceiverId> rows;
  std::vector<Column> columns;
  std::span<float> x;  ///< [columns x rows]
};

/// @return rays traced
std::uint64_t join(const FrameView& frame, const Batch& batch, float clamp_distance) {
  const std::size_t n_rows = batch.rows.size();
  SliceVisibility source(frame.world, frame.receivers, batch.rows, frame.lights, batch.columns, /*cull=*/true);
  BitMatrix visible(n_rows, batch.columns.size());
  trace_all(source, visible);
  std::vector<float> entries(batch.columns.size() * kBlockRows);
  shade_entries(frame.world, frame.receivers, batch.rows, frame.lights, batch.columns, visible,
                {.clamp_distance = clamp_distance}, entries);
  for (std::size_t r = 0; r < n_rows; ++r) {
    const float beta = luminance(frame.receivers.beta[index(batch.rows[r])]);
    for (std::size_t k = 0; k < batch.columns.size(); ++k) batch.x[k * n_rows + r] = beta * entries[k * kBlockRows + r];
  }
  return source.rays();
}

}  // namespace

WalkClasses deal_walks(const VirtualLights& lights, const LightTree& tree, std::uint32_t n_lights) {
  WalkClasses classes;
  classes.walks = find_walks(lights);
  const double n_found = classes.walks.n_found;
  const double walks_a_class =
      std::max<double>(kLeastWalks, n_lights * n_found / static_cast<double>(std::max<std::size_t>(1, lights.size())));
  classes.n_classes = static_cast<std::uint32_t>(std::max(1.0, n_found / walks_a_class));

  // Counting sort by class; places stay in order.
  const auto class_of = [&](LightId j) { return classes.walks.of[index(j)] % classes.n_classes; };
  classes.begin.assign(classes.n_classes + 1, 0);
  for (const LightId j : tree.order) ++classes.begin[class_of(j) + 1];
  for (std::uint32_t c = 0; c < classes.n_classes; ++c) classes.begin[c + 1] += classes.begin[c];
  classes.places.resize(tree.order.size());
  std::vector<std::size_t> next(classes.begin.begin(), classes.begin.end() - 1);
  for (std::uint32_t l = 0; l < tree.n_lights(); ++l) classes.places[next[class_of(tree.order[l])]++] = l;
  return classes;
}

LightSample::LightSample(const FrameView& frame, const LightTree& tree, const WalkClasses& classes,
                         std::uint32_t sampled_class, std::span<const ReceiverId> rows, float clamp_distance)
    : tree_(tree), classes_(classes), class_(sampled_class), n_rows_(rows.size()) {
  MYRIALUX_ASSERT(rows.size() <= kBlockRows && sampled_class < classes.n_classes);
  const std::span<const std::uint32_t> places = classes.places_of(class_);
  x_.resize(places.size() * n_rows_);
  for (std::size_t first = 0; first < places.size(); first += kColumnsAtOnce) {
    const std::size_t n = std::min(kColumnsAtOnce, places.size() - first);
    Batch batch{rows, {}, std::span(x_).subspan(first * n_rows_, n * n_rows_)};
    for (const std::uint32_t l : places.subspan(first, n)) batch.columns.push_back({.light = tree.order[l]});
    rays_ += join(frame, batch, clamp_distance);
  }
  sum_walks(places);
}

/// Walks of the class that left no lights count as zeros: their number follows from that of all walks.
void LightSample::sum_walks(std::span<const std::uint32_t> places) {
  const Walks& walks = classes_.walks;
  const std::uint32_t n_found = classes_.walks_of(class_);
  if (n_found == 0) return;
  const double n_sampled = walks.n_made * n_found / walks.n_found;
  std::vector<double> by_walk(n_found * n_rows_);
  for (std::size_t k = 0; k < places.size(); ++k) {
    const std::uint32_t walk = walks.of[index(tree_.order[places[k]])] / classes_.n_classes;
    for (std::size_t r = 0; r < n_rows_; ++r) by_walk[walk * n_rows_ + r] += static_cast<double>(x_[k * n_rows_ + r]);
  }
  for (std::size_t r = 0; r < n_rows_; ++r) {
    double sum = 0, squares = 0;
    for (std::uint32_t w = 0; w < n_found; ++w) {
      const double x = by_walk[w * n_rows_ + r];
      sum += x, squares += x * x;
    }
    radiance_ += sum * walks.n_made / n_sampled;
    if (n_sampled > 1)
      light_set_variance_ += walks.n_made / (n_sampled - 1) * std::max(0.0, squares - sum * sum / n_sampled);
  }
}

double LightSample::cluster_variance(std::span<const std::uint32_t> nodes) const {
  const std::span<const std::uint32_t> places = classes_.places_of(class_);
  double variance = 0;
  for (const std::uint32_t node : nodes) {
    const std::uint32_t first = tree_.nodes[node].first, end = first + tree_.nodes[node].count;
    if (end - first < 2) continue;
    const auto from = std::lower_bound(places.begin(), places.end(), first);
    const auto to = std::lower_bound(from, places.end(), end);
    if (to - from < 2) continue;
    double importance = 0, sums[kBlockRows] = {}, squares = 0;
    for (auto l = from; l != to; ++l) {
      const double own = static_cast<double>(tree_.importance[index(tree_.order[*l])]);
      const float* x = &x_[static_cast<std::size_t>(l - places.begin()) * n_rows_];
      double own_squares = 0;
      for (std::size_t r = 0; r < n_rows_; ++r) {
        const double value = static_cast<double>(x[r]);
        sums[r] += value, own_squares += value * value;
      }
      importance += own, squares += own_squares / own;
    }
    double spread = importance * squares;
    for (std::size_t r = 0; r < n_rows_; ++r) spread -= sums[r] * sums[r];
    variance += std::max(0.0, spread);
  }
  const double all = classes_.walks.n_found, some = classes_.walks_of(class_);
  return some < 2 ? variance : variance * all * (all - 1) / (some * (some - 1));
}

}  // namespace myrialux
