// What all subcommands take: a scene file, definitions for it, threads, progress, and where the camera stands.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "commands.h"
#include "myrialux/scene/load.h"

namespace myrialux::app {

struct SceneOptions {
  std::string path, progress = "auto", look_at;
  std::vector<std::string> definitions;  ///< KEY=VALUE
  int threads = 0;                       ///< 0: all available
  double fov_deg = 0;                    ///< 0: the scene's
  double aperture_radius = -1;           ///< negative: the scene's
  double focus_distance = 0;             ///< 0: the scene's
  bool strict = false;
};

void add_scene_arguments(CLI::App& command, SceneOptions& options);
void add_progress_argument(CLI::App& command, SceneOptions& options);
void add_camera_arguments(CLI::App& command, SceneOptions& options);
/// Only the last of repeated flags would count otherwise: they are refused, except those that make a list.
void add_list(CLI::App& command, const std::string& names, std::vector<std::string>& values, const std::string& shape,
              const std::string& help);

/// -D keys, sorted out: those of the renderer (parameter_table) and those of a Mitsuba scene.
struct Definitions {
  std::map<std::string, std::string> renderer, scene;
};
/// @throws Error (usage) for a key that neither can know, naming the nearest, and for bad values
Definitions sort_definitions(const SceneOptions& options);

/// Threads to use; at least 1.
int thread_count(const SceneOptions& options);

/// Loads the scene, tells its warnings and places the camera. The first stage told is "load".
Scene open_scene(const SceneOptions& options, const Definitions& definitions, Reporter& reporter);

/// The table of -D keys for --help.
std::string definition_help();

}  // namespace myrialux::app
