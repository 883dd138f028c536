// Estimating radiance along one path: next-event estimation and BSDF sampling, combined by multiple importance
// sampling [veach95], Russian roulette. Used by the reference path tracer and by the residual of the many-light
// methods.
#pragma once

#include <cstdint>
#include <span>

#include "myrialux/base/rng.h"
#include "myrialux/emitters/emitters.h"
#include "myrialux/scattering/bsdf.h"
#include "myrialux/trace/tracer.h"

namespace myrialux {

/// Everything a path needs to know of the world; built once, shared by all threads.
struct World {
  const Scene& scene;
  const Tracer& tracer;
  const Emitters& emitters;
  int max_depth = -1;  ///< path edges from the camera, -1 = no limit. 1: emission seen directly; 2: direct light
  int rr_depth = 5;    ///< edges after which Russian roulette may end a path
  float sharp_alpha = kDefaultSharpAlpha;
};

struct PathCounters {
  std::uint64_t closest = 0, occlusion = 0;
  PathCounters& operator+=(const PathCounters& o) {
    closest += o.closest, occlusion += o.occlusion;
    return *this;
  }
};

/// The surface a path stands on, ready for shading: BSDF, frame turned so that wo is where the BSDF expects it.
struct Vertex {
  SurfacePoint surface;
  Bsdf bsdf;
  BsdfParams params;
  Vec3 n;                ///< shading normal, turned with `flipped`
  Vec3 wo;               ///< unit, world
  bool flipped = false;  ///< seen from behind: two-sided materials are mirrored to the front
  Vec3 to_local(Vec3 w) const { return Frame(n).to_local(w); }
  Vec3 to_world(Vec3 w) const { return Frame(n).to_world(w); }
};
Vertex make_vertex(const World& world, const SurfacePoint& surface, Vec3 wo);

/// The first surface of a path, as AOVs show it.
struct FirstHit {
  bool any = false;
  Vec3 p, n;  ///< shading normal, turned as Vertex::n
  Rgb albedo;
};

/// Radiance arriving along `ray` by the plain path tracer: emission at the first hit included with full weight.
/// @param depth edges used before this ray (0 for camera rays); @param first set to what the ray met, for AOVs
Rgb path_radiance(const World& world, Ray ray, int depth, Rng& rng, PathCounters& counters, FirstHit* first = nullptr);

/// Radiance reflected at `vertex` towards wo by the chosen lobes: direct light by MIS, then continued as path_radiance.
/// @param depth edges from the camera to this vertex
Rgb reflected_radiance(const World& world, const Vertex& vertex, Lobes lobes, int depth, Rng& rng,
                       PathCounters& counters);

/// Direct light at the vertex through `lobes` by n_samples emitter samples, spread evenly (weight by MIS against one
/// BSDF sample unless `mis` is false). Not asked for depth: call it only where one more edge is within max_depth
/// (receivers are made only there).
Rgb next_event(const World& world, const Vertex& vertex, Lobes lobes, bool mis, Rng& rng, PathCounters& counters,
               int n_samples = 1);

/// What virtual lights cannot carry to a receiver, estimated by one continued path (unbiased). The path leaves the
/// vertex by its wide lobes and meets y:
///   - y's sharp lobes (mirror, glass, near-mirror): followed as a path tracer would, everything counts;
///   - y's wide lobes nearer than clamp_distance c: counted with 1 - d^2 / c^2, the part that clamping removed;
///   - emission of y: by MIS with next_event if `direct_by_sampling`, else like wide lobes (clamped part only; an
///     emitter sample helps, which also finds point emitters).
/// @param clamp_distance 0 = virtual lights are not clamped
/// @param depth edges from the camera to the vertex
struct ResidualParams {
  float clamp_distance = 0;
  bool direct_by_sampling = true;
  int direct_samples = 1;  ///< n_samples of the next_event() that shares the weight of emission met
  int depth = 1;
};
Rgb residual_radiance(const World& world, const Vertex& vertex, const ResidualParams& params, Rng& rng,
                      PathCounters& counters);

}  // namespace myrialux
