// Embree behind our own vocabulary: closest hits with exact surface points, and occlusion one ray or 4, 8, 16 at a
// time.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "myrialux/base/ids.h"
#include "myrialux/math/vec.h"
#include "myrialux/scene/scene.h"

struct RTCRay16;  // Embree's

namespace myrialux {

/// Where a ray met a surface.
struct SurfacePoint {
  Vec3 p;      ///< world space, from the shape's own coordinates (not origin + t d)
  Vec3 ng, n;  ///< unit geometric and shading normal, as the shape has them (not turned to the viewer)
  Vec2 uv;
  float t = 0;
  float offset = 0;  ///< how far along +-ng a new ray must start to be off the surface despite rounding
  ShapeId shape = kNone<ShapeId>;
  MaterialId material = kNone<MaterialId>;
  EmitterId emitter = kNone<EmitterId>;
  std::uint32_t primitive = 0;
};

/// p moved off the surface to the side of `direction`.
inline Vec3 offset_origin(Vec3 p, Vec3 ng, float offset, Vec3 direction) {
  return p + ng * std::copysign(offset, dot(ng, direction));
}

/// Segments for occlusion tests, structure of arrays; both ends already off their surfaces.
template <int N>
struct alignas(64) Segments {
  float from_x[N], from_y[N], from_z[N];  ///< origins
  float to_x[N], to_y[N], to_z[N];        ///< direction = to - from, traced for t in (0, 1 - 2^-20]
};

/// Where rays along to - from end, in t: Embree's test of t is off by some roundoffs, so that segments would meet the
/// surface that they end on. 16 roundoffs before 1; grazing segments are held off by SurfacePoint::offset.
inline constexpr float kSegmentEnd = 1 - 0x1p-20f;

/// Packets that are traced in one call at most.
inline constexpr std::size_t kMaxRayPackets = 16;

/// An immutable acceleration structure over a scene, safe to use from all threads. Keeps a reference to the scene.
class Tracer {
 public:
  /// Builds with all threads. @throws Error (limit) when memory runs out.
  explicit Tracer(const Scene& scene);
  ~Tracer();
  Tracer(Tracer&&) noexcept;

  /// First surface along the ray within (0, t_max], cut-outs (masks) skipped.
  std::optional<SurfacePoint> closest(const Ray& ray) const;

  /// Corners of the first triangle of a mesh along the ray, world space; quadrics and instances do not count. None if
  /// there is none, or if it has cut-outs or never blocks.
  std::optional<std::array<Vec3, 3>> solid_triangle(const Ray& ray) const;

  /// Is anything between a and b? Ends must already be offset. Masked surfaces block with probability = opacity,
  /// decided by a hash of the segment's ends and the primitive: same answer from every function below.
  bool occluded(Vec3 a, Vec3 b) const;
  /// Along a direction to infinity.
  bool occluded_direction(Vec3 origin, Vec3 direction) const;

  /// Bit k of the result: segment k is blocked. Only bits of `valid` are traced, others are 0.
  /// `coherent`: the segments share an end or nearly so.
  template <int N>
  std::uint32_t occluded_packet(const Segments<N>& segments, std::uint32_t valid, bool coherent) const;
  /// Packets towards a distant light: `to_*` hold directions, traced to infinity.
  template <int N>
  std::uint32_t occluded_packet_direction(const Segments<N>& segments, std::uint32_t valid, bool coherent) const;
  /// The same bits from coherent packets that lie as Embree reads them already: `org`, `dir` (to - from, or towards a
  /// distant light) and `tfar` (kSegmentEnd or infinity) set, the rest as init_rays() leaves it. Spoils `tfar`.
  /// Several packets at a time, since rays that were written just before they are read make Embree wait.
  /// @param packets at most kMaxRayPackets; @param valid, blocked a word of 16 bits a packet
  void occluded_rays(std::span<RTCRay16> packets, std::span<const std::uint32_t> valid,
                     std::span<std::uint32_t> blocked) const;

  Box3 bounds() const;
  std::uint64_t memory_bytes() const;
  const Scene& scene() const;
  /// The raw Embree scene (RTCScene) of the placed meshes, for benchmarks against the library itself. Not for scenes
  /// with cut-outs: their callbacks need the tracer's own context.
  void* native_scene() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace myrialux
