// The plain path tracer: emission, next-event estimation and BSDF sampling by multiple importance sampling [veach95].
#include "myrialux/transport/walk.h"

namespace myrialux {

Rgb path_radiance(const World& world, Ray ray, int depth, Rng& rng, PathCounters& counters, FirstHit* first) {
  CameraWalk walk;
  walk.depth = depth;
  return follow_path(world, ray, walk, rng, counters, first);
}

Rgb reflected_radiance(const World& world, const Vertex& vertex, Lobes lobes, int depth, Rng& rng,
                       PathCounters& counters) {
  if (!within_depth(world, depth + 1)) return {};
  const Rgb direct = next_event(world, vertex, lobes, /*mis=*/true, rng, counters);
  CameraWalk walk;
  walk.depth = depth;
  Ray ray;
  if (!scatter(world, vertex, lobes, walk, ray, rng)) return direct;
  return direct + follow_path(world, ray, walk, rng, counters);
}

Rgb next_event(const World& world, const Vertex& vertex, Lobes lobes, bool mis, Rng& rng, PathCounters& counters,
               int n_samples) {
  // A randomly shifted rank-1 lattice over (emitter, place on it); additive recurrence of [roberts18].
  float u_pick = rng.next();
  Vec2 u{rng.next(), rng.next()};
  const auto step = [](float& x, float by) { x += by, x -= x >= 1 ? 1 : 0; };
  Rgb sum;
  for (int k = 0; k < n_samples; ++k) {
    sum += emitter_sample(world, vertex, lobes, {.mis = mis, .n_samples = n_samples}, u_pick, u, counters);
    step(u_pick, 0.5497005f), step(u.x, 0.8191725f), step(u.y, 0.6710436f);
  }
  return sum * (1 / static_cast<float>(n_samples));
}

Rgb emitter_sample(const World& world, const Vertex& vertex, Lobes lobes, const EmitterSampleParams& params,
                   float u_pick, Vec2 u, PathCounters& counters) {
  const auto light = world.emitters.sample_direct(vertex.surface.p, u_pick, u);
  if (!light || !(light->pdf_omega > 0) || is_black(light->radiance)) return {};
  const float kept =
      params.lost_only ? lost_part(vertex.surface, light->wi, light->distance, params.clamp_distance) : 1;
  if (kept == 0) return {};
  const Vec3 wi = vertex.to_local(light->wi), wo = vertex.to_local(vertex.wo);
  const Rgb f = evaluate(vertex.bsdf, wi, wo, lobes);
  if (is_black(f)) return {};
  ++counters.occlusion;
  const SurfacePoint& s = vertex.surface;
  const Vec3 from = offset_origin(s.p, s.ng, s.offset, light->wi);
  if (light->is_distant ? world.tracer.occluded_direction(from, light->wi) : world.tracer.occluded(from, light->to))
    return {};
  const float weight =
      params.mis && !light->is_delta
          ? mis_weight(static_cast<float>(params.n_samples) * light->pdf_omega, pdf_omega(vertex.bsdf, wi, wo, lobes))
          : 1;
  return f * light->radiance * (kept * weight / light->pdf_omega);
}

}  // namespace myrialux
