// Makes small Mitsuba scenes for tests.
#pragma once

#include <string>

#include "myrialux/base/error.h"
#include "myrialux/scene/load.h"
#include "support/temporary_folder.h"

namespace myrialux::test {

inline const char* const kCamera = "<sensor type=\"perspective\"/>";
inline const char* const kLight = "<emitter type=\"constant\"/>";

/// `body` in a scene with camera and light.
inline std::string scene_with(const std::string& body, const std::string& version = "3.0.0") {
  return "<scene version=\"" + version + "\">" + kCamera + kLight + body + "</scene>";
}

/// Loads `text` as scene.xml of a folder.
inline Scene load_text(const TemporaryFolder& folder, const std::string& text, const LoadOptions& options = {}) {
  return load_scene(folder.write("scene.xml", text), options);
}

/// Loads camera, light and `body`.
inline Scene load_body(const std::string& body, const std::string& version = "3.0.0") {
  const TemporaryFolder folder;
  return load_text(folder, scene_with(body, version));
}

/// What the loader says, with the folder's path taken out; "" if it accepts.
inline std::string complaint(const TemporaryFolder& folder, const std::string& path, const LoadOptions& options = {}) {
  std::string message;
  try {
    load_scene(path, options);
  } catch (const Error& error) {
    message = error.kind() == ErrorKind::input ? error.what() : "wrong kind of error";
  }
  const std::string prefix = folder.path().string() + "/";
  for (std::size_t at; (at = message.find(prefix)) != std::string::npos;) message.erase(at, prefix.size());
  return message;
}

}  // namespace myrialux::test
