// Where tests find the shared scenes: environment MYRIALUX_SCENES, else ../shared/scenes beside the source folder.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace myrialux::test {

/// Folder of the shared scenes; empty when absent.
inline std::string scenes_folder() {
  const char* set = std::getenv("MYRIALUX_SCENES");
  const std::filesystem::path folder = set && *set
                                           ? std::filesystem::path(set)
                                           : std::filesystem::path(MYRIALUX_SOURCE_DIR) / ".." / "shared" / "scenes";
  std::error_code code;
  return std::filesystem::is_directory(folder, code) ? folder.lexically_normal().string() : std::string();
}

/// Folder with the packed scenes unpacked (environment MYRIALUX_SCENES_UNPACKED); empty when not given.
inline std::string unpacked_scenes_folder() {
  const char* set = std::getenv("MYRIALUX_SCENES_UNPACKED");
  std::error_code code;
  return set && std::filesystem::is_directory(set, code) ? std::string(set) : std::string();
}

}  // namespace myrialux::test

/// First line of a test that needs shared scenes: skips it, saying what is missing.
#define MYRIALUX_REQUIRE_SCENES()                                                                          \
  if (myrialux::test::scenes_folder().empty())                                                             \
  GTEST_SKIP() << "the shared scenes are missing: set MYRIALUX_SCENES to their folder (with cornell-box/ " \
                  "and others)"
