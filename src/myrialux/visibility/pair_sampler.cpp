// Samples the visibility of a pair of clusters, part by part. [bus15, 3, algorithm 2]
// Deviations: entries whose transfer is zero are neither traced nor asked; rays of samples are kept where their parts
// are traced whole.
#include "myrialux/visibility/pair_sampler.h"

#include <algorithm>
#include <array>
#include <bit>

#include "myrialux/base/assert.h"
#include "myrialux/transfer/transfer.h"

namespace myrialux {

/// Up to 16 places that go into one packet.
struct PairSampler::Samples {
  std::array<std::uint32_t, kMaxPairSamples> place{};
  std::uint32_t n = 0;
  std::uint32_t active = 0, visible = 0;  ///< bits
};

namespace {

void append(VisibleRun run, std::vector<VisibleRun>& runs, std::size_t first_run) {
  if (runs.size() > first_run && runs.back().end == run.first)
    runs.back().end = run.end;
  else
    runs.push_back(run);
}

std::uint32_t part_begin(std::uint32_t first, std::uint32_t count, std::uint32_t part, std::uint32_t n_parts) {
  return first + static_cast<std::uint32_t>(std::uint64_t{count} * part / n_parts);
}

}  // namespace

void PairSampler::sample(std::uint32_t first, std::uint32_t count, LightId light, std::vector<VisibleRun>& runs) {
  MYRIALUX_ASSERT(params_.least >= 2 && params_.least <= kMaxLeastPoints);
  MYRIALUX_ASSERT(params_.samples <= kMaxPairSamples && params_.few_samples <= kMaxPairSamples);
  MYRIALUX_ASSERT(params_.samples >= 2 && params_.few_samples >= 2);
  if (count < params_.least) return trace_all(first, count, light, {}, runs);
  const std::uint32_t n_parts = std::min(count > params_.large ? params_.samples : params_.few_samples, count);
  Samples samples;
  samples.n = n_parts;
  for (std::uint32_t k = 0; k < n_parts; ++k) {
    const std::uint32_t begin = part_begin(first, count, k, n_parts), end = part_begin(first, count, k + 1, n_parts);
    samples.place[k] = begin + (end - begin) / 2;
  }
  trace(light, samples);

  if (samples.active != 0 && samples.visible == samples.active) {
    append({first, first + count}, runs, runs.size());
  } else if (samples.active == 0 || samples.visible != 0) {
    const bool small_parts = count <= n_parts * (params_.least - 1);  // even the largest has fewer than `least` points
    if (small_parts) return trace_all(first, count, light, samples, runs);
    for (std::uint32_t k = 0; k < n_parts; ++k) {
      const std::uint32_t begin = part_begin(first, count, k, n_parts);
      sample(begin, part_begin(first, count, k + 1, n_parts) - begin, light, runs);
    }
  }
}

void PairSampler::trace(LightId light, Samples& samples) {
  Segments<kMaxPairSamples> segments{};
  bool distant = false;
  for (std::uint32_t k = 0; k < samples.n; ++k) {
    const ReceiverId row = order_[samples.place[k]];
    if (!is_active(world_, receivers_, row, lights_, light)) continue;
    samples.active |= 1u << k;
    const Segment s = shadow_segment(receivers_, row, lights_, light);
    distant = s.distant;
    segments.from_x[k] = s.from.x, segments.from_y[k] = s.from.y, segments.from_z[k] = s.from.z;
    segments.to_x[k] = s.to.x, segments.to_y[k] = s.to.y, segments.to_z[k] = s.to.z;
  }
  if (samples.active == 0) return;
  rays_ += static_cast<std::uint64_t>(std::popcount(samples.active));
  const std::uint32_t blocked =
      distant ? world_.tracer.occluded_packet_direction<kMaxPairSamples>(segments, samples.active, true)
              : world_.tracer.occluded_packet<kMaxPairSamples>(segments, samples.active, true);
  samples.visible = samples.active & ~blocked;
}

void PairSampler::trace_all(std::uint32_t first, std::uint32_t count, LightId light, const Samples& known,
                            std::vector<VisibleRun>& runs) {
  const std::size_t first_run = runs.size();
  Samples packet;
  std::uint32_t next_known = 0;
  std::array<std::uint8_t, kMaxPairSamples * kMaxLeastPoints> visible{};
  MYRIALUX_ASSERT(count <= visible.size());
  const auto flush = [&] {
    trace(light, packet);
    for (std::uint32_t k = 0; k < packet.n; ++k) visible[packet.place[k] - first] = packet.visible >> k & 1;
    packet = {};
  };
  for (std::uint32_t place = first; place < first + count; ++place) {
    if (next_known < known.n && known.place[next_known] == place) {
      visible[place - first] = known.visible >> next_known++ & 1;
      continue;
    }
    packet.place[packet.n++] = place;
    if (packet.n == kMaxPairSamples) flush();
  }
  if (packet.n > 0) flush();
  for (std::uint32_t k = 0; k < count; ++k)
    if (visible[k]) append({first + k, first + k + 1}, runs, first_run);
}

}  // namespace myrialux
