// The least distance of virtual lights: a share of the scene's size as the camera sees it, or a length.
#pragma once

#include <span>

#include "myrialux/receivers/receivers.h"

namespace myrialux {

/// Receivers of so many samples of each pixel tell the scene's size. Not all, so that a picture of many samples does
/// not depend on how many of them are held at once.
inline constexpr int kSizeSamples = 4;

/// Positions of those, of a whole picture of `spp` samples a pixel.
Array<Vec3> size_points(const Receivers& receivers, int spp);

/// Half the diagonal of the box that holds the middle 96 % of the points along each axis: a scene size that one far
/// ground plane does not spoil.
float robust_radius(std::span<const Vec3> points);

/// Least distance that counts, in scene units; 0: none. @param clamp, clamp_distance as in RenderParams
float clamp_length(float clamp, float clamp_distance, std::span<const Vec3> points);

}  // namespace myrialux
