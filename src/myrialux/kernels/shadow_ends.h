// Both ends of the shadow segments from 16 rows to one light, moved off their surfaces.
#pragma once

#include <cstddef>
#include <cstdint>

namespace myrialux {

inline constexpr std::size_t kPacketRows = 16;
using PacketFloats = float[kPacketRows];

/// 16 rows, side by side in memory; each array starts at a multiple of 64 bytes.
struct PacketRows {
  const float* p[3];    ///< on the surface
  const float* ng[3];   ///< unit geometric normal
  const float* offset;  ///< how far along +-ng a ray must start
};

/// Where segments end.
enum class SegmentEnd : std::uint8_t {
  surface,    ///< on a surface: moved off it
  open,       ///< a point in the open
  direction,  ///< at infinity: `p` is the direction
};
struct ShadowLight {
  float p[3];
  float ng[3];
  float offset = 0;
  SegmentEnd end = SegmentEnd::surface;
};

/// Moves each end along its normal to the side where the other end lies. Writes from = {x, y, z}, to = {x, y, z}; for
/// directions `to` is the direction. Each output array starts at a multiple of 64 bytes.
/// Same bits as the scalar form on every instruction set. Cost: about 40 operations a row.
void shadow_ends(const PacketRows& rows, const ShadowLight& light, float* const from[3], float* const to[3]);
void shadow_ends_plain(const PacketRows& rows, const ShadowLight& light, float* const from[3], float* const to[3]);

/// Where rays are written, one a lane; each array starts at a multiple of 64 bytes.
struct PacketRays {
  float* origin[3];
  float* direction[3];     ///< to - from; for distant lights the direction towards them
  float* far;              ///< largest t that counts
  std::size_t stride = 0;  ///< floats from a packet's arrays to those of the next
};

/// shadow_ends() straight to rays: origin = from, direction = to - from, t up to `far` (distant lights: infinity).
/// Same bits on every instruction set. Cost: about 45 operations a row; whole vectors are stored, so that a tracer
/// which loads whole vectors need not wait for parts of them.
void shadow_rays(const PacketRows& rows, const ShadowLight& light, float far, const PacketRays& rays);
void shadow_rays_plain(const PacketRows& rows, const ShadowLight& light, float far, const PacketRays& rays);

/// Both ends known beforehand, as between one-sided rows and lights that face each other.
struct KnownEnd {
  float p[3];  ///< end, off its surface, or the direction
  bool distant = false;
};
/// Rays from `from` = {x, y, z} to one end, as shadow_rays() writes them: for each set bit q of `which`, those of rows
/// 16 q to 16 q + 15, in the next packet of `rays`. Cost: 3 operations a row.
void shadow_rays_to(const float* const from[3], std::uint32_t which, const KnownEnd& end, float far,
                    const PacketRays& rays);

}  // namespace myrialux
