// Every receiver, every virtual light, every ray. Plain on purpose: transfer() entry by entry, sums in order of lights.
#include "myrialux/reference/brute_force.h"

#include <array>
#include <bit>
#include <vector>

#include "myrialux/base/assert.h"
#include "myrialux/base/parallel.h"

namespace myrialux {
namespace {

constexpr int kRows = 16;  ///< receivers of one packet; all their shadow rays go to one light

struct RowSums {
  std::array<double, kRows> r{}, g{}, b{};
};
void add_column(const World& world, const Receivers& receivers, std::size_t first, int n_rows,
                const VirtualLights& lights, std::size_t j, float clamp_distance, RowSums& sums,
                BruteForceCounters& counters);

}  // namespace

BruteForceCounters brute_force(const World& world, const Receivers& receivers, const VirtualLights& lights,
                               float clamp_distance, std::span<Rgb> radiance, Progress& progress) {
  MYRIALUX_ASSERT(radiance.size() == receivers.size());
  const std::size_t n_blocks = (receivers.size() + kRows - 1) / kRows;
  std::vector<BruteForceCounters> counters(n_blocks);
  progress.stage("brute force", receivers.size(), "receivers");
  parallel_for(n_blocks, [&](std::size_t block) {
    const std::size_t first = block * kRows;
    const int n_rows = static_cast<int>(std::min<std::size_t>(kRows, receivers.size() - first));
    RowSums sums;
    for (std::size_t j = 0; j < lights.size(); ++j)
      add_column(world, receivers, first, n_rows, lights, j, clamp_distance, sums, counters[block]);
    for (int k = 0; k < n_rows; ++k) {
      const auto row = static_cast<std::size_t>(k);
      radiance[first + row] = {static_cast<float>(sums.r[row]), static_cast<float>(sums.g[row]),
                               static_cast<float>(sums.b[row])};
    }
    progress.advance(static_cast<std::uint64_t>(n_rows));
  });
  BruteForceCounters total;
  for (const BruteForceCounters& c : counters) total.entries += c.entries, total.traced += c.traced;
  return total;
}

namespace {

void add_column(const World& world, const Receivers& receivers, std::size_t first, int n_rows,
                const VirtualLights& lights, std::size_t j, float clamp_distance, RowSums& sums,
                BruteForceCounters& counters) {
  Segments<kRows> segments{};
  std::array<Rgb, kRows> entries{};
  std::uint32_t valid = 0;
  const auto column = static_cast<LightId>(j);
  for (int k = 0; k < n_rows; ++k) {
    const auto row = static_cast<ReceiverId>(first + static_cast<std::size_t>(k));
    const Rgb entry = transfer(world, receivers, row, lights, column, clamp_distance);
    if (is_black(entry)) continue;
    entries[static_cast<std::size_t>(k)] = entry;
    valid |= 1u << k;
    const Segment s = shadow_segment(receivers, row, lights, column);
    segments.from_x[k] = s.from.x, segments.from_y[k] = s.from.y, segments.from_z[k] = s.from.z;
    segments.to_x[k] = s.to.x, segments.to_y[k] = s.to.y, segments.to_z[k] = s.to.z;
  }
  counters.entries += static_cast<std::uint64_t>(n_rows);
  if (valid == 0) return;
  counters.traced += static_cast<std::uint64_t>(std::popcount(valid));
  const std::uint32_t blocked = lights.kind[j] == LightKind::directional
                                    ? world.tracer.occluded_packet_direction<kRows>(segments, valid, true)
                                    : world.tracer.occluded_packet<kRows>(segments, valid, true);
  for (std::size_t k = 0; k < kRows; ++k)
    if ((valid & ~blocked) >> k & 1u)
      sums.r[k] += static_cast<double>(entries[k].r), sums.g[k] += static_cast<double>(entries[k].g),
          sums.b[k] += static_cast<double>(entries[k].b);
}

}  // namespace
}  // namespace myrialux
