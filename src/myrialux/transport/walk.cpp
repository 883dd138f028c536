// Steps of camera paths: emission met, next direction, Russian roulette. Rules as Mitsuba's `path` has them.
#include "myrialux/transport/walk.h"

#include <utility>

namespace myrialux {

float emission_weight(const World& world, const CameraWalk& walk, const SurfacePoint* hit, Vec3 direction) {
  if (walk.pdf_omega == 0) return 1;
  const float light_pdf_omega =
      hit ? world.emitters.direct_pdf_omega(walk.from, hit->emitter, hit->p, hit->ng, hit->primitive)
          : world.emitters.environment_pdf_omega(direction);
  return mis_weight(walk.pdf_omega, walk.light_samples * light_pdf_omega);
}

Rgb met_emission(const World& world, const CameraWalk& walk, const SurfacePoint* hit, const Ray& ray) {
  if (hit ? hit->emitter == kNone<EmitterId> : !world.emitters.has_environment()) return {};
  if (walk.depth == 0 && world.scene.hide_emitters) return {};
  const Rgb Le = hit ? world.emitters.emitted(hit->emitter, hit->uv, hit->n, ray.direction)
                     : world.emitters.environment(ray.direction);
  if (is_black(Le)) return {};
  return Le * emission_weight(world, walk, hit, ray.direction);
}

bool scatter(const World& world, const Vertex& vertex, Lobes lobes, CameraWalk& walk, Ray& ray, Rng& rng) {
  const float u_lobe = rng.next();
  const Vec2 u{rng.next(), rng.next()};
  const BsdfSample s = sample(vertex.bsdf, vertex.to_local(vertex.wo), u_lobe, u, lobes, TransportMode::radiance);
  if (is_black(s.weight)) return false;
  walk.beta *= s.weight;
  walk.eta *= s.eta;
  walk.pdf_omega = s.is_delta ? 0 : s.pdf_omega;
  walk.from = vertex.surface.p;
  walk.light_samples = 1;
  const Vec3 wi = vertex.to_world(s.wi);
  ray = {offset_origin(vertex.surface.p, vertex.surface.ng, vertex.surface.offset, wi), wi};
  if (walk.depth < world.rr_depth) return true;
  const float survival = std::min(0.95f, max_component(walk.beta) * walk.eta * walk.eta);
  if (!(rng.next() < survival)) return false;
  walk.beta *= 1 / survival;
  return true;
}

Rgb follow_path(const World& world, Ray ray, CameraWalk walk, Rng& rng, PathCounters& counters, FirstHit* first) {
  Rgb sum;
  while (within_depth(world, walk.depth + 1)) {
    const auto hit = next_surface(world, ray, walk.depth, counters, [&](const SurfacePoint* met) {
      sum += walk.beta * met_emission(world, walk, met, ray);
    });
    if (!hit) break;
    const Vertex vertex = make_vertex(world, *hit, -ray.direction);
    if (first) *std::exchange(first, nullptr) = {true, hit->p, vertex.n, albedo(vertex.bsdf)};
    ++walk.depth;
    if (!within_depth(world, walk.depth + 1)) break;
    sum += walk.beta * next_event(world, vertex, Lobes::all, /*mis=*/true, rng, counters);
    if (!scatter(world, vertex, Lobes::all, walk, ray, rng)) break;
  }
  return sum;
}

}  // namespace myrialux
