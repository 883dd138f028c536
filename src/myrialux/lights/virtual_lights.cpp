// Walks from the emitters that leave virtual point lights where they meet wide lobes. [keller97], [wang20, 4.3]
//
// A walk that arrives at y from wi with power P, where the shading normal n differs from the geometric ng, sends
// P f(wi, w) |wi . n| / |wi . ng| |w . ng| along w [veach97, eq. 5.19]; so virtual lights agree with camera paths.
#include "myrialux/lights/virtual_lights.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "myrialux/base/parallel.h"
#include "myrialux/base/process.h"
#include "myrialux/scattering/lobes.h"
#include "myrialux/transport/walk.h"

namespace myrialux {
namespace {

constexpr std::uint32_t kNoExtra = 0xffffffffu;
constexpr std::size_t kPilotWalks = 1024, kWalksPerBlock = 256;
constexpr std::uint64_t kPilotItems = std::uint64_t{1} << 62;  ///< random streams of the pilot, apart from the walks'

struct Block {
  VirtualLights lights;
  std::uint64_t rays = 0;
};
void make_walk(const World& world, bool direct, Rng rng, Block& block);
std::optional<SurfacePoint> next_scattering(const World& world, Ray ray, std::uint64_t& rays);
void add_emission(const Scene& scene, const EmissionSample& e, VirtualLights& lights);
void add_vertex(const Vertex& vertex, Rgb power, int bounce, VirtualLights& lights);
void append(VirtualLights& to, const VirtualLights& from, float factor);
/// Blocks traced before their lights are joined: a few thousand lights a thread wait at a time.
std::size_t blocks_at_once(const LightForecast& forecast);
constexpr std::size_t kLightBytes =
    3 * sizeof(Vec3) + sizeof(float) + sizeof(Rgb) + sizeof(LightKind) + sizeof(std::uint8_t) + sizeof(std::uint32_t);

}  // namespace

LightResult trace_lights(const World& world, const LightParams& params, Progress& progress) {
  LightResult result;
  if (params.n_lights == 0 || !within_depth(world, 2)) return result;
  if (params.n_lights > 0x7fffffffu)
    throw Error(ErrorKind::limit, "at most 2^31 - 1 virtual lights in one pass; render more passes");
  const LightForecast forecast = forecast_lights(world, params);
  result.n_walks = result.lights.n_walks = forecast.n_walks;
  progress.stage("lights", result.n_walks, "walks");
  VirtualLights& lights = result.lights;
  const auto n = static_cast<std::size_t>(forecast.n_lights);
  lights.p.reserve(n), lights.n.reserve(n), lights.ng.reserve(n), lights.offset.reserve(n), lights.light.reserve(n);
  lights.kind.reserve(n), lights.bounce.reserve(n), lights.extra.reserve(n);
  lights.glossy.reserve(static_cast<std::size_t>(forecast.n_glossy));

  const std::size_t n_blocks = (result.n_walks + kWalksPerBlock - 1) / kWalksPerBlock;
  const std::size_t n_at_once = blocks_at_once(forecast);
  for (std::size_t first = 0; first < n_blocks; first += n_at_once) {
    std::vector<Block> blocks(std::min(n_at_once, n_blocks - first));
    parallel_for(blocks.size(), [&](std::size_t b) {
      const std::uint64_t begin = (first + b) * kWalksPerBlock, end = std::min(begin + kWalksPerBlock, result.n_walks);
      for (std::uint64_t w = begin; w < end; ++w)
        make_walk(world, params.direct, Rng(params.key, Stage::light_walk, w), blocks[b]);
      progress.advance(end - begin);
    });
    for (Block& block : blocks) {
      append(lights, block.lights, 1 / static_cast<float>(result.n_walks));
      result.light_rays += block.rays;
      block = {};
    }
  }
  return result;
}

LightForecast forecast_lights(const World& world, const LightParams& params) {
  if (params.n_lights == 0 || !within_depth(world, 2)) return {};
  constexpr std::size_t kBlocks = kPilotWalks / kWalksPerBlock;
  std::vector<Block> pilot(kBlocks);
  parallel_for(kBlocks, [&](std::size_t b) {
    for (std::uint64_t w = b * kWalksPerBlock; w < (b + 1) * kWalksPerBlock; ++w)
      make_walk(world, params.direct, Rng(params.key, Stage::light_walk, kPilotItems + w), pilot[b]);
  });
  std::size_t n_found = 0, n_glossy = 0;
  for (const Block& block : pilot) n_found += block.lights.size(), n_glossy += block.lights.glossy.size();
  // Where nearly all walks miss the scene, the number of walks is bounded rather than the number of lights reached.
  constexpr double kMostWalksPerLight = 1000;
  const auto n = static_cast<double>(params.n_lights), found = static_cast<double>(n_found);
  const double walks = n_found > 0 ? n * kPilotWalks / found : n * kMostWalksPerLight;
  const double margin = 1 + 3 / std::sqrt(found + 1), share = static_cast<double>(n_glossy) / std::max(1.0, found);
  const double glossy = std::min(1.0, share + 3 * std::sqrt(share / (found + 1)));
  const double n_most = std::ceil(n * margin);
  return {.n_walks = static_cast<std::uint64_t>(std::max(1.0, std::round(std::min(walks, n * kMostWalksPerLight)))),
          .n_lights = static_cast<std::uint64_t>(n_most),
          .n_glossy = static_cast<std::uint64_t>(std::ceil(n_most * glossy))};
}

std::uint64_t LightForecast::memory_bytes() const {
  return n_lights * kLightBytes + n_glossy * sizeof(VirtualLights::Glossy);
}

std::uint64_t VirtualLights::memory_bytes() const {
  return size() * kLightBytes + glossy.size() * sizeof(Glossy) + spots.size() * sizeof(Spot);
}

float VirtualLights::importance(const World& world, LightId id) const {
  const std::size_t j = index(id);
  if (kind[j] != LightKind::glossy) return luminance(light[j]);
  // The peak of f cos lies near the mirror direction, or along the normal for diffuse bases; rough glass: straight on.
  const Glossy& g = glossy[extra[j]];
  const Bsdf bsdf = make_bsdf(world.scene.materials[index(g.bsdf.material)], g.bsdf, world.sharp_alpha);
  const Vec3 wi = Frame(n[j]).to_local(g.wi);
  if (wi.z == 0) return 0;
  float peak = 0;
  for (const Vec3 w : {Vec3{-wi.x, -wi.y, wi.z}, Vec3{0, 0, std::copysign(1.0f, wi.z)}, -wi}) {
    const Rgb f_cos = evaluate(bsdf, wi, w, Lobes::wide) * std::fabs(w.z / wi.z);
    peak = std::max(peak, luminance(light[j] * f_cos));
  }
  return peak;
}

namespace {

std::size_t blocks_at_once(const LightForecast& forecast) {
  constexpr double kLightsAThread = 1 << 14, kMostBlocks = 1 << 14;
  const double lights_a_block = static_cast<double>(kWalksPerBlock) * static_cast<double>(forecast.n_lights) /
                                static_cast<double>(forecast.n_walks);
  const int n_threads = allowed_threads();
  return static_cast<std::size_t>(
      std::clamp(n_threads * kLightsAThread / lights_a_block, 4.0 * n_threads, kMostBlocks));
}

void make_walk(const World& world, bool direct, Rng rng, Block& block) {
  const float u_pick = rng.next();
  const Vec2 u_position{rng.next(), rng.next()}, u_direction{rng.next(), rng.next()};
  const EmissionSample e = world.emitters.sample_emission(u_pick, u_position, u_direction);
  if (direct && !is_black(e.light)) add_emission(world.scene, e, block.lights);

  Ray ray = e.ray;
  Rgb power = e.power;
  // A path through `bounce` edges, one to the receiver and one to the camera.
  for (int bounce = 1; !is_black(power) && within_depth(world, bounce + 2); ++bounce) {
    const auto hit = next_scattering(world, ray, block.rays);
    if (!hit) return;
    const Vertex vertex = make_vertex(world, *hit, -ray.direction);  // wo: towards where the power came from
    if (is_black_back(vertex)) return;
    const float arrival = std::fabs(dot(vertex.wo, vertex.n)) / std::fabs(dot(vertex.wo, hit->ng));
    if (!std::isfinite(arrival)) return;
    if (has_lobes(vertex.bsdf, Lobes::wide)) add_vertex(vertex, power * arrival, bounce, block.lights);

    // Goes on by all lobes.
    const float u_lobe = rng.next();
    const Vec2 u{rng.next(), rng.next()};
    const BsdfSample s = sample(vertex.bsdf, vertex.to_local(vertex.wo), u_lobe, u, Lobes::all, TransportMode::power);
    if (is_black(s.weight) || s.wi.z == 0) return;
    const Vec3 w = vertex.to_world(s.wi);
    const float departure = std::fabs(dot(w, hit->ng)) / std::fabs(s.wi.z);
    const Rgb next = power * s.weight * (arrival * departure);

    // Russian roulette by what the bounce kept, from the first bounce on, so that lights are of like power.
    const float kept = max_component(next) / max_component(power);
    const float survival = std::min(kept, bounce >= world.rr_depth ? 0.95f : 1.0f);
    if (!(rng.next() < survival)) return;
    power = next * (1 / survival);
    ray = {offset_origin(hit->p, hit->ng, hit->offset, w), w};
  }
}

std::optional<SurfacePoint> next_scattering(const World& world, Ray ray, std::uint64_t& rays) {
  for (;; ++rays) {
    auto hit = world.tracer.closest(ray);
    if (!hit || !is_null(world, *hit)) return ++rays, hit;
    ray = ray_behind(*hit, ray);
  }
}

void add_light(VirtualLights& lights, LightKind kind, Vec3 p, Vec3 n, Vec3 ng, float offset, Rgb light, int bounce,
               std::uint32_t extra) {
  lights.p.push_back(p), lights.n.push_back(n), lights.ng.push_back(ng), lights.offset.push_back(offset);
  lights.light.push_back(light), lights.kind.push_back(kind), lights.extra.push_back(extra);
  lights.bounce.push_back(static_cast<std::uint8_t>(std::min(bounce, 255)));
}

void add_emission(const Scene& scene, const EmissionSample& e, VirtualLights& lights) {
  switch (e.kind) {
    case EmissionSample::Kind::area:
      add_light(lights, LightKind::oriented, e.p, e.n, e.n, e.offset, e.light, 0, kNoExtra);
      return;
    case EmissionSample::Kind::distant:
      add_light(lights, LightKind::directional, {}, e.ray.direction, e.ray.direction, 0, e.light, 0, kNoExtra);
      return;
    case EmissionSample::Kind::point: {
      Vec3 axis = e.ray.direction;
      std::uint32_t extra = kNoExtra;
      if (const auto* spot = std::get_if<SpotEmitter>(&scene.emitters[index(e.emitter)].kind)) {
        if (spot->texture != kNone<TextureId>)
          throw Error(ErrorKind::input, to_string(scene.emitters[index(e.emitter)].at) +
                                            ": a spot with a texture cannot be a virtual light; use --direct sampled");
        axis = normalize(spot->to_world.vector({0, 0, 1}));
        extra = static_cast<std::uint32_t>(lights.spots.size());
        lights.spots.push_back({std::cos(spot->cutoff_deg * (kPi / 180)),
                                std::cos(std::min(spot->beam_deg, spot->cutoff_deg) * (kPi / 180))});
      }
      add_light(lights, LightKind::point, e.p, axis, axis, e.offset, e.light, 0, extra);
      return;
    }
  }
}

void add_vertex(const Vertex& vertex, Rgb power, int bounce, VirtualLights& lights) {
  const SurfacePoint& s = vertex.surface;
  const Vec3 ng = dot(s.ng, vertex.n) < 0 ? -s.ng : s.ng;
  if (is_wide_part_lambertian(vertex.bsdf)) {
    const Rgb intensity = power * vertex.bsdf.reflectance * kInvPi;
    if (!is_black(intensity))
      add_light(lights, LightKind::oriented, s.p, ng, ng, s.offset, intensity, bounce, kNoExtra);
    return;
  }
  const auto extra = static_cast<std::uint32_t>(lights.glossy.size());
  lights.glossy.push_back({vertex.wo, vertex.params});
  add_light(lights, LightKind::glossy, s.p, vertex.n, ng, s.offset, power, bounce, extra);
}

template <class T>
void append_all(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void append(VirtualLights& to, const VirtualLights& from, float factor) {
  const auto glossy = static_cast<std::uint32_t>(to.glossy.size()), spots = static_cast<std::uint32_t>(to.spots.size());
  append_all(to.p, from.p), append_all(to.n, from.n), append_all(to.ng, from.ng), append_all(to.offset, from.offset);
  append_all(to.kind, from.kind), append_all(to.bounce, from.bounce);
  append_all(to.glossy, from.glossy), append_all(to.spots, from.spots);
  for (const Rgb& l : from.light) to.light.push_back(l * factor);
  for (std::size_t j = 0; j < from.size(); ++j)
    to.extra.push_back(
        from.extra[j] == kNoExtra ? kNoExtra : from.extra[j] + (from.kind[j] == LightKind::glossy ? glossy : spots));
}

}  // namespace
}  // namespace myrialux
