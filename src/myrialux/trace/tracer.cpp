// Queries: fills Embree's rays from points and segments, and turns hits into surface points.
#include "myrialux/trace/tracer.h"

#include <bit>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "myrialux/base/assert.h"
#include "myrialux/trace/acceleration.h"

namespace myrialux {

struct Tracer::State : Acceleration {
  using Acceleration::Acceleration;
};

namespace {

/// Sets lanes [first, first + N) of the packet; ids count from 0.
template <int N, int M>
void fill(RayPacket<N>& rays, const Segments<M>& s, int first, bool to_is_direction);
template <int N, int M>
std::uint32_t trace_lanes(const Acceleration& a, const Segments<M>& s, int first, std::uint32_t valid, bool coherent,
                          bool to_is_direction);
template <int N>
std::uint32_t trace_packet(const Acceleration& a, const Segments<N>& s, std::uint32_t valid, bool coherent,
                           bool to_is_direction);
/// Traces the lanes of `valid`: meshes first, then the lanes that are left against the other kinds.
template <int N>
std::uint32_t trace_rays(const Acceleration& a, QueryContext& context, RayPacket<N>& rays, std::uint32_t valid,
                         bool coherent);
/// Any kinds of shapes, on any machine.
std::uint32_t trace_16(const Acceleration& a, RTCRay16& rays, std::uint32_t valid);
bool trace_one(const Acceleration& a, Vec3 from, Vec3 to, bool to_is_direction);
/// A point of the unit shape from a rounded one.
Point3d onto_quadric(Quadric::Kind kind, Point3d p);

/// Lanes in Embree's form.
template <int N>
struct alignas(64) Lanes {
  int on[N];
};
template <int N>
constexpr Lanes<N> lanes_of(std::uint32_t valid) {
  Lanes<N> lanes{};
  for (int k = 0; k < N; ++k) lanes.on[k] = -static_cast<int>(valid >> k & 1);
  return lanes;
}
template <int N>
constexpr Lanes<N> kAllLanes = lanes_of<N>((1u << N) - 1);

/// Embree marks blocked lanes by tfar = -infinity; all others are positive.
template <int N>
std::uint32_t blocked_lanes(const float* tfar) {
  std::uint32_t blocked = 0;
#ifdef __SSE2__
  for (int k = 0; k < N; k += 4) blocked |= static_cast<std::uint32_t>(_mm_movemask_ps(_mm_load_ps(tfar + k))) << k;
#else
  for (int k = 0; k < N; ++k) blocked |= std::bit_cast<std::uint32_t>(tfar[k]) >> 31 << k;
#endif
  return blocked;
}

void init(QueryContext& context, const Acceleration& a, bool to_is_direction) {
  init_context(context.embree);
  context.acceleration = &a;
  context.to_is_direction = to_is_direction;
}

/// Callbacks find origins and directions in the packet itself.
template <class Rays>
void look_at(QueryContext& context, const Rays& rays) {
  context.from[0] = rays.org_x, context.from[1] = rays.org_y, context.from[2] = rays.org_z;
  context.to[0] = rays.dir_x, context.to[1] = rays.dir_y, context.to[2] = rays.dir_z;
}

/// The closest hit in those of the scenes that exist; geomID RTC_INVALID_GEOMETRY_ID: none.
RTCRayHit closest_of(const Acceleration& a, const Ray& ray, std::initializer_list<RTCScene> scenes) {
  const Vec3 o = ray.origin, d = ray.direction;
  QueryContext context;
  init(context, a, true);
  for (int axis = 0; axis < 3; ++axis) context.from[axis] = &o.x + axis, context.to[axis] = &d.x + axis;
  RTCRayHit query{};
  query.ray = {o.x, o.y, o.z, 0, d.x, d.y, d.z, 0, ray.t_max, 0xffffffffu, 0, 0};
  query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  for (RTCScene scene : scenes)
    if (scene) embree_intersect(scene, context.embree, query);
  return query;
}

}  // namespace

Tracer::Tracer(const Scene& scene) : state_(std::make_unique<State>(scene)) {}
Tracer::~Tracer() = default;
Tracer::Tracer(Tracer&&) noexcept = default;

std::optional<SurfacePoint> Tracer::closest(const Ray& ray) const {
  const Acceleration& a = *state_;
  const Vec3 o = ray.origin, d = ray.direction;
  const RTCRayHit query = closest_of(a, ray, {a.meshes, a.quadrics, a.instances});
  const RTCHit& hit = query.hit;
  if (hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

  const GeometryRecord& record = a.record(hit.instID[0], hit.geomID);
  const Placement* placement = a.placement(hit.instID[0]);
  const Shape& shape = record.the_shape();
  ShapePoint at;
  if (const MeshId* mesh = std::get_if<MeshId>(&shape.geometry)) {
    at = point_on_triangle(a.scene.meshes[index(*mesh)], shape.flip_normals, hit.primID, hit.u, hit.v, placement);
  } else {
    const auto& quadric = std::get<Quadric>(shape.geometry);
    const double t = query.ray.tfar;
    Point3d p{o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
    if (placement) p = transform_point(placement->from_world, p);
    p = onto_quadric(quadric.kind, transform_point(record.from_world, p));
    at = point_on_quadric(quadric, shape.flip_normals, p, placement);
  }
  return SurfacePoint{at.p,      at.ng,        at.n,           at.uv,         query.ray.tfar,
                      at.offset, record.shape, shape.material, shape.emitter, hit.primID};
}

std::optional<std::array<Vec3, 3>> Tracer::solid_triangle(const Ray& ray) const {
  const Acceleration& a = *state_;
  const RTCRayHit query = closest_of(a, ray, {a.meshes});
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const GeometryRecord& record = a.placed[query.hit.geomID];
  if (record.is_masked || record.is_null) return std::nullopt;
  const Mesh& mesh = a.scene.meshes[index(std::get<MeshId>(record.the_shape().geometry))];
  const std::uint32_t* const corner = &mesh.indices[3 * std::size_t{query.hit.primID}];
  return std::array{mesh.positions[corner[0]], mesh.positions[corner[1]], mesh.positions[corner[2]]};
}

bool Tracer::occluded(Vec3 a, Vec3 b) const { return trace_one(*state_, a, b, false); }
bool Tracer::occluded_direction(Vec3 origin, Vec3 direction) const {
  return trace_one(*state_, origin, direction, true);
}

template <int N>
std::uint32_t Tracer::occluded_packet(const Segments<N>& segments, std::uint32_t valid, bool coherent) const {
  return trace_packet(*state_, segments, valid, coherent, false);
}
template <int N>
std::uint32_t Tracer::occluded_packet_direction(const Segments<N>& segments, std::uint32_t valid, bool coherent) const {
  return trace_packet(*state_, segments, valid, coherent, true);
}

void Tracer::occluded_rays(std::span<RTCRay16> packets, std::span<const std::uint32_t> valid,
                           std::span<std::uint32_t> blocked) const {
  MYRIALUX_ASSERT(packets.size() <= kMaxRayPackets && valid.size() == packets.size() &&
                  blocked.size() == packets.size());
  const Acceleration& a = *state_;
  if (!a.has_native_16 || a.quadrics || a.instances) {
    for (std::size_t k = 0; k < packets.size(); ++k) blocked[k] = trace_16(a, packets[k], valid[k]);
    return;
  }
  // Lanes are written before and bits read after all packets: nobody waits for memory that has just been written.
  Lanes<16> lanes[kMaxRayPackets];
  for (std::size_t k = 0; k < packets.size(); ++k)
    if (valid[k] != 0xffff) lanes[k] = lanes_of<16>(valid[k]);
  QueryContext context;
  init(context, a, true);
  for (std::size_t k = 0; k < packets.size(); ++k) {
    look_at(context, packets[k]);
    embree_occluded<16>(valid[k] == 0xffff ? kAllLanes<16>.on : lanes[k].on, a.meshes, context.embree, packets[k],
                        true);
  }
  for (std::size_t k = 0; k < packets.size(); ++k) blocked[k] = blocked_lanes<16>(packets[k].tfar) & valid[k];
}

Box3 Tracer::bounds() const { return state_->bounds; }
std::uint64_t Tracer::memory_bytes() const { return static_cast<std::uint64_t>(state_->bytes.load()); }
const Scene& Tracer::scene() const { return state_->scene; }
void* Tracer::native_scene() const { return state_->meshes; }

template std::uint32_t Tracer::occluded_packet<4>(const Segments<4>&, std::uint32_t, bool) const;
template std::uint32_t Tracer::occluded_packet<8>(const Segments<8>&, std::uint32_t, bool) const;
template std::uint32_t Tracer::occluded_packet<16>(const Segments<16>&, std::uint32_t, bool) const;
template std::uint32_t Tracer::occluded_packet_direction<4>(const Segments<4>&, std::uint32_t, bool) const;
template std::uint32_t Tracer::occluded_packet_direction<8>(const Segments<8>&, std::uint32_t, bool) const;
template std::uint32_t Tracer::occluded_packet_direction<16>(const Segments<16>&, std::uint32_t, bool) const;

namespace {

template <int N>
std::uint32_t trace_packet(const Acceleration& a, const Segments<N>& s, std::uint32_t valid, bool coherent,
                           bool to_is_direction) {
  if (valid == 0) return 0;
  if constexpr (N == 16) {
    if (!a.has_native_16)
      return trace_lanes<8>(a, s, 0, valid & 0xff, coherent, to_is_direction) |
             trace_lanes<8>(a, s, 8, (valid >> 8) & 0xff, coherent, to_is_direction) << 8;
  }
  return trace_lanes<N>(a, s, 0, valid, coherent, to_is_direction);
}

template <int N, int M>
std::uint32_t trace_lanes(const Acceleration& a, const Segments<M>& s, int first, std::uint32_t valid, bool coherent,
                          bool to_is_direction) {
  QueryContext context;
  init(context, a, to_is_direction);
  context.from[0] = s.from_x + first, context.from[1] = s.from_y + first, context.from[2] = s.from_z + first;
  context.to[0] = s.to_x + first, context.to[1] = s.to_y + first, context.to[2] = s.to_z + first;
  RayPacket<N> rays;
  fill<N>(rays, s, first, to_is_direction);
  return trace_rays<N>(a, context, rays, valid, coherent);
}

template <int N>
std::uint32_t trace_rays(const Acceleration& a, QueryContext& context, RayPacket<N>& rays, std::uint32_t valid,
                         bool coherent) {
  Lanes<N> lanes = lanes_of<N>(valid);
  embree_occluded<N>(lanes.on, a.meshes, context.embree, rays, coherent);
  std::uint32_t blocked = blocked_lanes<N>(rays.tfar) & valid;
  for (RTCScene kind : {a.quadrics, a.instances}) {
    if (!kind || blocked == valid) continue;
    lanes = lanes_of<N>(valid & ~blocked);
    embree_occluded<N>(lanes.on, kind, context.embree, rays, false);
    blocked = blocked_lanes<N>(rays.tfar) & valid;
  }
  return blocked;
}

template <int N, int M>
void fill(RayPacket<N>& rays, const Segments<M>& s, int first, bool to_is_direction) {
  const float far = to_is_direction ? kInfinity : kSegmentEnd;
  for (int k = 0; k < N; ++k) {
    rays.org_x[k] = s.from_x[first + k], rays.org_y[k] = s.from_y[first + k], rays.org_z[k] = s.from_z[first + k];
    rays.dir_x[k] = s.to_x[first + k], rays.dir_y[k] = s.to_y[first + k], rays.dir_z[k] = s.to_z[first + k];
  }
  if (!to_is_direction)
    for (int k = 0; k < N; ++k)
      rays.dir_x[k] -= rays.org_x[k], rays.dir_y[k] -= rays.org_y[k], rays.dir_z[k] -= rays.org_z[k];
  for (int k = 0; k < N; ++k) {
    rays.tnear[k] = 0, rays.time[k] = 0, rays.tfar[k] = far;
    rays.mask[k] = 0xffffffffu, rays.id[k] = static_cast<unsigned>(k), rays.flags[k] = 0;
  }
}

/// Lanes [first, first + N) of 16 rays.
template <int N>
std::uint32_t trace_part(const Acceleration& a, const RTCRay16& given, int first, std::uint32_t valid) {
  if (valid == 0) return 0;
  RayPacket<N> rays;  // a copy: Embree turns rays into an instance's space in place, callbacks need them as given
  for (int k = 0; k < N; ++k) {
    const int i = first + k;
    rays.org_x[k] = given.org_x[i], rays.org_y[k] = given.org_y[i], rays.org_z[k] = given.org_z[i];
    rays.dir_x[k] = given.dir_x[i], rays.dir_y[k] = given.dir_y[i], rays.dir_z[k] = given.dir_z[i];
    rays.tnear[k] = 0, rays.time[k] = 0, rays.tfar[k] = given.tfar[i];
    rays.mask[k] = 0xffffffffu, rays.id[k] = static_cast<unsigned>(k), rays.flags[k] = 0;
  }
  QueryContext context;
  init(context, a, true);
  context.from[0] = given.org_x + first, context.from[1] = given.org_y + first, context.from[2] = given.org_z + first;
  context.to[0] = given.dir_x + first, context.to[1] = given.dir_y + first, context.to[2] = given.dir_z + first;
  return trace_rays<N>(a, context, rays, valid, true);
}

std::uint32_t trace_16(const Acceleration& a, RTCRay16& rays, std::uint32_t valid) {
  if (!a.has_native_16) return trace_part<8>(a, rays, 0, valid & 0xff) | trace_part<8>(a, rays, 8, valid >> 8) << 8;
  if (a.instances) return trace_part<16>(a, rays, 0, valid);
  if (valid == 0) return 0;
  QueryContext context;
  init(context, a, true);
  look_at(context, rays);
  return trace_rays<16>(a, context, rays, valid, true);
}

bool trace_one(const Acceleration& a, Vec3 from, Vec3 to, bool to_is_direction) {
  QueryContext context;
  init(context, a, to_is_direction);
  for (int axis = 0; axis < 3; ++axis) context.from[axis] = &from.x + axis, context.to[axis] = &to.x + axis;
  const Vec3 d = to_is_direction ? to : to - from;
  RTCRay ray{from.x, from.y, from.z, 0, d.x, d.y, d.z, 0, to_is_direction ? kInfinity : kSegmentEnd, 0xffffffffu, 0, 0};
  for (RTCScene kind : {a.meshes, a.quadrics, a.instances})
    if (kind && ray.tfar >= 0) embree_occluded<1>(nullptr, kind, context.embree, ray, false);
  return ray.tfar < 0;
}

Point3d onto_quadric(Quadric::Kind kind, Point3d p) {
  if (kind == Quadric::Kind::disk) return {p[0], p[1], 0};
  const double z = kind == Quadric::Kind::sphere ? p[2] : 0;
  const double s = 1 / std::sqrt(p[0] * p[0] + p[1] * p[1] + z * z);
  return {p[0] * s, p[1] * s, kind == Quadric::Kind::sphere ? p[2] * s : std::clamp(p[2], 0.0, 1.0)};
}

}  // namespace

}  // namespace myrialux
