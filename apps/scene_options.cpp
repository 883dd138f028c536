#include "scene_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "myrialux/base/parallel.h"
#include "myrialux/base/suggest.h"
#include "myrialux/math/transform.h"
#include "myrialux/pipeline/parameters.h"
#include "values.h"

namespace myrialux::app {
namespace {

bool is_mitsuba(const std::string& path) { return std::filesystem::path(path).extension() == ".xml"; }

/// "bamc" of "bamc.alpha".
std::string prefix(const std::string& key) { return key.substr(0, key.find('.')); }

/// Where --look-at puts the camera, if given.
std::optional<Transform> camera_placement(const SceneOptions& options) {
  if (options.look_at.empty()) return {};
  const std::vector<float> v =
      parse_floats("--look-at", options.look_at, {6, 9},
                   "six or nine numbers: where the camera stands, what it looks at, which way is up (0,1,0 if left "
                   "out), for example 0,1,5,0,1,0");
  const Vec3 origin{v[0], v[1], v[2]}, target{v[3], v[4], v[5]};
  const Vec3 up = v.size() == 9 ? Vec3{v[6], v[7], v[8]} : Vec3{0, 1, 0};
  const float distance = length(target - origin);
  if (!(distance > 0))
    throw Error(ErrorKind::usage, "--look-at " + options.look_at + ": the camera stands on the point it looks at");
  if (!(length(cross(up, target - origin)) > 1e-6f * distance * length(up)))
    throw Error(ErrorKind::usage, "--look-at " + options.look_at +
                                      ": up is parallel to the view or zero; give another direction as the last three "
                                      "numbers, for example 0,0,1");
  return Transform::look_at(origin, target, up);
}

/// @throws Error (usage) where one of --aperture and --focus-distance needs the other
void set_lens(const SceneOptions& options, Camera& camera) {
  if (options.aperture_radius >= 0) camera.aperture_radius = static_cast<float>(options.aperture_radius);
  if (options.focus_distance > 0) camera.focus_distance = static_cast<float>(options.focus_distance);
  const bool has_lens = camera.aperture_radius > 0;
  if (has_lens && !(camera.focus_distance > 0))
    throw Error(ErrorKind::usage, fmt::format("--aperture {}: the scene does not say which distance is sharp; add "
                                              "--focus-distance LENGTH",
                                              options.aperture_radius));
  if (!has_lens && options.focus_distance > 0)
    throw Error(ErrorKind::usage, fmt::format("--focus-distance {}: a pinhole shows all distances sharp; add "
                                              "--aperture RADIUS",
                                              options.focus_distance));
}

}  // namespace

void add_list(CLI::App& command, const std::string& names, std::vector<std::string>& values, const std::string& shape,
              const std::string& help) {
  command.add_option(names, values, help)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->option_text(shape);
}

void add_scene_arguments(CLI::App& command, SceneOptions& options) {
  command.add_option("SCENE", options.path, "Scene file: Mitsuba .xml (0.5 to 3) or Wavefront .obj")
      ->required()
      ->option_text(" ");
  add_list(command, "-D,--define", options.definitions, "KEY=VALUE",
           "Set a $KEY of a Mitsuba scene, or a key of\nthe renderer (listed below); may be repeated");
  command.add_flag("--strict", options.strict, "Treat warnings about the scene as errors");
  command
      .add_option("--threads", options.threads,
                  "Threads; 0 = all this process may use.\nDefault: $MYRIALUX_THREADS, else 0")
      ->envname("MYRIALUX_THREADS")
      ->check(whole_number(0, 4096))
      ->option_text("N");
}

void add_progress_argument(CLI::App& command, SceneOptions& options) {
  command
      .add_option("--progress", options.progress,
                  "auto, bar, plain, json (one object a line)\nor none; all on stderr. Default: auto, a bar\non a "
                  "terminal, else plain lines")
      ->check(one_of({"auto", "bar", "plain", "json", "none"}))
      ->option_text("KIND");
}

void add_camera_arguments(CLI::App& command, SceneOptions& options) {
  command
      .add_option("--look-at", options.look_at,
                  "Place the camera: ox,oy,oz,tx,ty,tz[,ux,uy,uz],\nstanding at o, looking at t, with u upwards\n"
                  "(default 0,1,0); scene units")
      ->option_text("NUMBERS");
  command.add_option("--fov", options.fov_deg, "Full horizontal angle of view, degrees")
      ->check(number(0.01, 179.9, "degrees"))
      ->option_text("DEG");
  command
      .add_option("--aperture", options.aperture_radius,
                  "Radius of the lens, scene units: what is not at\n--focus-distance blurs; 0 = pinhole")
      ->check(number(0, 1e30, "scene units"))
      ->option_text("RADIUS");
  command
      .add_option("--focus-distance", options.focus_distance,
                  "From the lens to the plane that is sharp, along\nthe view; scene units")
      ->check(number(1e-6, 1e30, "scene units"))
      ->option_text("LENGTH");
}

Definitions sort_definitions(const SceneOptions& options) {
  std::vector<std::string> known, families;
  for (const ParameterInfo& p : parameter_table()) {
    known.push_back(p.key);
    if (p.key.find('.') != std::string::npos) families.push_back(prefix(p.key));
  }
  const auto holds = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  Definitions sorted;
  for (const std::string& text : options.definitions) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw Error(ErrorKind::usage, fmt::format("-D {}: allowed is KEY=VALUE, for example -D bamc.alpha=0.05", text));
    const std::string key = text.substr(0, equals), value = text.substr(equals + 1);
    if (holds(known, key))
      sorted.renderer[key] = value;
    else if (is_mitsuba(options.path) && !(key.find('.') != std::string::npos && holds(families, prefix(key))))
      sorted.scene[key] = value;
    else
      throw Error(ErrorKind::usage, fmt::format("-D {}: no such key{}{}", key, did_you_mean(key, known),
                                                is_mitsuba(options.path) ? "" : "; only Mitsuba scenes have own keys"));
  }
  TunedParams checked;
  apply_extra(sorted.renderer, checked);
  return sorted;
}

int thread_count(const SceneOptions& options) { return options.threads > 0 ? options.threads : available_threads(); }

Scene open_scene(const SceneOptions& options, const Definitions& definitions, Reporter& reporter) {
  const std::optional<Transform> placement = camera_placement(options);
  reporter.stage("load", 0, "");
  Scene scene = load_scene(options.path, {.defines = definitions.scene, .strict = options.strict});
  reporter.end_stage();
  // What cannot be rendered stops the command next, with one error that lists it all.
  std::vector<Diagnostic> warnings;
  for (const Diagnostic& d : scene.diagnostics)
    if (d.severity == Severity::warning) warnings.push_back(d);
  reporter.warn(warnings);
  if (placement) scene.camera.to_world = *placement, scene.camera.motion.clear();
  set_lens(options, scene.camera);
  if (options.fov_deg > 0) scene.camera.fov_x_deg = static_cast<float>(options.fov_deg);
  return scene;
}

std::string definition_help() {
  std::string text = "Keys for -D (value = default):\n";
  for (const ParameterInfo& p : parameter_table())
    text += fmt::format("  {:<28} {}\n", p.key + "=" + p.value, p.meaning);
  return text;
}

}  // namespace myrialux::app
