// Bounds and sizes of a scene; placement of a moving camera.
#include "myrialux/scene/scene.h"

#include <algorithm>
#include <cmath>

#include "myrialux/base/assert.h"
#include "myrialux/math/rigid_motion.h"

namespace myrialux {

namespace {

Box3 bounds_of(const Quadric& quadric);
Box3 bounds_of(const Scene& scene, const Shape& shape);
Box3 bounds_of(const Scene& scene, const ShapeGroup& group);
std::uint64_t n_triangles_of(const Scene& scene, const Shape& shape);

}  // namespace

Box3 Scene::bounds() const {
  Box3 box;
  for (const ShapeId shape : placed) box.add(bounds_of(*this, shapes[index(shape)]));
  std::vector<Box3> of_group;
  for (const ShapeGroup& group : groups) of_group.push_back(bounds_of(*this, group));
  for (const Instance& instance : instances) {
    MYRIALUX_ASSERT(instance.group < groups.size());
    const Box3& b = of_group[instance.group];
    if (b.is_empty()) continue;
    for (int corner = 0; corner < 8; ++corner)
      box.add(instance.to_world.point({corner & 1 ? b.upper.x : b.lower.x, corner & 2 ? b.upper.y : b.lower.y,
                                       corner & 4 ? b.upper.z : b.lower.z}));
  }
  return box;
}

std::uint64_t Scene::n_triangles() const {
  std::uint64_t n = 0;
  for (const ShapeId shape : placed) n += n_triangles_of(*this, shapes[index(shape)]);
  std::vector<std::uint64_t> of_group;
  for (const ShapeGroup& group : groups) {
    of_group.push_back(0);
    for (const ShapeId shape : group.shapes) of_group.back() += n_triangles_of(*this, shapes[index(shape)]);
  }
  for (const Instance& instance : instances) n += of_group[instance.group];
  return n;
}

Transform Camera::at(double time) const {
  if (motion.empty()) return to_world;
  const auto next =
      std::upper_bound(motion.begin(), motion.end(), time, [](double t, const CameraKey& key) { return t < key.time; });
  if (next == motion.begin()) return motion.front().to_world;
  const CameraKey& last = *(next - 1);
  if (next == motion.end() || last.time == time) return last.to_world;
  return rigid_between(last.to_world, next->to_world, (time - last.time) / (next->time - last.time));
}

namespace {

Box3 bounds_of(const Quadric& quadric) {
  const auto& m = quadric.to_world.rows();
  const bool is_sphere = quadric.kind == Quadric::Kind::sphere;
  Vec3 centre, top, extent;
  for (int r = 0; r < 3; ++r) {
    const double x = m[4 * r], y = m[4 * r + 1], z = is_sphere ? m[4 * r + 2] : 0;
    centre[r] = static_cast<float>(m[4 * r + 3]);
    extent[r] = static_cast<float>(std::sqrt(x * x + y * y + z * z));  // of the image of the unit sphere or disc
    top[r] = static_cast<float>(m[4 * r + 3] + m[4 * r + 2]);
  }
  Box3 box{centre - extent, centre + extent};
  if (quadric.kind == Quadric::Kind::cylinder) box.add(Box3{top - extent, top + extent});
  return box;
}

Box3 bounds_of(const Scene& scene, const Shape& shape) {
  if (const Quadric* quadric = std::get_if<Quadric>(&shape.geometry)) return bounds_of(*quadric);
  Box3 box;
  for (const Vec3& p : scene.meshes[index(std::get<MeshId>(shape.geometry))].positions) box.add(p);
  return box;
}

Box3 bounds_of(const Scene& scene, const ShapeGroup& group) {
  Box3 box;
  for (const ShapeId shape : group.shapes) box.add(bounds_of(scene, scene.shapes[index(shape)]));
  return box;
}

std::uint64_t n_triangles_of(const Scene& scene, const Shape& shape) {
  const MeshId* mesh = std::get_if<MeshId>(&shape.geometry);
  return mesh ? scene.meshes[index(*mesh)].n_triangles() : 0;
}

}  // namespace

}  // namespace myrialux
