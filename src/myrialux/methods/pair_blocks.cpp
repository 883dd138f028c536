// A block is a small slice whose columns hold for some of its rows only.
#include "myrialux/methods/pair_blocks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "myrialux/base/clock.h"
#include "myrialux/shading/shade.h"
#include "myrialux/visibility/slice_visibility.h"

namespace myrialux {
namespace {

constexpr std::size_t kColumnsAtOnce = 1024;  ///< so that memory does not grow with the cut

/// Sorts by light and joins pairs with the same one.
void join_equal(std::vector<BlockPair>& pairs) {
  std::sort(pairs.begin(), pairs.end(), [](const BlockPair& a, const BlockPair& b) {
    return a.light != b.light ? a.light < b.light : a.covered < b.covered;
  });
  std::size_t n = 0;
  for (const BlockPair& pair : pairs) {
    if (n > 0 && pairs[n - 1].light == pair.light) {
      BlockPair& joined = pairs[n - 1];
      joined.covered |= pair.covered, joined.trace |= pair.trace, joined.visible |= pair.visible;
    } else {
      pairs[n++] = pair;
    }
  }
  pairs.resize(n);
}

void make_columns(const LightTree& tree, std::span<const BlockPair> pairs, std::vector<Column>& columns) {
  columns.clear();
  for (const BlockPair& pair : pairs) {
    const LightNode node = tree.node(pair.light);
    const LightId light = node.representative;
    columns.push_back({light, node.importance / tree.importance[index(light)], pair.light, node.count, 0});
  }
}

struct Counts {
  std::uint64_t entries = 0, traced = 0, covered = 0;
};

/// Bits of all pairs: traced ones and those known before.
Counts find_visible(SliceVisibility& source, std::span<const BlockPair> pairs, BitMatrix& visible) {
  Counts counts;
  for (std::size_t j = 0; j < pairs.size(); ++j) {
    const std::uint64_t active = source.active(j)[0], wanted = pairs[j].trace & active;
    if (wanted != 0) source.trace(j, Words(&wanted, 1), visible.column(j));
    visible.column(j)[0] |= pairs[j].visible & active;
    counts.entries += static_cast<std::uint64_t>(std::popcount(pairs[j].covered & active));
    counts.traced += static_cast<std::uint64_t>(std::popcount(wanted));
    counts.covered += static_cast<std::uint64_t>(std::popcount(pairs[j].covered));
  }
  return counts;
}

}  // namespace

PairReport& PairReport::operator+=(const PairReport& r) {
  bounds += r.bounds, pairs += r.pairs, covered += r.covered;
  entries += r.entries, traced += r.traced, rays += r.rays, blocks += r.blocks;
  radiance += r.radiance, clamped_away += r.clamped_away;
  cut_s += r.cut_s, visibility_s += r.visibility_s, shade_s += r.shade_s;
  memory_bytes = std::max(memory_bytes, r.memory_bytes);
  return *this;
}

void render_block(const FrameView& frame, const LightTree& tree, const PointNode& block,
                  std::span<const ReceiverId> rows, float clamp_distance, std::vector<BlockPair>& pairs,
                  MethodResult& result, PairReport& report) {
  join_equal(pairs);
  std::vector<Column> columns;
  std::array<Rgb, 64> sum{}, part{};
  Counts total;
  std::uint64_t memory_bytes = 0;
  ThreadStopwatch cpu;
  for (std::size_t first = 0; first < pairs.size(); first += kColumnsAtOnce) {
    const auto chunk = std::span(pairs).subspan(first, std::min(kColumnsAtOnce, pairs.size() - first));
    make_columns(tree, chunk, columns);
    SliceVisibility source(frame.world, frame.receivers, rows, frame.lights, columns, true);
    BitMatrix visible(rows.size(), columns.size());
    const Counts counts = find_visible(source, chunk, visible);
    total.entries += counts.entries, total.traced += counts.traced, total.covered += counts.covered;
    memory_bytes = std::max<std::uint64_t>(memory_bytes, source.memory_bytes() + visible.n_words() * 8);
    report.visibility_s += cpu.lap();
    const ShadeResult shade = shade_slice(frame.world, frame.receivers, rows, frame.lights, columns, visible,
                                          {.clamp_distance = clamp_distance}, std::span(part).first(rows.size()));
    for (std::size_t k = 0; k < rows.size(); ++k) sum[k] += part[k];
    report.radiance += shade.radiance_sum, report.clamped_away += shade.clamped_away_sum;
    report.shade_s += cpu.lap();
  }

  const float n_rows = static_cast<float>(rows.size()), n_entries = static_cast<float>(total.entries);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::size_t i = index(rows[k]);
    result.radiance[i] = sum[k];
    result.slice[i] = block.first;
    result.cut_size[i] = static_cast<float>(total.covered) / n_rows;
    result.visibility_fraction[i] = total.entries > 0 ? static_cast<float>(total.traced) / n_entries : 0.0f;
  }
  report.entries += total.entries, report.traced += total.traced, report.rays += total.traced;
  report.covered += total.covered, ++report.blocks;
  report.memory_bytes = std::max(report.memory_bytes, memory_bytes + pairs.capacity() * sizeof(BlockPair));
}

}  // namespace myrialux
