// Chooses emitters by power and hands the rest to the kinds: areas, environment, points, spots, parallel light.
#include "myrialux/emitters/emitters.h"

#include <cmath>
#include <string>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/emitters/area.h"
#include "myrialux/emitters/environment.h"
#include "myrialux/emitters/spot.h"
#include "myrialux/math/distribution.h"
#include "myrialux/math/warp.h"

namespace myrialux {

namespace {

using Source = std::variant<AreaSampler, ConstantEmitter, EnvironmentMap, PointEmitter, Spot, DirectionalEmitter>;

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

/// The sphere around the scene, a little larger, so that discs outside touch nothing.
struct Surroundings {
  Vec3 centre;
  float radius;
  float disc_area() const { return kPi * radius * radius; }
};
Surroundings surroundings(const Box3& bounds);

Source make_source(const Scene& scene, const Emitter& emitter);
Rgb power_of(const Source& source, const Surroundings& around);
std::string place(const Scene& scene);

/// Parallel light from one direction: start on the disc outside the scene that faces it.
EmissionSample distant_emission(const Surroundings& around, Vec3 travel, Rgb irradiance, Vec2 u_position);

}  // namespace

struct Emitters::State {
  std::vector<Source> sources;  ///< [Scene::emitters]
  std::vector<Rgb> powers;
  Distribution1D pick;
  Surroundings around;
  const Source& source(EmitterId id) const { return sources[index(id)]; }
};

Emitters::Emitters(const Scene& scene, const Box3& bounds) {
  if (scene.emitters.empty())
    throw Error(ErrorKind::input, place(scene) + "there is no emitter, so the picture would be black; add one");
  auto state = std::make_unique<State>();
  state->around = surroundings(bounds);
  std::vector<float> weights;
  for (std::size_t i = 0; i < scene.emitters.size(); ++i) {
    state->sources.push_back(make_source(scene, scene.emitters[i]));
    const Source& source = state->sources.back();
    if (std::holds_alternative<ConstantEmitter>(source) || std::holds_alternative<EnvironmentMap>(source)) {
      if (has_environment())
        throw Error(ErrorKind::input, place(scene) + "there are two environment emitters; only one is allowed");
      environment_ = static_cast<EmitterId>(i);
    }
    const Rgb power = power_of(source, state->around);
    if (!is_finite(power) || power.r < 0 || power.g < 0 || power.b < 0)
      throw Error(ErrorKind::input, place(scene) + "emitter '" + scene.emitters[i].name +
                                        "' has a negative or infinite power; its radiance must be finite and >= 0");
    state->powers.push_back(power);
    weights.push_back(luminance(power));
  }
  state->pick = Distribution1D(weights);
  if (!(state->pick.sum() > 0))
    throw Error(ErrorKind::input, place(scene) + "all emitters are black, so the picture would be black");
  state_ = std::move(state);
}
Emitters::~Emitters() = default;
Emitters::Emitters(Emitters&&) noexcept = default;

Rgb Emitters::emitted(EmitterId emitter, Vec2 uv, Vec3 n, Vec3 direction) const {
  if (!(dot(n, direction) < 0)) return {};
  const auto* area = std::get_if<AreaSampler>(&state_->source(emitter));
  return area ? area->radiance(uv) : Rgb{};
}

Rgb Emitters::environment(Vec3 direction) const {
  if (!has_environment()) return {};
  const Source& source = state_->source(environment_);
  if (const auto* constant = std::get_if<ConstantEmitter>(&source)) return constant->radiance;
  return std::get<EnvironmentMap>(source).radiance(direction);
}

std::optional<DirectSample> Emitters::sample_direct(Vec3 p, float u_pick, Vec2 u) const {
  const Distribution1D::Sample picked = state_->pick.sample(u_pick);
  DirectSample s;
  s.pdf_omega = picked.probability;
  const auto distant = [&](Vec3 wi, float pdf_omega, Rgb radiance, bool is_delta) {
    s.wi = wi, s.pdf_omega *= pdf_omega, s.radiance = radiance;
    s.is_distant = true, s.is_delta = is_delta, s.distance = kInfinity;
  };
  const auto from_point = [&](Vec3 position, auto intensity) {
    const Vec3 d = position - p;
    s.distance = length(d), s.to = position, s.is_delta = true;
    if (!(s.distance > 0)) return;
    s.wi = d / s.distance;
    s.radiance = intensity(-s.wi) * (1 / (s.distance * s.distance));
  };
  std::visit(Overloaded{[&](const AreaSampler& area) {
                          const AreaSampler::Towards on = area.sample_towards(p, picked.reused, u);
                          if (!(on.pdf_omega > 0)) return;
                          s.wi = on.wi, s.distance = on.distance, s.pdf_omega *= on.pdf_omega;
                          s.to = on.at.p + on.at.ng * on.at.offset;
                          s.radiance = area.radiance(on.at.uv);
                        },
                        [&](const ConstantEmitter& c) { distant(sample_sphere(u), 0.25f * kInvPi, c.radiance, false); },
                        [&](const EnvironmentMap& map) {
                          const EnvironmentMap::Sample to = map.sample(u);
                          if (to.pdf_omega > 0) distant(to.direction, to.pdf_omega, map.radiance(to.direction), false);
                        },
                        [&](const PointEmitter& e) { from_point(e.position, [&](Vec3) { return e.intensity; }); },
                        [&](const Spot& e) { from_point(e.position, [&](Vec3 w) { return e.intensity(w); }); },
                        [&](const DirectionalEmitter& e) { distant(-normalize(e.direction), 1, e.irradiance, true); }},
             state_->sources[picked.index]);
  if (is_black(s.radiance)) return std::nullopt;
  return s;
}

float Emitters::direct_pdf_omega(Vec3 p, EmitterId emitter, Vec3 p_on, Vec3 ng, std::uint32_t) const {
  const auto* area = std::get_if<AreaSampler>(&state_->source(emitter));
  return area ? probability(emitter) * area->pdf_omega(p, p_on, ng) : 0;
}

float Emitters::environment_pdf_omega(Vec3 direction) const {
  if (!has_environment()) return 0;
  const auto* map = std::get_if<EnvironmentMap>(&state_->source(environment_));
  return probability(environment_) * (map ? map->pdf_omega(direction) : 0.25f * kInvPi);
}

EmissionSample Emitters::sample_emission(float u_pick, Vec2 u_position, Vec2 u_direction) const {
  const Distribution1D::Sample picked = state_->pick.sample(u_pick);
  const float selection = picked.probability;
  const Surroundings& around = state_->around;
  const auto from_point = [](Vec3 position, Vec3 axis, Vec3 direction, Rgb power, Rgb light) {
    EmissionSample s;
    s.kind = EmissionSample::Kind::point;
    s.p = position, s.n = axis, s.ray = {position, direction, kInfinity}, s.power = power, s.light = light;
    return s;
  };
  EmissionSample s = std::visit(
      Overloaded{[&](const AreaSampler& area) {
                   const AreaSampler::Sample on = area.sample(picked.reused, u_position);
                   EmissionSample e;
                   e.p = on.at.p, e.n = on.at.ng, e.offset = on.at.offset;
                   const Vec3 w = Frame(e.n).to_world(sample_cosine_hemisphere(u_direction));
                   e.ray = {e.p + e.n * e.offset, w, kInfinity};
                   e.light = area.radiance(on.at.uv) * (1 / (on.pdf_area * selection));
                   e.power = e.light * kPi;  // cosine and its density leave pi
                   return e;
                 },
                 [&](const ConstantEmitter& c) {
                   return distant_emission(around, -sample_sphere(u_direction), c.radiance * (4 * kPi / selection),
                                           u_position);
                 },
                 [&](const EnvironmentMap& map) {
                   const EnvironmentMap::Sample from = map.sample(u_direction);
                   const float weight = from.pdf_omega > 0 ? 1 / (from.pdf_omega * selection) : 0;
                   return distant_emission(around, -from.direction, map.radiance(from.direction) * weight, u_position);
                 },
                 [&](const PointEmitter& e) {
                   const Rgb light = e.intensity * (1 / selection);
                   return from_point(e.position, {0, 0, 1}, sample_sphere(u_direction), light * (4 * kPi), light);
                 },
                 [&](const Spot& e) {
                   const float versine = 1 - e.cos_cutoff;
                   const Vec3 w = Frame(e.axis).to_world(sample_narrow_cone(u_direction, versine));
                   return from_point(e.position, e.axis, w, e.intensity(w) * (2 * kPi * versine / selection),
                                     e.intensity(e.axis) * (1 / selection));
                 },
                 [&](const DirectionalEmitter& e) {
                   return distant_emission(around, normalize(e.direction), e.irradiance * (1 / selection), u_position);
                 }},
      state_->sources[picked.index]);
  s.emitter = static_cast<EmitterId>(picked.index);
  return s;
}

Rgb Emitters::power() const {
  Rgb sum;
  for (const Rgb& power : state_->powers) sum += power;
  return sum;
}
Rgb Emitters::power(EmitterId emitter) const { return state_->powers[index(emitter)]; }
float Emitters::probability(EmitterId emitter) const { return state_->pick.probability(index(emitter)); }

namespace {

Surroundings surroundings(const Box3& bounds) {
  if (bounds.is_empty() || !(bounds.diagonal() > 0)) return {bounds.is_empty() ? Vec3{} : bounds.centre(), 1};
  return {bounds.centre(), 0.5f * bounds.diagonal() * (1 + 0x1p-10f)};
}

Source make_source(const Scene& scene, const Emitter& emitter) {
  return std::visit(Overloaded{[&](const AreaEmitter& e) -> Source { return AreaSampler(scene, e); },
                               [&](const EnvmapEmitter& e) -> Source { return EnvironmentMap(scene, e); },
                               [&](const SpotEmitter& e) -> Source { return Spot(scene, e); },
                               [&](const auto& e) -> Source { return e; }},
                    emitter.kind);
}

Rgb power_of(const Source& source, const Surroundings& around) {
  return std::visit(
      Overloaded{[&](const AreaSampler& e) { return e.power(); },
                 [&](const ConstantEmitter& e) { return e.radiance * (4 * kPi * around.disc_area()); },
                 [&](const EnvironmentMap& e) { return e.integral() * around.disc_area(); },
                 [&](const PointEmitter& e) { return e.intensity * (4 * kPi); }, [&](const Spot& e) { return e.power; },
                 [&](const DirectionalEmitter& e) { return e.irradiance * around.disc_area(); }},
      source);
}

EmissionSample distant_emission(const Surroundings& around, Vec3 travel, Rgb irradiance, Vec2 u_position) {
  EmissionSample s;
  s.kind = EmissionSample::Kind::distant;
  const Frame frame(travel);
  const Vec2 d = sample_disc(u_position);
  s.n = travel;
  s.p = around.centre + (frame.s * d.x + frame.t * d.y - travel) * around.radius;
  s.ray = {s.p, travel, kInfinity};
  s.light = irradiance;
  s.power = irradiance * around.disc_area();
  return s;
}

std::string place(const Scene& scene) { return scene.path.empty() ? "scene: " : scene.path + ": "; }

}  // namespace

}  // namespace myrialux
