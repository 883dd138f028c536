// A slice's shadow rays as Embree wants them, prepared beforehand: what raw Embree would be given.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "bench_frame.h"
#include "myrialux/base/clock.h"
#include "myrialux/math/warp.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/trace/embree.h"
#include "myrialux/visibility/shadow_light.h"

namespace myrialux::bench {

/// As SliceVisibility: blocks of fewer rows share packets.
inline constexpr int kLeastOwnRows = 8;

/// 16 rays of which some are traced, ready for Embree.
struct alignas(64) RawPacket {
  RTCRay16 rays;
  int valid[16];
};

/// Rows of a slice in its order.
struct alignas(64) BlockOfRows {
  PacketFloats p[3] = {}, ng[3] = {}, offset = {};
};

/// What SliceVisibility lays out, for packets of our own.
class PacketMaker {
 public:
  PacketMaker(const Frame& frame, std::span<const ReceiverId> rows) : blocks_((rows.size() + 15) / 16) {
    for (std::size_t r = 0; r < rows.size(); ++r) set(blocks_[r / 16], r % 16, frame.rows(), index(rows[r]));
  }

  /// The packets of one column: own ones of blocks with enough rows, the others gathered.
  void add(const ShadowLight& light, Words wanted, bool from_light, std::vector<RawPacket>& packets) const {
    BlockOfRows gathered;
    std::size_t n = 0;
    for (std::size_t w = 0; w < wanted.size(); ++w)
      for (std::size_t q = 0; q < 4; ++q) {
        const std::uint32_t valid = wanted[w] >> 16 * q & 0xffff;
        if (std::popcount(valid) < kLeastOwnRows) {
          for (std::uint32_t left = valid; left != 0; left &= left - 1) {
            copy(blocks_[4 * w + q], static_cast<std::size_t>(std::countr_zero(left)), gathered, n++);
            if (n < 16) continue;
            packets.push_back(packet(gathered, light, 0xffff, from_light));
            n = 0;
          }
        } else {
          packets.push_back(packet(blocks_[4 * w + q], light, valid, from_light));
        }
      }
    if (n > 0) packets.push_back(packet(gathered, light, static_cast<std::uint32_t>(low_bits(n)), from_light));
  }

  static PacketRows rows_of(const BlockOfRows& b) {
    return {{b.p[0], b.p[1], b.p[2]}, {b.ng[0], b.ng[1], b.ng[2]}, b.offset};
  }
  const std::vector<BlockOfRows>& blocks() const { return blocks_; }

 private:
  static void set(BlockOfRows& b, std::size_t lane, const Receivers& receivers, std::size_t i) {
    for (int k = 0; k < 3; ++k) b.p[k][lane] = receivers.p[i][k], b.ng[k][lane] = receivers.ng[i][k];
    b.offset[lane] = receivers.offset[i];
  }
  static void copy(const BlockOfRows& from, std::size_t a, BlockOfRows& to, std::size_t b) {
    for (int k = 0; k < 3; ++k) to.p[k][b] = from.p[k][a], to.ng[k][b] = from.ng[k][a];
    to.offset[b] = from.offset[a];
  }
  static RawPacket packet(const BlockOfRows& rows, const ShadowLight& light, std::uint32_t valid, bool from_light) {
    alignas(64) Segments<16> s;
    float* const from[3] = {s.from_x, s.from_y, s.from_z};
    float* const to[3] = {s.to_x, s.to_y, s.to_z};
    shadow_ends(rows_of(rows), light, from, to);
    RawPacket made{};
    RTCRay16& r = made.rays;
    const bool distant = light.end == SegmentEnd::direction;
    for (int k = 0; k < 16; ++k) {
      made.valid[k] = valid >> k & 1 ? -1 : 0;
      const float d[3] = {distant ? s.to_x[k] : s.to_x[k] - s.from_x[k], distant ? s.to_y[k] : s.to_y[k] - s.from_y[k],
                          distant ? s.to_z[k] : s.to_z[k] - s.from_z[k]};
      const bool turned = from_light && !distant;
      r.org_x[k] = turned ? s.to_x[k] : s.from_x[k], r.dir_x[k] = turned ? -d[0] : d[0];
      r.org_y[k] = turned ? s.to_y[k] : s.from_y[k], r.dir_y[k] = turned ? -d[1] : d[1];
      r.org_z[k] = turned ? s.to_z[k] : s.from_z[k], r.dir_z[k] = turned ? -d[2] : d[2];
      r.tfar[k] = distant ? kInfinity : 1 - 0x1p-20f;
      r.mask[k] = 0xffffffffu, r.id[k] = static_cast<unsigned>(k);
    }
    return made;
  }

