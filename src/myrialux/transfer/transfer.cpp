// One matrix entry without occlusion: BSDF and cosine at the receiver, intensity of the light, clamped 1 / d^2.
// [keller97]; geometry as in [walter05, eq. 1].
#include "myrialux/transfer/transfer.h"

#include <algorithm>

namespace myrialux {
namespace {

constexpr std::uint32_t kNoExtra = 0xffffffffu;

/// From the receiver to the light, not normalised; distant lights: unit, towards where the light comes from.
Vec3 to_light(const Receivers& receivers, std::size_t i, const VirtualLights& lights, std::size_t j) {
  return lights.kind[j] == LightKind::directional ? -lights.n[j] : lights.p[j] - receivers.p[i];
}

/// Geometric and shading normal agree that w leaves on the same side, and that side is lit or seen.
bool is_on_side(Vec3 w, Vec3 ng, Vec3 n, bool both_sides) {
  const float to_ng = dot(ng, w), to_n = dot(n, w);
  return (to_ng > 0 && to_n > 0) || (both_sides && to_ng < 0 && to_n < 0);
}

bool is_spot(const VirtualLights& lights, std::size_t j) {
  return lights.kind[j] == LightKind::point && lights.extra[j] != kNoExtra;
}

Bsdf bsdf_of(const World& world, const BsdfParams& params) {
  return make_bsdf(world.scene.materials[index(params.material)], params, world.sharp_alpha);
}

float spot_falloff(const VirtualLights::Spot& spot, float cos_axis);
Rgb intensity(const World& world, const VirtualLights& lights, std::size_t j, Vec3 w);

}  // namespace

Rgb transfer(const World& world, const Receivers& receivers, ReceiverId row, const VirtualLights& lights,
             LightId column, float clamp_distance) {
  if (!is_active(world, receivers, row, lights, column)) return {};
  const std::size_t i = index(row), j = index(column);
  const bool distant = lights.kind[j] == LightKind::directional;

  // Distance and direction; |d| > 0 since active entries have d . n != 0.
  const Vec3 d = to_light(receivers, i, lights, j);
  const float distance_squared = length_squared(d);
  const Vec3 wi = distant ? d : d / std::sqrt(distance_squared);
  const float geometry = distant ? 1 : 1 / std::max(distance_squared, clamp_distance * clamp_distance);

  // The receiver's normals face wo; a BSDF seen from inside stands the other way round.
  const Frame frame(receivers.inside[i] ? -receivers.n[i] : receivers.n[i]);
  const Bsdf bsdf = bsdf_of(world, receivers.bsdf[i]);
  const Rgb f_cos = evaluate(bsdf, frame.to_local(wi), frame.to_local(receivers.wo[i]), Lobes::wide);
  return f_cos * intensity(world, lights, j, -wi) * geometry;
}

bool transmits(const World& world, const BsdfParams& bsdf) {
  return world.scene.materials[index(bsdf.material)].kind == BsdfKind::rough_dielectric;
}

bool is_active(const World& world, const Receivers& receivers, ReceiverId row, const VirtualLights& lights,
               LightId column) {
  const std::size_t i = index(row), j = index(column);
  const Vec3 d = to_light(receivers, i, lights, j);
  if (!is_on_side(d, receivers.ng[i], receivers.n[i], transmits(world, receivers.bsdf[i]))) return false;
  switch (lights.kind[j]) {
    case LightKind::oriented:
      return is_on_side(-d, lights.ng[j], lights.n[j], false);
    case LightKind::glossy:
      return is_on_side(-d, lights.ng[j], lights.n[j], transmits(world, lights.glossy[lights.extra[j]].bsdf));
    case LightKind::point:
      return !is_spot(lights, j) || spot_falloff(lights.spots[lights.extra[j]], dot(lights.n[j], -d) / length(d)) > 0;
    case LightKind::directional:
      return true;
  }
  return false;
}

Segment shadow_segment(const Receivers& receivers, ReceiverId row, const VirtualLights& lights, LightId column) {
  const std::size_t i = index(row), j = index(column);
  const Vec3 d = to_light(receivers, i, lights, j);
  const Vec3 from = offset_origin(receivers.p[i], receivers.ng[i], receivers.offset[i], d);
  if (lights.kind[j] == LightKind::directional) return {from, d, true};
  if (lights.kind[j] == LightKind::point) return {from, lights.p[j], false};  // stands in the open
  return {from, offset_origin(lights.p[j], lights.ng[j], lights.offset[j], -d), false};
}

namespace {

/// Linear in the angle between beam and cutoff, as Mitsuba's spot.
float spot_falloff(const VirtualLights::Spot& spot, float cos_axis) {
  if (cos_axis <= spot.cos_cutoff) return 0;
  if (cos_axis >= spot.cos_beam) return 1;
  const float cutoff = std::acos(spot.cos_cutoff), beam = std::acos(spot.cos_beam);
  return (cutoff - std::acos(cos_axis)) / (cutoff - beam);
}

/// Radiant intensity of light j along w (unit), W/sr; directional: irradiance on a facing surface.
Rgb intensity(const World& world, const VirtualLights& lights, std::size_t j, Vec3 w) {
  switch (lights.kind[j]) {
    case LightKind::oriented:
      return lights.light[j] * std::max(dot(lights.n[j], w), 0.0f);
    case LightKind::glossy: {
      // evaluate() multiplies by the cosine of arrival; intensity has the geometric cosine of departure instead.
      const VirtualLights::Glossy& glossy = lights.glossy[lights.extra[j]];
      const Frame frame(lights.n[j]);
      const Vec3 wi = frame.to_local(glossy.wi);
      if (wi.z == 0) return {};
      const Rgb f_cos = evaluate(bsdf_of(world, glossy.bsdf), wi, frame.to_local(w), Lobes::wide);
      return lights.light[j] * (f_cos * std::fabs(dot(lights.ng[j], w) / wi.z));
    }
    case LightKind::point:
      return is_spot(lights, j) ? lights.light[j] * spot_falloff(lights.spots[lights.extra[j]], dot(lights.n[j], w))
                                : lights.light[j];
    case LightKind::directional:
      return lights.light[j];
  }
  return {};
}

}  // namespace
}  // namespace myrialux
