// What virtual lights cannot carry to a receiver, by one continued path: light that leaves the first surface met by
// its sharp lobes, and the part that clamping took away. Unbiased compensation after [kollig06].
//
// A virtual light at distance d < c counts d^2 / c^2 of its light, so that 1 - d^2 / c^2 of what leaves y by its wide
// lobes (and of y's emission, where bounce-0 lights carry it) is missing. Emission clamped away is found by an emitter
// sample and by the path together (MIS), light of point emitters by the emitter sample alone.
#include "myrialux/transport/walk.h"

namespace myrialux {

Rgb residual_radiance(const World& world, const Vertex& vertex, const ResidualParams& params, Rng& rng,
                      PathCounters& counters) {
  if (!within_depth(world, params.depth + 1)) return {};
  const float c = params.clamp_distance;

  // Emission near by that clamped bounce-0 lights lost.
  Rgb sum;
  const bool emission_clamped = !params.direct_by_sampling && c > 0;
  if (emission_clamped) {
    const float u_pick = rng.next();
    const Vec2 u{rng.next(), rng.next()};
    sum += emitter_sample(world, vertex, Lobes::wide, {.mis = true, .clamp_distance = c}, u_pick, u, counters);
  }

  // One step by the wide lobes.
  CameraWalk walk;
  walk.depth = params.depth;
  Ray ray;
  if (!scatter(world, vertex, Lobes::wide, walk, ray, rng)) return sum;
  const auto hit = next_surface(world, ray, walk.depth, counters);
  const float missing = hit ? clamped_part(length(hit->p - vertex.surface.p), c) : 0;
  if (params.direct_by_sampling)
    sum += walk.beta * met_emission(world, walk, hit ? &*hit : nullptr, ray);
  else if (missing > 0)
    sum += walk.beta * missing * met_emission(world, walk, &*hit, ray);
  ++walk.depth;
  if (!hit || !within_depth(world, walk.depth + 1)) return sum;

  // What the surface met sends on: sharp lobes fully, wide ones as far as they were clamped. One of them is followed.
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
