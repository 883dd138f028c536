// Every receiver, every virtual light, every ray: the reference for a given set of lights.
#pragma once

#include <span>

#include "myrialux/base/progress.h"
#include "myrialux/transfer/transfer.h"

namespace myrialux {

struct BruteForceCounters {
  std::uint64_t entries = 0, traced = 0;
};

/// Adds up L_i = sum_j V_ij T_ij over all lights; beta not applied. @param radiance [n_receivers], set
BruteForceCounters brute_force(const World& world, const Receivers& receivers, const VirtualLights& lights,
                               float clamp_distance, std::span<Rgb> radiance, Progress& progress);

}  // namespace myrialux
