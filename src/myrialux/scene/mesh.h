// Readers and makers of triangle meshes, and the steps every mesh goes through.
#pragma once

#include <cstdint>
#include <string>

#include "myrialux/base/error.h"
#include "myrialux/math/transform.h"
#include "myrialux/scene/scene.h"

namespace myrialux {

/// Files, in the space of the file. Mistakes (with line or byte) are reported; what comes back then is of no use.
Mesh read_ply(const std::string& path, Diagnostics& found);
Mesh read_obj(const std::string& path, Diagnostics& found);
Mesh read_serialized(const std::string& path, int shape_index, Diagnostics& found);

/// [-1, 1]^2 in z = 0, facing +z, uv = (x + 1) / 2.
Mesh rectangle_mesh();
/// [-1, 1]^3 with four vertices a side.
Mesh cube_mesh();

struct MeshFinish {
  Transform to_world;
  bool face_normals = false, flip_v = false, smooth = true;
};
/// Moves the mesh to the world, makes its normals, drops triangles without area. Returns how many were dropped.
/// Mirrors keep the side on which given normals stand: the winding follows them.
std::uint64_t finish_mesh(Mesh& mesh, const MeshFinish& how);

/// Vertex normals weighted by the angles of the triangles around. Source: [thuermer98]
void make_smooth_normals(Mesh& mesh);

/// First vertex that is not finite, or n_vertices.
std::size_t first_non_finite(const Mesh& mesh);

}  // namespace myrialux
