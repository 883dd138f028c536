// Where shadow segments to a virtual light end, in the form the kernel reads; the twin of shadow_segment().
#pragma once

#include "myrialux/kernels/shadow_ends.h"
#include "myrialux/lights/virtual_lights.h"

namespace myrialux {

inline ShadowLight shadow_light(const VirtualLights& lights, std::size_t j) {
  ShadowLight light{};
  light.end = lights.kind[j] == LightKind::directional ? SegmentEnd::direction
              : lights.kind[j] == LightKind::point     ? SegmentEnd::open
                                                       : SegmentEnd::surface;
  const Vec3 p = light.end == SegmentEnd::direction ? -lights.n[j] : lights.p[j];
  for (int a = 0; a < 3; ++a) light.p[a] = p[a], light.ng[a] = lights.ng[j][a];
  light.offset = lights.offset[j];
  return light;
}

}  // namespace myrialux
