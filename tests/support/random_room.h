// Receivers and virtual lights strewn over the walls of a room and a ball in it, without tracing a single ray: all
// kinds of lights and wide lobes, for tests of transfer and clusters.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "myrialux/lights/virtual_lights.h"
#include "myrialux/math/warp.h"
#include "myrialux/receivers/receivers.h"
#include "support/build_scene.h"

namespace myrialux::test {

struct RoomOptions {
  std::size_t n_receivers = 256, n_lights = 1000;
  std::vector<LightKind> kinds = {LightKind::oriented};  ///< lights take turns
  bool glossy = false, glass = false;                    ///< materials of receivers and glossy lights besides diffuse
  float blinn_phong = 0;                                 ///< share of the glossy materials that are Blinn-Phong
  float shading_tilt = 0;                                ///< how far shading normals lean off geometric ones, as a sine
  std::uint64_t seed = 1;
};

/// Owns everything a World refers to.
class Room {
 public:
  explicit Room(const RoomOptions& options)
      : scene_(make_scene()), options_(options), rng_({options.seed}, Stage::test, 0) {
    tracer_ = std::make_unique<Tracer>(scene_);
    emitters_ = std::make_unique<Emitters>(scene_, tracer_->bounds());
    for (std::size_t i = 0; i < options.n_receivers; ++i) add_receiver();
    for (std::size_t j = 0; j < options.n_lights; ++j) add_light(options.kinds[j % options.kinds.size()]);
  }
  World world() const { return {.scene = scene_, .tracer = *tracer_, .emitters = *emitters_}; }
  static constexpr MaterialId kGlass{6}, kBlinnPhong{7};
  static constexpr float kRadius = 2.3f;  ///< of a sphere around the room

  Receivers receivers;
  VirtualLights lights;

 private:
  struct Place {
    Vec3 p, ng, n;
  };

  static Scene make_scene() {
    SceneBuilder b = cornell_builder({.objects = false});
    b.scene.materials.clear();
    b.diffuse({0.7f, 0.5f, 0.3f});
    Material m;
    m.kind = BsdfKind::rough_conductor;
    m.distribution = Microfacets::ggx;
    m.specular = {{0.9f, 0.7f, 0.5f}};
    b.add(m);
    m.distribution = Microfacets::beckmann;
    b.add(m);
    m.kind = BsdfKind::rough_plastic;
    m.distribution = Microfacets::ggx;
    m.eta = 1.49f;
    b.add(m);
    m.distribution = Microfacets::beckmann;
    m.nonlinear = true;
    b.add(m);
    m.kind = BsdfKind::plastic;
    b.add(m);
    m.kind = BsdfKind::rough_dielectric;
    b.add(m);
    m.kind = BsdfKind::blinn_phong;
    b.add(m);
    return std::move(b.scene);
  }

  Vec2 square() {
    const float x = rng_.next();
    return {x, rng_.next()};
  }
  Vec3 hemisphere(Vec3 n) {
    Vec3 w = sample_cosine_hemisphere(square());
    w.z = std::max(w.z, 0.02f);
    return Frame(n).to_world(normalize(w));
  }
  Place place() {
    Place s;
    if (rng_.next() < 0.3f) {
      s.ng = sample_sphere(square());
      s.p = Vec3{0.2f, -0.4f, 0.1f} + s.ng * 0.4f;
    } else {
      const auto axis = static_cast<int>(rng_.below(3));
      const float side = rng_.below(2) ? 1.0f : -1.0f;
      const Vec2 u = square();
      s.p[axis] = side, s.p[(axis + 1) % 3] = 2 * u.x - 1, s.p[(axis + 2) % 3] = 2 * u.y - 1;
      s.ng[axis] = -side;
    }
    s.n = normalize(s.ng + sample_sphere(square()) * options_.shading_tilt);
    return s;
  }
  BsdfParams material(bool glossy) {
    BsdfParams params;
    const std::uint32_t n = options_.glass ? 7 : 6;
    params.material = static_cast<MaterialId>(glossy ? 1 + rng_.below(n - 1) : 0);
    if (glossy && options_.blinn_phong > 0 && rng_.next() < options_.blinn_phong) params.material = kBlinnPhong;
    constexpr float kAlphas[] = {0.11f, 0.15f, 0.2f, 0.3f, 0.5f, 0.8f};  // tables of rough plastic are made for each
    params.alpha = kAlphas[rng_.below(6)];
    params.reflectance = {rng_.next(), rng_.next(), rng_.next()};
    params.specular = {rng_.next(), rng_.next(), rng_.next()};
    return params;
  }
  bool is_glass(const BsdfParams& params) const {
    return scene_.materials[index(params.material)].kind == BsdfKind::rough_dielectric;
  }

  void add_receiver() {
    const Place s = place();
    receivers.p.push_back(s.p), receivers.ng.push_back(s.ng), receivers.n.push_back(s.n);
    receivers.offset.push_back(1e-4f);
    receivers.wo.push_back(hemisphere(s.n));
    receivers.bsdf.push_back(material(options_.glossy && rng_.below(2)));
    receivers.beta.push_back(gray(1));
    receivers.sample.push_back(static_cast<std::uint32_t>(receivers.sample.size()));
    receivers.depth.push_back(1);
    receivers.inside.push_back(is_glass(receivers.bsdf.back()) && rng_.below(2));
  }

  void add_light(LightKind kind) {
    Place s = place();
    std::uint32_t extra = 0xffffffffu;
    if (kind == LightKind::point) s.p = s.p * 0.8f, s.n = s.ng = sample_sphere(square());
    if (kind == LightKind::directional) s.n = s.ng = -hemisphere({0, 0.6f, 0.8f});
    if (kind == LightKind::point && rng_.below(2)) {
      extra = static_cast<std::uint32_t>(lights.spots.size());
      lights.spots.push_back({0.5f, 0.7f});
    }
    if (kind == LightKind::glossy) {
      extra = static_cast<std::uint32_t>(lights.glossy.size());
      lights.glossy.push_back({hemisphere(s.n), material(true)});
    }
    const float strength = std::pow(rng_.next(), 3.0f);
    lights.p.push_back(s.p), lights.n.push_back(s.n), lights.ng.push_back(s.ng);
    lights.offset.push_back(1e-4f);
    lights.light.push_back(Rgb{rng_.next(), rng_.next(), rng_.next()} * strength);
    lights.kind.push_back(kind);
    lights.bounce.push_back(0);
    lights.extra.push_back(extra);
  }

  Scene scene_;
  RoomOptions options_;
  Rng rng_;
  std::unique_ptr<Tracer> tracer_;
  std::unique_ptr<Emitters> emitters_;
};

}  // namespace myrialux::test
