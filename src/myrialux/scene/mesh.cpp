// Moves meshes to the world, makes their normals and drops triangles without area.
#include "myrialux/scene/mesh.h"

#include <array>
#include <cmath>

namespace myrialux {

namespace {

struct Double3 {
  double x = 0, y = 0, z = 0;
};
Double3 difference(Vec3 a, Vec3 b) { return {double(a.x) - b.x, double(a.y) - b.y, double(a.z) - b.z}; }
Double3 cross(Double3 a, Double3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
double dot(Double3 a, Double3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(Double3 a) { return std::sqrt(dot(a, a)); }

std::uint64_t drop_flat_triangles(Mesh& mesh);
void transform_normals(Mesh& mesh, const Transform& to_world);
std::vector<Double3> angle_weighted_normals(const Mesh& mesh);

}  // namespace

std::uint64_t finish_mesh(Mesh& mesh, const MeshFinish& how) {
  if (how.face_normals) mesh.normals.clear();
  if (how.flip_v)
    for (Vec2& uv : mesh.uvs) uv.y = 1 - uv.y;
  if (!(how.to_world == Transform())) {
    const bool had_normals = !mesh.normals.empty() || !how.smooth;
    for (Vec3& p : mesh.positions) p = how.to_world.point(p);
    if (had_normals && !how.face_normals && how.to_world.determinant3() < 0)
      for (std::size_t t = 0; t < mesh.n_triangles(); ++t) std::swap(mesh.indices[3 * t + 1], mesh.indices[3 * t + 2]);
  }
  const std::uint64_t n_dropped = drop_flat_triangles(mesh);
  if (!mesh.normals.empty())
    transform_normals(mesh, how.to_world);
  else if (how.smooth && !how.face_normals)
    make_smooth_normals(mesh);
  return n_dropped;
}

void make_smooth_normals(Mesh& mesh) {
  const std::vector<Double3> sums = angle_weighted_normals(mesh);
  mesh.normals.resize(mesh.positions.size());
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const double norm = length(sums[v]);
    mesh.normals[v] = norm > 0 ? Vec3{static_cast<float>(sums[v].x / norm), static_cast<float>(sums[v].y / norm),
                                      static_cast<float>(sums[v].z / norm)}
                               : Vec3{0, 0, 1};  // no triangle there
  }
}

std::size_t first_non_finite(const Mesh& mesh) {
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (!is_finite(mesh.positions[v])) return v;
  return mesh.positions.size();
}

namespace {

std::uint64_t drop_flat_triangles(Mesh& mesh) {
  std::size_t kept = 0;
  const std::size_t n = mesh.n_triangles();
  for (std::size_t t = 0; t < n; ++t) {
    const std::array<std::uint32_t, 3> corner{mesh.indices[3 * t], mesh.indices[3 * t + 1], mesh.indices[3 * t + 2]};
    const Vec3 a = mesh.positions[corner[0]], b = mesh.positions[corner[1]], c = mesh.positions[corner[2]];
    const bool has_area = length(cross(difference(b, a), difference(c, a))) > 0;
    if (!has_area) continue;
    for (std::size_t k = 0; k < 3; ++k) mesh.indices[3 * kept + k] = corner[k];
    ++kept;
  }
  mesh.indices.resize(3 * kept);
  return n - kept;
}

/// To the world and to unit length; normals that are 0 or not finite are made from the triangles around.
void transform_normals(Mesh& mesh, const Transform& to_world) {
  const bool moves = !(to_world == Transform());
  const Transform map = moves ? to_world.normal_transform() : to_world;
  std::vector<Double3> made;
  for (std::size_t v = 0; v < mesh.normals.size(); ++v) {
    const Vec3 n = mesh.normals[v];
    const double norm = length(Double3{n.x, n.y, n.z});
    if (norm > 0 && std::isfinite(norm)) {
      const Vec3 unit{static_cast<float>(n.x / norm), static_cast<float>(n.y / norm), static_cast<float>(n.z / norm)};
      const Vec3 moved = moves ? map.vector(unit) : unit;
      const double moved_norm = length(Double3{moved.x, moved.y, moved.z});
      mesh.normals[v] = {static_cast<float>(moved.x / moved_norm), static_cast<float>(moved.y / moved_norm),
                         static_cast<float>(moved.z / moved_norm)};
      continue;
    }
    if (made.empty()) made = angle_weighted_normals(mesh);
    const double made_norm = length(made[v]);
    mesh.normals[v] = made_norm > 0
                          ? Vec3{static_cast<float>(made[v].x / made_norm), static_cast<float>(made[v].y / made_norm),
                                 static_cast<float>(made[v].z / made_norm)}
                          : Vec3{0, 0, 1};
  }
}

std::vector<Double3> angle_weighted_normals(const Mesh& mesh) {
  std::vector<Double3> sums(mesh.positions.size());
  for (std::size_t t = 0; t < mesh.n_triangles(); ++t) {
    const std::uint32_t* corner = &mesh.indices[3 * t];
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = mesh.positions[corner[k]];
      const Double3 e0 = difference(mesh.positions[corner[(k + 1) % 3]], p);
      const Double3 e1 = difference(mesh.positions[corner[(k + 2) % 3]], p);
      const Double3 n = cross(e0, e1);
      const double norm = length(n);
      if (!(norm > 0)) continue;
      const double weight = std::atan2(norm, dot(e0, e1)) / norm;
      Double3& sum = sums[corner[k]];
      sum.x += n.x * weight, sum.y += n.y * weight, sum.z += n.z * weight;
    }
  }
  return sums;
}

}  // namespace

}  // namespace myrialux
