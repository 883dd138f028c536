// What virtual lights cannot carry to a receiver, by one continued path: light that leaves the first surface met by
// its sharp lobes, and the part that clamping took away. Unbiased compensation after [kollig06].
//
// A virtual light at distance d < c counts d^2 / c^2 of its light, so that 1 - d^2 / c^2 of what leaves y by its wide
// lobes (and of y's emission, where bounce-0 lights carry it) is missing. All of it is missing where geometric and
// shading normal disagree about the side. Emission missing is found by an emitter sample and by the path together
// (MIS), light of point emitters by the emitter sample alone.
#include "myrialux/transport/walk.h"

namespace myrialux {

Rgb residual_radiance(const World& world, const Vertex& vertex, const ResidualParams& params, Rng& rng,
                      PathCounters& counters) {
  if (!within_depth(world, params.depth + 1)) return {};
  const float c = params.clamp_distance;

  // Emission that bounce-0 lights lost.
  Rgb sum;
  const bool smooth = std::fabs(dot(vertex.surface.ng, vertex.surface.n)) < 1 - 1e-6f;
  if (!params.direct_by_sampling && (c > 0 || smooth)) {
    const float u_pick = rng.next();
    const Vec2 u{rng.next(), rng.next()};
    const EmitterSampleParams lost{.mis = true, .lost_only = true, .clamp_distance = c};
    sum += emitter_sample(world, vertex, Lobes::wide, lost, u_pick, u, counters);
  }

  // One step by the wide lobes.
  CameraWalk walk;
  walk.depth = params.depth;
  Ray ray;
  if (!scatter(world, vertex, Lobes::wide, walk, ray, rng)) return sum;
  if (params.direct_by_sampling) walk.light_samples = static_cast<float>(params.direct_samples);
  const auto lost = [&](const SurfacePoint* at) {
    return lost_part(vertex.surface, ray.direction, at ? length(at->p - vertex.surface.p) : kInfinity, c);
  };
  const auto hit = next_surface(world, ray, walk.depth, counters, [&](const SurfacePoint* met) {
    const float part = params.direct_by_sampling ? 1 : lost(met);
    if (part > 0) sum += walk.beta * met_emission(world, walk, met, ray) * part;
  });
  ++walk.depth;
  if (!hit || !within_depth(world, walk.depth + 1)) return sum;

  // What the surface met sends on: sharp lobes fully, wide ones as far as they were lost. One of them is followed.
  const float missing = sides_disagree(*hit, ray.direction) ? 1 : lost(&*hit);
  const Vertex y = make_vertex(world, *hit, -ray.direction);
  const float sharp = sharp_probability(y.bsdf, y.to_local(y.wo));
  const bool follow_sharp = rng.next() < sharp;
  if (!follow_sharp && missing == 0) return sum;
  const Lobes lobes = follow_sharp ? Lobes::sharp : Lobes::wide;
  walk.beta *= follow_sharp ? 1 / sharp : missing / (1 - sharp);
  sum += walk.beta * next_event(world, y, lobes, /*mis=*/true, rng, counters);
  if (scatter(world, y, lobes, walk, ray, rng)) sum += follow_path(world, ray, walk, rng, counters);
  return sum;
}

}  // namespace myrialux
