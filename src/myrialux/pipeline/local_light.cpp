// Next-event and residual rays of every receiver.
#include "myrialux/pipeline/local_light.h"

#include <vector>

#include "myrialux/base/parallel.h"

namespace myrialux {

PathCounters add_local_light(const World& world, const Receivers& receivers, const LocalLightParams& params,
                             std::span<Rgb> radiance, Progress& progress) {
  constexpr std::size_t kBlock = 4096;
  const std::size_t n_blocks = (receivers.size() + kBlock - 1) / kBlock;
  std::vector<PathCounters> counters(n_blocks);
  progress.stage("direct", receivers.size(), "receivers");
  parallel_for(n_blocks, [&](std::size_t block) {
    const std::size_t end = std::min(receivers.size(), (block + 1) * kBlock);
    for (std::size_t i = block * kBlock; i < end; ++i) {
      const Vertex vertex = receiver_vertex(world, receivers, i);
      if (params.direct) {
        Rng rng(params.key, Stage::direct, receivers.first_sample + receivers.sample[i]);
        radiance[i] += next_event(world, vertex, Lobes::wide, /*mis=*/params.residual, rng, counters[block],
                                  params.direct_samples);
      }
      if (params.residual) {
        Rng rng(params.key, Stage::residual, receivers.first_sample + receivers.sample[i]);
        const ResidualParams residual{.clamp_distance = params.clamp_distance,
                                      .direct_by_sampling = params.direct,
                                      .direct_samples = params.direct_samples,
                                      .depth = receivers.depth[i]};
        radiance[i] += residual_radiance(world, vertex, residual, rng, counters[block]);
      }
    }
    progress.advance(end - block * kBlock);
  });
  PathCounters sum;
  for (const PathCounters& c : counters) sum += c;
  return sum;
}

}  // namespace myrialux
