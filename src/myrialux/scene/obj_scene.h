// A Wavefront OBJ file with its materials as a whole scene.
#pragma once

#include <string>

#include "myrialux/scene/asset_jobs.h"
#include "myrialux/scene/scene.h"

namespace myrialux {

/// Shapes by material; a camera that frames them from a 3/4 view; a white sky unless a material emits.
/// @param text receives the text of the file and of its material files, for the scene's hash
void read_obj_scene(const std::string& path, Scene& scene, AssetJobs& assets, std::string& text, Diagnostics& found);

}  // namespace myrialux
