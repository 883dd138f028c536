// What each receiver adds by rays of its own: sampled direct light and what virtual lights cannot carry.
#pragma once

#include <span>

#include "myrialux/base/progress.h"
#include "myrialux/receivers/receivers.h"

namespace myrialux {

struct LocalLightParams {
  bool direct = true;        ///< next-event estimation; false: direct light comes from virtual lights
  int direct_samples = 1;    ///< emitter samples a receiver
  bool residual = true;      ///< see residual_radiance()
  float clamp_distance = 0;  ///< as the virtual lights were clamped
  RandomKey key;
};

/// Adds to radiance[i] (beta not applied). Random numbers belong to the camera sample.
PathCounters add_local_light(const World& world, const Receivers& receivers, const LocalLightParams& params,
                             std::span<Rgb> radiance, Progress& progress);

}  // namespace myrialux
