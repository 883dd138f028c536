// Scenes made in code for tests: furnace inside a sphere, Cornell box, box with a glass pane, box with a glossy floor.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "myrialux/scene/scene.h"

namespace myrialux::test {

/// Puts a scene together piece by piece; hand out `scene` when done.
struct SceneBuilder {
  Scene scene;

  MaterialId add(const Material& material) {
    scene.materials.push_back(material);
    return static_cast<MaterialId>(scene.materials.size() - 1);
  }
  MaterialId diffuse(Rgb reflectance, bool two_sided = false) {
    Material m;
    m.name = "diffuse" + std::to_string(scene.materials.size());
    m.kind = BsdfKind::diffuse;
    m.reflectance = {reflectance};
    m.two_sided = two_sided;
    return add(m);
  }
  /// Triangles; the front is where corners run counter-clockwise.
  ShapeId mesh(std::vector<Vec3> positions, std::vector<std::uint32_t> indices, MaterialId material) {
    Mesh m;
    m.name = "mesh" + std::to_string(scene.meshes.size());
    m.positions = std::move(positions);
    m.indices = std::move(indices);
    scene.meshes.push_back(std::move(m));
    return place(static_cast<MeshId>(scene.meshes.size() - 1), material);
  }
  /// Parallelogram corner, corner + u, corner + v; normal along u x v; uv runs along u and v.
  ShapeId rectangle(Vec3 corner, Vec3 u, Vec3 v, MaterialId material) {
    const ShapeId shape = mesh({corner, corner + u, corner + u + v, corner + v}, {0, 1, 2, 0, 2, 3}, material);
    scene.meshes.back().uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    return shape;
  }
  /// Axis-aligned box, normals outwards (inwards if `inward`).
  ShapeId box(Vec3 lower, Vec3 upper, MaterialId material, bool inward = false) {
    std::vector<Vec3> corners;
    for (int k = 0; k < 8; ++k)
      corners.push_back({k & 1 ? upper.x : lower.x, k & 2 ? upper.y : lower.y, k & 4 ? upper.z : lower.z});
    std::vector<std::uint32_t> indices = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                          2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    if (inward)
      for (std::size_t k = 0; k < indices.size(); k += 3) std::swap(indices[k], indices[k + 1]);
    return mesh(std::move(corners), std::move(indices), material);
  }
  ShapeId sphere(Vec3 centre, float radius, MaterialId material, bool flip_normals = false) {
    Quadric q;
    q.kind = Quadric::Kind::sphere;
    q.to_world = Transform::translate(centre) * Transform::scale({radius, radius, radius});
    const ShapeId shape = place(q, material);
    scene.shapes[index(shape)].flip_normals = flip_normals;
    return shape;
  }
  /// Octahedron split `n_splits` times and pushed out onto a sphere, shaded smoothly: n and ng differ by up to 55
  /// degrees at 0 splits, halved by each split.
  ShapeId smooth_ball(Vec3 centre, float radius, int n_splits, MaterialId material) {
    std::vector<Vec3> unit = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    std::vector<std::uint32_t> indices = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    for (int split = 0; split < n_splits; ++split) {
      std::vector<std::uint32_t> finer;
      for (std::size_t k = 0; k < indices.size(); k += 3) {
        std::uint32_t mid[3];  // repeated vertices do no harm: their normals are equal
        for (std::size_t e = 0; e < 3; ++e) {
          mid[e] = static_cast<std::uint32_t>(unit.size());
          unit.push_back(normalize(unit[indices[k + e]] + unit[indices[k + (e + 1) % 3]]));
        }
        const std::uint32_t a = indices[k], b = indices[k + 1], c = indices[k + 2];
        for (const std::uint32_t i : {a, mid[0], mid[2], mid[0], b, mid[1], mid[2], mid[1], c, mid[0], mid[1], mid[2]})
          finer.push_back(i);
      }
      indices = std::move(finer);
    }
    std::vector<Vec3> positions;
    for (const Vec3 v : unit) positions.push_back(centre + v * radius);
    const ShapeId shape = mesh(std::move(positions), std::move(indices), material);
    scene.meshes.back().normals = std::move(unit);
    return shape;
  }
  EmitterId area_emitter(ShapeId shape, Rgb radiance) {
    Emitter e;
    e.name = "area" + std::to_string(scene.emitters.size());
    e.kind = AreaEmitter{shape, {radiance}};
    const EmitterId id = emitter(e);
    scene.shapes[index(shape)].emitter = id;
    return id;
  }
  EmitterId emitter(const Emitter& e) {
    scene.emitters.push_back(e);
    return static_cast<EmitterId>(scene.emitters.size() - 1);
  }
  EmitterId emitter(const std::string& name, const decltype(Emitter::kind)& kind) {
    Emitter e;
    e.name = name;
    e.kind = kind;
    return emitter(e);
  }
  void camera(Vec3 origin, Vec3 target, float fov_x_deg, int width, int height) {
    scene.camera.to_world = Transform::look_at(origin, target, {0, 1, 0});
    scene.camera.fov_x_deg = fov_x_deg;
    scene.camera.near_clip = 1e-4f;
    scene.film.width = width, scene.film.height = height;
    scene.film.filter = {Filter::Kind::box, 0.5f};
  }

