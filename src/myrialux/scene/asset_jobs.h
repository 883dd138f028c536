// Meshes and images that a scene names: queued while the scene is read, then loaded in parallel.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/scene/scene.h"

namespace myrialux {

struct MeshJob {
  enum class Format : std::uint8_t { obj, ply, serialized, ready };
  Format format = Format::ready;  ///< ready: positions etc. are in the scene already
  std::string path;
  TextPosition at;  ///< where the scene names it
  MeshId mesh = kNone<MeshId>;
  Transform to_world;
  bool face_normals = false;
  bool flip_v = false;  ///< v becomes 1 - v
  bool smooth = true;   ///< normals are made where the file has none
  int shape_index = 0;  ///< serialized: which mesh of the file
};

struct ImageJob {
  std::string path;
  TextPosition at;
  bool raw = false;  ///< values are linear as they stand
  float gamma = 0;   ///< > 0: exponent of the file's values instead of the sRGB curve
  std::shared_ptr<Image> image;
};

/// The queue; loading fills the scene in the order in which things were named.
class AssetJobs {
 public:
  void add(MeshJob job) { meshes_.push_back(std::move(job)); }
  /// One image a file and decoding, however often it is named.
  std::shared_ptr<const Image> add_image(const std::string& path, bool raw, float gamma, const TextPosition& at);
  /// Reads everything; mistakes are told in the order of naming. Counts Scene::dropped_triangles.
  void load(Scene& scene, Diagnostics& found);
  /// "name size" of each file, in the order of naming.
  std::string inventory() const;

 private:
  std::vector<MeshJob> meshes_;
  std::vector<ImageJob> images_;
  std::map<std::string, std::size_t> image_of_;
};

}  // namespace myrialux
