// Chooses the reader by the file's extension, loads what the scene names, and throws if there were mistakes.
#include "myrialux/scene/load.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "myrialux/scene/asset_jobs.h"
#include "myrialux/scene/mitsuba_scene.h"
#include "myrialux/scene/obj_scene.h"
#include "myrialux/scene/sha256.h"

namespace myrialux {

Scene load_scene(const std::string& path, const LoadOptions& options) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  Scene scene;
  scene.path = path;
  Diagnostics found;
  AssetJobs assets;
  std::string text;
  if (extension == ".xml")
    mitsuba::read_scene(path, options, scene, assets, text, found);
  else if (extension == ".obj")
    read_obj_scene(path, scene, assets, text, found);
  else
    found.error({path, 0, 0},
                "unknown kind of scene file \"" + extension + "\"; allowed: .xml (Mitsuba), .obj (Wavefront)");
  assets.load(scene, found);
  found.throw_if(options.strict ? Severity::warning : Severity::error);
  scene.sha256 = sha256(text + '\0' + assets.inventory());
  scene.diagnostics = found.all();
  return scene;
}

void require_renderable(const Scene& scene) {
  Diagnostics found;
  for (const Diagnostic& d : scene.diagnostics)
    if (d.severity == Severity::unsupported) found.add(d.at, d.severity, d.message);
  found.throw_if(Severity::unsupported);
}

}  // namespace myrialux
