// A folder for files between this program and the Python package.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/base/output_file.h"
#include "myrialux/math/vec.h"

namespace myrialux::app {

/// Gone with the object.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::error_code none;
    std::string name = (std::filesystem::temp_directory_path(none) / "myrialux-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      throw Error(ErrorKind::output, name + ": no folder for temporary files can be made; set TMPDIR to another place");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code none;
    std::filesystem::remove_all(path_, none);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Pixels as float32 [n, 3]; gives back `name`.
inline std::string write_pixels(const ScratchFolder& folder, const std::string& name, const std::vector<Rgb>& pixels) {
  static_assert(sizeof(Rgb) == 3 * sizeof(float));
  write_file(folder.file(name), {reinterpret_cast<const char*>(pixels.data()), pixels.size() * sizeof(Rgb)});
  return name;
}

}  // namespace myrialux::app
