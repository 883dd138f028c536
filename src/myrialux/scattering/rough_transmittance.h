// How much light passes a rough dielectric coat: tables over roughness and angle that rough plastic needs.
#pragma once

#include <cstddef>

#include "myrialux/scene/scene.h"

namespace myrialux {

inline constexpr std::size_t kTransmittanceNodes = 64;  ///< cosines k / 63 of a table's row

/// Refers to two neighbouring rows of a table that lives as long as the program; costs nothing to copy.
struct RoughTransmittance {
  const float* row = nullptr;      ///< [2 * kTransmittanceNodes]: the row below alpha, then the row above
  float mix = 0;                   ///< share of the row above
  float internal_reflectance = 0;  ///< cosine-weighted mean reflectance from inside
};

/// Table for a coat of this roughness and index (interior / exterior). Alpha above 1.97 counts as 1.97.
/// The first call near an alpha integrates (15 ms a row for GGX, 50 ms for Beckmann); later calls look up. Thread-safe;
/// the values do not depend on the order of calls.
RoughTransmittance rough_transmittance(Microfacets distribution, float alpha, float eta);

/// Transmitted share of light arriving from outside at cosine cos_theta in [0, 1]: linear between nodes.
inline float external_transmittance(const float* row, float mix, float cos_theta) {
  const float x = cos_theta * static_cast<float>(kTransmittanceNodes - 1);
  const std::size_t i =
      static_cast<std::size_t>(x) < kTransmittanceNodes - 2 ? static_cast<std::size_t>(x) : kTransmittanceNodes - 2;
  const float t = x - static_cast<float>(i);
  const float* above = row + kTransmittanceNodes;
  return (1 - mix) * ((1 - t) * row[i] + t * row[i + 1]) + mix * ((1 - t) * above[i] + t * above[i + 1]);
}

}  // namespace myrialux
