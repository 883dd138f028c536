// Rays against spheres, discs and cylinders: exact roots in double precision, in the space of the unit shape.
#include <cmath>

#include "myrialux/trace/acceleration.h"

namespace myrialux {

namespace {

struct Crossings {
  int n = 0;
  double t[2];  ///< ascending
  Point3d at[2];
};
/// Crossings of o + t d with the unit shape, in any order of validity (t may be negative).
Crossings cross_shape(Quadric::Kind kind, const Point3d& o, const Point3d& d);

struct Found {
  bool hit = false;
  float t;
  Point3d at;
};
/// The first crossing of the lane's ray in (near, far] that the mask keeps.
Found first_crossing(const GeometryRecord& record, const QueryContext& context, unsigned lane, unsigned geometry,
                     float near, float far);

unsigned instance_of(const EmbreeContext& context) { return context.instID[0]; }
float up(double v) { return std::nextafter(static_cast<float>(v), kInfinity); }
float down(double v) { return std::nextafter(static_cast<float>(v), -kInfinity); }

}  // namespace

void quadric_bounds(const RTCBoundsFunctionArguments* a) {
  const auto& record = *static_cast<const GeometryRecord*>(a->geometryUserPtr);
  const auto& quadric = std::get<Quadric>(record.the_shape().geometry);
  const auto& m = quadric.to_world.rows();
  const bool is_sphere = quadric.kind == Quadric::Kind::sphere, is_long = quadric.kind == Quadric::Kind::cylinder;
  float lower[3], upper[3];
  for (int r = 0; r < 3; ++r) {
    const double x = m[4 * r], y = m[4 * r + 1], z = is_sphere ? m[4 * r + 2] : 0;
    const double extent = std::sqrt(x * x + y * y + z * z), at = m[4 * r + 3], axis = is_long ? m[4 * r + 2] : 0;
    // Embree's box test rounds: some ulps of the coordinates keep grazing rays inside
    const double slack = 0x1p-21 * (std::fabs(at) + extent + std::fabs(axis));
    lower[r] = down(at + std::min(axis, 0.0) - extent - slack);
    upper[r] = up(at + std::max(axis, 0.0) + extent + slack);
  }
  *a->bounds_o = {lower[0], lower[1], lower[2], 0, upper[0], upper[1], upper[2], 0};
}

void quadric_intersect(const RTCIntersectFunctionNArguments* a) {
  const auto& record = *static_cast<const GeometryRecord*>(a->geometryUserPtr);
  const auto* context = reinterpret_cast<const QueryContext*>(a->context);
  RTCRayN* ray = RTCRayHitN_RayN(a->rayhit, a->N);
  RTCHitN* hit = RTCRayHitN_HitN(a->rayhit, a->N);
  for (unsigned i = 0; i < a->N; ++i) {
    if (a->valid[i] != -1) continue;
    const Found found = first_crossing(record, *context, RTCRayN_id(ray, a->N, i), a->geomID,
                                       RTCRayN_tnear(ray, a->N, i), RTCRayN_tfar(ray, a->N, i));
    if (!found.hit) continue;
    RTCRayN_tfar(ray, a->N, i) = found.t;
    RTCHitN_primID(hit, a->N, i) = a->primID;
    RTCHitN_geomID(hit, a->N, i) = a->geomID;
    RTCHitN_instID(hit, a->N, i, 0) = instance_of(*a->context);
  }
}

void quadric_occluded(const RTCOccludedFunctionNArguments* a) {
  const auto& record = *static_cast<const GeometryRecord*>(a->geometryUserPtr);
  if (record.is_null) return;
  const auto* context = reinterpret_cast<const QueryContext*>(a->context);
  for (unsigned i = 0; i < a->N; ++i) {
    if (a->valid[i] != -1) continue;
    if (first_crossing(record, *context, RTCRayN_id(a->ray, a->N, i), a->geomID, RTCRayN_tnear(a->ray, a->N, i),
                       RTCRayN_tfar(a->ray, a->N, i))
            .hit)
      RTCRayN_tfar(a->ray, a->N, i) = -kInfinity;
  }
}

namespace {

Found first_crossing(const GeometryRecord& record, const QueryContext& context, unsigned lane, unsigned geometry,
                     float near, float far) {
  const Vec3 origin = context.origin(lane), direction = context.direction(lane);
  Point3d o{origin.x, origin.y, origin.z}, d{direction.x, direction.y, direction.z};
  const unsigned instance = instance_of(context.embree);
  if (const Placement* placement = context.acceleration->placement(instance)) {
    o = transform_point(placement->from_world, o);
    d = transform_vector(placement->from_world, d);
  }
  o = transform_point(record.from_world, o);
  d = transform_vector(record.from_world, d);
  const Quadric::Kind kind = std::get<Quadric>(record.the_shape().geometry).kind;
  const Crossings crossings = cross_shape(kind, o, d);
  for (int k = 0; k < crossings.n; ++k) {
    if (!(crossings.t[k] > near && crossings.t[k] <= far)) continue;
    if (record.is_masked && !mask_keeps(*record.scene, record.material(), quadric_uv(kind, crossings.at[k]), origin,
                                        direction, instance, geometry, 0, static_cast<unsigned>(k)))
      continue;
    return {true, static_cast<float>(crossings.t[k]), crossings.at[k]};
  }
  return {};
}

Crossings cross_shape(Quadric::Kind kind, const Point3d& o, const Point3d& d) {
  Crossings found;
  const auto add = [&](double t, bool inside) {
    if (!inside || !std::isfinite(t)) return;
    found.at[found.n] = {o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]};
    found.t[found.n++] = t;
  };
  if (kind == Quadric::Kind::disk) {
    const double t = -o[2] / d[2], x = o[0] + t * d[0], y = o[1] + t * d[1];
    add(t, x * x + y * y <= 1);
    return found;
  }
  const double k = kind == Quadric::Kind::sphere ? 1 : 0;  // a cylinder is a sphere without z
  const double a = d[0] * d[0] + d[1] * d[1] + k * d[2] * d[2];
  if (a == 0) return found;
  // The point nearest to the axis first: no cancellation for rays that start far away. [haines19]
  const double nearest = -(o[0] * d[0] + o[1] * d[1] + k * o[2] * d[2]) / a;
  const double x = o[0] + nearest * d[0], y = o[1] + nearest * d[1], z = k * (o[2] + nearest * d[2]);
  const double height = 1 - (x * x + y * y + z * z);
  if (height < 0) return found;
  const double half = std::sqrt(height / a);
  for (const double t : {nearest - half, nearest + half}) {
    const double along = o[2] + t * d[2];
    add(t, k == 1 || (along >= 0 && along <= 1));
  }
  return found;
}

}  // namespace

}  // namespace myrialux
