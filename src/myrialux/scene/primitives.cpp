// Rectangle and cube as triangles, with Mitsuba's vertex order and texture coordinates.
#include "myrialux/scene/mesh.h"

namespace myrialux {

Mesh rectangle_mesh() {
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.indices = {0, 1, 2, 2, 3, 0};
  return mesh;
}

Mesh cube_mesh() {
  // One row a side: the first corner, then the edges to the second and to the fourth.
  struct Side {
    Vec3 corner, first, second;
  };
  const Side sides[6] = {{{1, -1, -1}, {0, 0, 2}, {-2, 0, 0}}, {{1, 1, -1}, {-2, 0, 0}, {0, 0, 2}},
                         {{1, -1, -1}, {0, 2, 0}, {0, 0, 2}},  {{1, -1, 1}, {0, 2, 0}, {-2, 0, 0}},
                         {{-1, -1, 1}, {0, 2, 0}, {0, 0, -2}}, {{1, 1, -1}, {0, -2, 0}, {-2, 0, 0}}};
  Mesh mesh;
  for (std::uint32_t s = 0; s < 6; ++s) {
    const auto [corner, first, second] = sides[s];
    mesh.positions.insert(mesh.positions.end(), {corner, corner + first, corner + first + second, corner + second});
    mesh.uvs.insert(mesh.uvs.end(), {{0, 1}, {1, 1}, {1, 0}, {0, 0}});
    const std::uint32_t v = 4 * s;
    mesh.indices.insert(mesh.indices.end(), {v, v + 1, v + 2, v + 3, v, v + 2});
  }
  return mesh;
}

}  // namespace myrialux