  std::vector<BlockOfRows> blocks_;
};

/// What a look at a thread's clock costs; so much is in each time taken by it.
inline double clock_seconds() {
  constexpr int kLooks = 2000;
  static const double cost = [] {
    ThreadStopwatch whole, watch;
    for (int k = 0; k < kLooks; ++k) watch.lap();
    return whole.elapsed() / kLooks;
  }();
  return cost;
}

/// Columns whose packets are prepared at a time: 8 of 64 packets of 832 bytes stay in the second cache.
inline constexpr std::size_t kChunk = 8;

/// Nothing but Embree; rays are spoilt.
inline void trace_raw(RTCScene scene, std::span<RawPacket> packets) {
  for (RawPacket& p : packets) {
    EmbreeContext context;
    init_context(context);
    embree_occluded<16>(p.valid, scene, context, p.rays, true);
  }
}

inline std::uint64_t count_visible(std::span<const RawPacket> packets) {
  std::uint64_t n = 0;
  for (const RawPacket& p : packets)
    for (int k = 0; k < 16; ++k) n += p.valid[k] != 0 && p.rays.tfar[k] >= 0;
  return n;
}

/// Rays of the camera, pixel after pixel, over the whole picture.
inline std::vector<Ray> camera_rays(const Frame& f, std::size_t n) {
  std::vector<Ray> rays;
  const std::uint64_t n_pixels = std::uint64_t{kWidth} * kHeight;
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint64_t pixel = k * n_pixels / n;
    rays.push_back(
        camera_ray(f.scene.camera, kWidth, kHeight, camera_sample(f.scene.camera, kWidth, pixel, 0, kSpp, f.key)));
  }
  return rays;
}

/// Rays from strewn lights that lie on surfaces, cosine-distributed: like the walks of light.
inline std::vector<Ray> scattered_rays(const Frame& f, std::size_t n) {
  std::vector<Ray> rays;
  const VirtualLights& l = f.lights.lights;
  Rng rng({3}, Stage::test, 0);
  while (rays.size() < n) {
    const std::size_t j = rng.below(static_cast<std::uint32_t>(l.size()));
    const Vec3 to = normalize(l.ng[j] + 0.999f * sample_sphere({rng.next(), rng.next()}));
    if (l.kind[j] == LightKind::oriented || l.kind[j] == LightKind::glossy)
      rays.push_back({offset_origin(l.p[j], l.ng[j], l.offset[j], to), to});
    else if (l.kind[j] == LightKind::directional)  // the environment's: from where they land
      rays.push_back({f.rows().p[rng.below(static_cast<std::uint32_t>(f.rows().size()))] - 0.001f * l.n[j], -l.n[j]});
  }
  return rays;
}

/// How many rays meet a surface, by single closest hits and nothing else.
inline std::size_t intersect_all(const Frame& f, std::span<const Ray> rays) {
  const auto scene = static_cast<RTCScene>(f.tracer.native_scene());
  EmbreeContext context;
  init_context(context);
  std::size_t n = 0;
  for (const Ray& r : rays) {
    RTCRayHit query{};
    query.ray = {r.origin.x, r.origin.y,  r.origin.z, 0, r.direction.x, r.direction.y, r.direction.z, 0,
                 r.t_max,    0xffffffffu, 0,          0};
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    embree_intersect(scene, context, query);
    n += query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }
  return n;
}

}  // namespace myrialux::bench
