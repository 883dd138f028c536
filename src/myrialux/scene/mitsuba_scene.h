// Turns the tree of a Mitsuba file into a scene.
#pragma once

#include <string>

#include "myrialux/scene/asset_jobs.h"
#include "myrialux/scene/load.h"

namespace myrialux::mitsuba {

/// @param text receives the text of the file and of its includes, for the scene's hash
void read_scene(const std::string& path, const LoadOptions& options, Scene& scene, AssetJobs& assets, std::string& text,
                Diagnostics& found);

}  // namespace myrialux::mitsuba
