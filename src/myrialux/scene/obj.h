// Wavefront OBJ files: geometry, cut by material where asked.
#pragma once

#include <string>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/scene/scene.h"

namespace myrialux {

/// The faces that share a material.
struct ObjPart {
  std::string material;  ///< "" before the first usemtl
  TextPosition at;       ///< of its first usemtl
  Mesh mesh;             ///< v upwards, as the file has it
};

struct ObjFile {
  std::vector<ObjPart> parts;
  std::vector<std::pair<std::string, TextPosition>> material_files;  ///< mtllib
};

/// @param by_material one part a material; else everything is one part
ObjFile read_obj_file(const std::string& path, bool by_material, Diagnostics& found);

}  // namespace myrialux
