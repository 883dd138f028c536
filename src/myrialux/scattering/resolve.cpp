// Looks up the textures of a material at a point of the surface.
#include "myrialux/scattering/bsdf.h"
#include "myrialux/scattering/lobes.h"

namespace myrialux {
namespace {

Rgb look_up(const Scene& scene, const ColorSlot& slot, Vec2 uv) {
  if (slot.texture == kNone<TextureId>) return slot.value;
  return slot.value * evaluate(scene.textures[index(slot.texture)], uv);
}

}  // namespace

BsdfParams resolve(const Scene& scene, MaterialId id, Vec2 uv, bool front) {
  const Material& given = scene.materials[index(id)];
  BsdfParams params;
  params.material = !front && given.two_sided && given.back != kNone<MaterialId> ? given.back : id;
  const Material& material = scene.materials[index(params.material)];
  params.alpha = mean(look_up(scene, material.alpha, uv));
  params.specular = look_up(scene, material.specular, uv);
  const bool is_dielectric =
      !has_diffuse(material.kind) && material.kind != BsdfKind::conductor && material.kind != BsdfKind::rough_conductor;
  params.reflectance = look_up(scene, is_dielectric ? material.transmittance : material.reflectance, uv);
  return params;
}

}  // namespace myrialux