 private:
  ShapeId place(std::variant<MeshId, Quadric> geometry, MaterialId material) {
    Shape s;
    s.name = "shape" + std::to_string(scene.shapes.size());
    s.geometry = geometry;
    s.material = material;
    scene.shapes.push_back(std::move(s));
    const auto id = static_cast<ShapeId>(scene.shapes.size() - 1);
    scene.placed.push_back(id);
    return id;
  }
};

/// Inside of a unit sphere, diffuse albedo a, emission 1 everywhere: radiance after D edges is the sum of a^k, k < D.
inline Scene furnace_sphere(float albedo) {
  SceneBuilder b;
  b.area_emitter(b.sphere({0, 0, 0}, 1, b.diffuse(gray(albedo)), true), gray(1));
  b.camera({0.2f, -0.1f, 0.3f}, {0.3f, 0.4f, -1}, 60, 16, 16);
  return std::move(b.scene);
}

/// The box [-1, 1]^3 open towards +z, red and green walls, lamp of 0.8 x 0.8 below the ceiling, camera at z = 3.8.
struct CornellOptions {
  bool objects = true;
  Rgb lamp = {18, 15, 10};
  const Material* floor = nullptr;  ///< instead of white diffuse
};
inline SceneBuilder cornell_builder(const CornellOptions& options = {}) {
  SceneBuilder b;
  const MaterialId white = b.diffuse({0.73f, 0.72f, 0.68f}), red = b.diffuse({0.6f, 0.06f, 0.05f}),
                   green = b.diffuse({0.14f, 0.45f, 0.09f});
  const MaterialId floor = options.floor ? b.add(*options.floor) : white;
  b.rectangle({-1, -1, 1}, {2, 0, 0}, {0, 0, -2}, floor);
  b.rectangle({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, white);
  b.rectangle({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, white);
  b.rectangle({-1, -1, 1}, {0, 0, -2}, {0, 2, 0}, red);
  b.rectangle({1, -1, -1}, {0, 0, 2}, {0, 2, 0}, green);
  if (options.objects) {
    b.box({-0.7f, -1, -0.6f}, {-0.1f, 0.2f, -0.1f}, white);
    b.box({0.15f, -1, 0}, {0.7f, -0.4f, 0.5f}, white);
  }
  b.area_emitter(b.rectangle({-0.4f, 0.98f, -0.4f}, {0.8f, 0, 0}, {0, 0, 0.8f}, b.diffuse({0.3f, 0.3f, 0.3f})),
                 options.lamp);
  b.camera({0, 0, 3.8f}, {0, 0, 0}, 39, 32, 32);
  return b;
}
inline Scene cornell_box() { return std::move(cornell_builder().scene); }

/// The Cornell box with a slab of glass (index 1.5) across it, between the lamp and half of the floor.
inline Scene glass_pane_box() {
  SceneBuilder b = cornell_builder();
  Material glass;
  glass.name = "glass";
  glass.kind = BsdfKind::dielectric;
  glass.eta = 1.5f;
  b.box({-0.95f, 0.4f, -0.95f}, {0.3f, 0.48f, 0.9f}, b.add(glass));
  return std::move(b.scene);
}

/// The Cornell box on a rough metal floor. alpha <= 0.1 is sharp by default, above it wide.
inline Scene glossy_floor_box(float alpha) {
  Material metal;
  metal.name = "metal";
  metal.kind = BsdfKind::rough_conductor;
  metal.distribution = Microfacets::ggx;
  metal.alpha = metal.alpha_v = {gray(alpha)};
  metal.eta_metal = {0, 0, 0};
  metal.k_metal = {1, 1, 1};
  metal.specular = {{0.8f, 0.75f, 0.7f}};
  CornellOptions options;
  options.floor = &metal;
  return std::move(cornell_builder(options).scene);
}

/// The Cornell box on a floor of an MTL file's Kd, Ks, Ns. Ns above 198 is sharp by default, below it wide.
inline Scene blinn_phong_floor_box(float exponent) {
  Material floor;
  floor.name = "floor";
  floor.kind = BsdfKind::blinn_phong;
  floor.alpha = floor.alpha_v = {gray(std::sqrt(2 / (exponent + 2)))};
  floor.reflectance = {{0.3f, 0.2f, 0.1f}};
  floor.specular = {{0.5f, 0.6f, 0.7f}};
  CornellOptions options;
  options.floor = &floor;
  return std::move(cornell_builder(options).scene);
}

/// The Cornell box on a varnished floor: plastic has a sharp lobe (delta coat) and a wide one (diffuse base).
inline Scene plastic_floor_box() {
  Material varnish;
  varnish.name = "varnish";
  varnish.kind = BsdfKind::plastic;
  varnish.eta = 1.5f;
  varnish.reflectance = {{0.5f, 0.4f, 0.2f}};
  CornellOptions options;
  options.floor = &varnish;
  return std::move(cornell_builder(options).scene);
}

}  // namespace myrialux::test
