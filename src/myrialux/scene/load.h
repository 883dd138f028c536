// Reads a scene file; which reader serves is told by the extension (.xml Mitsuba, .obj Wavefront).
#pragma once

#include <map>
#include <string>

#include "myrialux/scene/scene.h"

namespace myrialux {

struct LoadOptions {
  std::map<std::string, std::string> defines;  ///< Mitsuba's -Dkey=value: overrides <default name value>
  bool strict = false;                         ///< warnings count as errors
};

/// Reads and checks `path`, with everything it names. Relative names are looked up beside the file that names them.
/// @throws Error (input) listing every mistake as "file:line:column: what is wrong; what is allowed"
///         warnings and "cannot be rendered yet" are kept in Scene::diagnostics.
Scene load_scene(const std::string& path, const LoadOptions& options = {});

/// Throws Error (input) when the scene holds something that rendering would get wrong (Severity::unsupported).
void require_renderable(const Scene& scene);

}  // namespace myrialux
