// Scenes made in code for the tracer's tests: triangle soups, and a mix of meshes, quadrics, cut-outs and instances.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/math/warp.h"
#include "support/build_scene.h"

namespace myrialux::test {

inline Vec3 random_point(Rng& rng, float half = 1) {
  const float x = rng.next(), y = rng.next(), z = rng.next();
  return Vec3{2 * x - 1, 2 * y - 1, 2 * z - 1} * half;
}
inline Vec3 random_direction(Rng& rng) {
  const float x = rng.next(), y = rng.next();
  return sample_sphere({x, y});
}

/// n triangles with corners within `size` of points of [-1, 1]^3.
inline Mesh triangle_soup(std::uint32_t n, float size, std::uint64_t item) {
  Rng rng({11, 0}, Stage::test, item);
  Mesh mesh;
  mesh.name = "soup";
  for (std::uint32_t k = 0; k < n; ++k) {
    const Vec3 at = random_point(rng);
    for (std::uint32_t c = 0; c < 3; ++c) {
      mesh.positions.push_back(at + random_point(rng, size));
      mesh.indices.push_back(3 * k + c);
    }
  }
  return mesh;
}

inline Transform random_rotation(Rng& rng) {
  const Vec3 axis = random_direction(rng);
  return Transform::rotate(axis, 360 * rng.next());
}

inline ShapeId add_shape(Scene& scene, std::variant<MeshId, Quadric> geometry, MaterialId material,
                         bool is_placed = true) {
  Shape s;
  s.name = "shape" + std::to_string(scene.shapes.size());
  s.geometry = geometry;
  s.material = material;
  scene.shapes.push_back(s);
  const auto id = static_cast<ShapeId>(scene.shapes.size() - 1);
  if (is_placed) scene.placed.push_back(id);
  return id;
}
inline ShapeId add_mesh(Scene& scene, Mesh mesh, MaterialId material, bool is_placed = true) {
  scene.meshes.push_back(std::move(mesh));
  return add_shape(scene, static_cast<MeshId>(scene.meshes.size() - 1), material, is_placed);
}

/// A material with opacity by a checkerboard of 0.3 and 0.8 (mean 0.55).
inline MaterialId add_cutout(Scene& scene) {
  Texture checks;
  checks.kind = Texture::Kind::checkerboard;
  checks.color0 = gray(0.3f), checks.color1 = gray(0.8f);
  checks.to_uv = Transform::scale({4, 4, 1});
  scene.textures.push_back(checks);
  Material m;
  m.name = "cutout";
  m.opacity = {gray(1), static_cast<TextureId>(scene.textures.size() - 1)};
  scene.materials.push_back(m);
  return static_cast<MaterialId>(scene.materials.size() - 1);
}

/// Soup, cut-out soup, quadrics with and without cut-outs in the world, and all of these again in three instances
/// (turned, sheared, mirrored), within about [-3, 3]^3.
inline Scene mixed_scene() {
  SceneBuilder b;
  const MaterialId plain = b.diffuse(gray(0.5f));
  Scene& scene = b.scene;
  const MaterialId cutout = add_cutout(scene);
  Rng rng({12, 0}, Stage::test, 0);
  const auto add_all = [&](bool is_placed, std::uint64_t item) {
    std::vector<ShapeId> shapes;
    shapes.push_back(add_mesh(scene, triangle_soup(150, 0.2f, item), plain, is_placed));
    shapes.push_back(add_mesh(scene, triangle_soup(150, 0.25f, item + 1), cutout, is_placed));
    for (const Quadric::Kind kind : {Quadric::Kind::sphere, Quadric::Kind::disk, Quadric::Kind::cylinder})
      for (int k = 0; k < 6; ++k) {
        const float size = 0.05f + 0.15f * rng.next();
        const Vec3 at = random_point(rng);
        const Transform m = Transform::translate(at) * random_rotation(rng) * Transform::scale({size, size, size});
        shapes.push_back(add_shape(scene, Quadric{kind, m}, k % 2 ? cutout : plain, is_placed));
      }
    return shapes;
  };
  add_all(true, 20);
  scene.groups.push_back({add_all(false, 30)});
  const Transform turned = Transform::rotate({1, 2, 3}, 40);
  scene.instances.push_back({0, Transform::translate({2, 0.3f, -1}) * turned});
  scene.instances.push_back({0, Transform::translate({-2, 1, 0.5f}) * Transform::scale({1.5f, 0.7f, 1}) * turned});
  scene.instances.push_back({0, Transform::translate({0, -2, 1}) * Transform::scale({-1, 1, 1})});
  return std::move(b.scene);
}

}  // namespace myrialux::test
