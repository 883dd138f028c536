// Cut-outs: decides by a hash of ray and primitive whether a partly transparent surface stops a ray.
#include <bit>

#include "myrialux/trace/acceleration.h"

namespace myrialux {

namespace {

float opacity_at(const Scene& scene, const ColorSlot& opacity, Vec2 uv);
/// A finaliser of 64-bit hashes. Source: [steele14], splitmix64
std::uint64_t mix(std::uint64_t z);

}  // namespace

bool has_cutouts(const Scene& scene, const Material& material) {
  const ColorSlot& opacity = material.opacity;
  if (mean(opacity.value) < 1) return true;
  if (opacity.texture == kNone<TextureId>) return false;
  const Texture& texture = scene.textures[index(opacity.texture)];
  const auto is_below = [&](Rgb c) { return mean(opacity.value * c) < 1; };
  if (texture.kind == Texture::Kind::checkerboard) return is_below(texture.color0) || is_below(texture.color1);
  const Image& image = *texture.image;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (is_below(image.texel(x, y))) return true;
  return false;
}

bool mask_keeps(const Scene& scene, const Material& material, Vec2 uv, Vec3 origin, Vec3 direction, unsigned instance,
                unsigned geometry, unsigned primitive, unsigned crossing) {
  const auto join = [](float a, float b) {
    return std::uint64_t{std::bit_cast<std::uint32_t>(a)} << 32 | std::bit_cast<std::uint32_t>(b);
  };
  std::uint64_t h = mix(join(origin.x, origin.y));
  h = mix(h ^ join(origin.z, direction.x));
  h = mix(h + join(direction.y, direction.z));
  h = mix(h ^ (std::uint64_t{instance} << 32 | geometry));
  h = mix(h + (std::uint64_t{primitive} << 1 | crossing));
  const float u = static_cast<float>(h >> 40) * 0x1p-24f;
  return u < opacity_at(scene, material.opacity, uv);
}

void mask_filter(const RTCFilterFunctionNArguments* a) {
  const auto* context = reinterpret_cast<const QueryContext*>(a->context);
  const auto& record = *static_cast<const GeometryRecord*>(a->geometryUserPtr);
  const Mesh& mesh = record.scene->meshes[index(std::get<MeshId>(record.the_shape().geometry))];
  for (unsigned i = 0; i < a->N; ++i) {
    if (a->valid[i] != -1) continue;
    const unsigned lane = RTCRayN_id(a->ray, a->N, i), primitive = RTCHitN_primID(a->hit, a->N, i);
    const float b1 = RTCHitN_u(a->hit, a->N, i), b2 = RTCHitN_v(a->hit, a->N, i);
    Vec2 uv{b1, b2};
    if (!mesh.uvs.empty()) {
      const std::uint32_t* corner = &mesh.indices[3 * std::size_t{primitive}];
      const Vec2 t0 = mesh.uvs[corner[0]], t1 = mesh.uvs[corner[1]], t2 = mesh.uvs[corner[2]];
      const float b0 = 1 - b1 - b2;
      uv = {b0 * t0.x + b1 * t1.x + b2 * t2.x, b0 * t0.y + b1 * t1.y + b2 * t2.y};
    }
    if (!mask_keeps(*record.scene, record.material(), uv, context->origin(lane), context->direction(lane),
                    RTCHitN_instID(a->hit, a->N, i, 0), RTCHitN_geomID(a->hit, a->N, i), primitive, 0))
      a->valid[i] = 0;
  }
}

void pass_filter(const RTCFilterFunctionNArguments* a) {
  for (unsigned i = 0; i < a->N; ++i) a->valid[i] = 0;
}

namespace {

float opacity_at(const Scene& scene, const ColorSlot& opacity, Vec2 uv) {
  if (opacity.texture == kNone<TextureId>) return mean(opacity.value);
  return mean(opacity.value * evaluate(scene.textures[index(opacity.texture)], uv));
}

std::uint64_t mix(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

}  // namespace

}  // namespace myrialux
