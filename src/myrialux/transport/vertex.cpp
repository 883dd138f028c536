// From a hit to a vertex that can be shaded: BSDF with textures looked up, two-sided materials turned to the viewer.
#include "myrialux/transport/walk.h"

namespace myrialux {

Vertex make_vertex(const World& world, const SurfacePoint& surface, Vec3 wo) {
  Vertex vertex;
  vertex.surface = surface;
  vertex.wo = wo;
  // Sides are told by the shading normal, as Mitsuba does, so that BSDF and side never contradict each other.
  const bool front = dot(surface.n, wo) >= 0;
  vertex.params = resolve(world.scene, surface.material, surface.uv, front);
  const Material& material = world.scene.materials[index(vertex.params.material)];
  vertex.bsdf = make_bsdf(material, vertex.params, world.sharp_alpha);
  vertex.flipped = !front && world.scene.materials[index(surface.material)].two_sided;
  vertex.n = vertex.flipped ? -surface.n : surface.n;
  return vertex;
}

bool is_black_back(const Vertex& vertex) {
  const BsdfKind kind = vertex.bsdf.kind;
  const bool opaque = kind != BsdfKind::dielectric && kind != BsdfKind::thin_dielectric &&
                      kind != BsdfKind::rough_dielectric && kind != BsdfKind::null;
  return opaque && dot(vertex.n, vertex.wo) <= 0;
}

}  // namespace myrialux
