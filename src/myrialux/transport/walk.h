// One step of a camera path, shared by path tracing, receivers and residuals: emission met, and the next direction.
#pragma once

#include <cmath>
#include <optional>

#include "myrialux/transport/paths.h"

namespace myrialux {

/// What a camera path carries from vertex to vertex.
struct CameraWalk {
  Rgb beta = gray(1);
  float eta = 1;            ///< product of relative indices crossed, for Russian roulette
  float pdf_omega = 0;      ///< density of the last bounce; 0: camera ray or delta bounce, seen emission counts fully
  float light_samples = 1;  ///< emitter samples taken where the last bounce started
  Vec3 from;                ///< where the last bounce started (meaningless while pdf_omega is 0)
  int depth = 0;            ///< edges used so far
};

/// May a path of `edges` edges count?
inline bool within_depth(const World& world, int edges) { return world.max_depth < 0 || edges <= world.max_depth; }

/// Weight of the strategy with density a against one with density b: power heuristic [veach95]. a > 0.
inline float mis_weight(float a, float b) {
  const float r = b / a;
  return 1 / (1 + r * r);
}

/// Geometric and shading normal disagree on which side of the surface w leaves. Virtual lights are not joined so
/// (transfer.h, is_active), camera paths go there.
inline bool sides_disagree(const SurfacePoint& s, Vec3 w) {
  return std::copysign(1.0f, dot(s.ng, s.n)) * dot(s.ng, w) * dot(s.n, w) <= 0;
}
/// Part of the light from direction wi and distance d that virtual lights do not bring to x: all of it if the sides
/// disagree, else what clamping the geometry term at c took away; c = 0: nothing.
inline float lost_part(const SurfacePoint& x, Vec3 wi, float d, float c) {
  if (sides_disagree(x, wi)) return 1;
  return d < c ? 1 - (d * d) / (c * c) : 0;
}

/// One emitter sample.
struct EmitterSampleParams {
  bool mis = true;
  int n_samples = 1;       ///< how many the caller takes and averages
  bool lost_only = false;  ///< times lost_part(): what bounce-0 lights clamped at clamp_distance did not bring
  float clamp_distance = 0;
};
Rgb emitter_sample(const World& world, const Vertex& vertex, Lobes lobes, const EmitterSampleParams& params,
                   float u_pick, Vec2 u, PathCounters& counters);

/// MIS weight with which emission counts that a bounce of density walk.pdf_omega met at `hit` (null: environment).
float emission_weight(const World& world, const CameraWalk& walk, const SurfacePoint* hit, Vec3 direction);

/// Emission met at the end of `ray`, MIS weight included, walk.beta not; `hit` is null where nothing was met.
Rgb met_emission(const World& world, const CameraWalk& walk, const SurfacePoint* hit, const Ray& ray);

/// An opaque one-sided surface met from behind: it neither reflects nor passes light on.
bool is_black_back(const Vertex& vertex);

/// Goes on to what lies behind a surface, along the same direction.
inline Ray ray_behind(const SurfacePoint& hit, const Ray& ray) {
  return {offset_origin(hit.p, hit.ng, hit.offset, ray.direction), ray.direction, ray.t_max - hit.t};
}
/// Surfaces of BSDF `null` scatter nothing: paths and shadow rays pass, and no edge is counted.
inline bool is_null(const World& world, const SurfacePoint& hit) {
  return world.scene.materials[index(hit.material)].kind == BsdfKind::null;
}

/// First surface that scatters along a ray that leaves the camera or a bounce. Camera rays (depth 0) pass through
/// emitters' shapes when the scene hides emitters, as Mitsuba's do.
/// @param met called as met(const SurfacePoint*) for every emitter on the way and at the end, with null at infinity
template <class Met>
std::optional<SurfacePoint> next_surface(const World& world, Ray ray, int depth, PathCounters& counters,
                                         const Met& met) {
  while (ray.t_max > 0) {
    ++counters.closest;
    std::optional<SurfacePoint> hit = world.tracer.closest(ray);
    if (!hit) break;
    const bool emits = hit->emitter != kNone<EmitterId>, hidden = emits && depth == 0 && world.scene.hide_emitters;
    if (emits && !hidden) met(&*hit);
    if (!hidden && !is_null(world, *hit)) return hit;
    ray = ray_behind(*hit, ray);
  }
  met(nullptr);
  return std::nullopt;
}

/// Samples the next direction through `lobes` and plays Russian roulette (from walk.depth >= rr_depth on: survives with
/// the largest component of beta * eta^2, at most 0.95). `walk.depth` counts the edges up to `vertex`.
/// @returns false when the path ends
bool scatter(const World& world, const Vertex& vertex, Lobes lobes, CameraWalk& walk, Ray& ray, Rng& rng);

/// Follows a path from `ray` to its end and adds up what it meets (times walk.beta).
Rgb follow_path(const World& world, Ray ray, CameraWalk walk, Rng& rng, PathCounters& counters,
                FirstHit* first = nullptr);

}  // namespace myrialux
