// myrialux lights: traces the virtual lights of a scene and stores them for other runs and programs.
#include <fmt/format.h>

#include <filesystem>
#include <limits>

#include "commands.h"
#include "myrialux/base/output_file.h"
#include "myrialux/base/parallel.h"
#include "myrialux/lights/virtual_lights.h"
#include "myrialux/pipeline/parameters.h"
#include "scene_options.h"
#include "values.h"
#include "words.h"

namespace myrialux::app {
namespace {

struct LightsOptions {
  SceneOptions scene;
  std::string output;
  std::uint64_t n_lights = RenderParams{}.n_lights, seed = 0;
  int max_depth = 0;
  bool ascii = false;
};

void run(const LightsOptions& o, Session& session) {
  session.reporter = make_reporter(o.scene.progress);
  Reporter& reporter = *session.reporter;
  const Definitions definitions = sort_definitions(o.scene);
  if (std::filesystem::path(o.output).extension() != ".ply")
    throw Error(ErrorKind::usage, o.output + ": virtual lights are written as .ply");
  require_writable(o.output);
  TunedParams tuned;
  apply_extra(definitions.renderer, tuned);

  const ThreadScope threads(thread_count(o.scene));
  const Scene scene = open_scene(o.scene, definitions, reporter);
  require_renderable(scene);
  reporter.stage("build", 0, "");
  const Tracer tracer(scene);
  const Emitters emitters(scene, tracer.bounds());
  const World world{.scene = scene,
                    .tracer = tracer,
                    .emitters = emitters,
                    .max_depth = o.max_depth != 0 ? o.max_depth : scene.max_depth,
                    .rr_depth = scene.rr_depth,
                    .sharp_alpha = tuned.sharp_alpha};
  const LightResult result =
      trace_lights(world, {.n_lights = o.n_lights, .direct = true, .key = {o.seed, 0}}, reporter);
  throw_if_cancelled();

  OutputFile file(o.output);
  write_lights(result.lights, scene, file.temporary(), !o.ascii);
  file.commit();
  reporter.done({fmt::format("{} virtual lights of {} walks, {} rays", result.lights.size(), result.n_walks,
                             count_words(static_cast<double>(result.light_rays)))},
                {absolute_path(o.output)});
}

}  // namespace

void add_lights(CLI::App& app, Session& session) {
  CLI::App& command = *app.add_subcommand("lights", "Trace the virtual lights of a scene and store them");
  auto o = std::make_shared<LightsOptions>();
  add_scene_arguments(command, o->scene);
  command.add_option("-o,--output", o->output, "Point cloud to write, .ply")->required()->option_text("FILE");
  command.add_option("--vpls", o->n_lights, fmt::format("How many; default {}", o->n_lights))
      ->check(whole_number(1, std::int64_t{1} << 31))
      ->option_text("N");
  command.add_option("--max-depth", o->max_depth, "Edges of a path; -1 no limit. Default: the scene's")
      ->check(whole_number(-1, 1 << 20))
      ->option_text("N");
  command.add_option("--seed", o->seed, "Default 0")
      ->check(whole_number(0, std::numeric_limits<std::int64_t>::max()))
      ->option_text("N");
  command.add_flag("--ascii", o->ascii, "Write text instead of binary");
  add_progress_argument(command, o->scene);
  command.footer([] {
    return R"(Examples:
  myrialux lights room.xml -o lights.ply --vpls 50000
  myrialux render room.xml --lights lights.ply -o room.exr

The file is a PLY point cloud that any mesh viewer shows: x y z, nx ny nz (emission normal), r g b (radiant
intensity along it, W/sr). Lights on the lamps themselves are included; render leaves them out where it samples
direct light.

)" + definition_help();
  });
  command.callback([o, &session] { session.run = [o, &session] { run(*o, session); }; });
}

}  // namespace myrialux::app
