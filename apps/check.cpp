// myrialux check: reads a scene and tells everything that is wrong with it.
#include <fmt/format.h>

#include <algorithm>

#include "commands.h"
#include "myrialux/base/parallel.h"
#include "scene_options.h"

namespace myrialux::app {
namespace {

void run(const SceneOptions& options, Session&) {
  const Definitions definitions = sort_definitions(options);
  const ThreadScope threads(thread_count(options));
  const Scene scene = load_scene(options.path, {.defines = definitions.scene, .strict = options.strict});
  const auto count = [&](Severity s) {
    return std::count_if(scene.diagnostics.begin(), scene.diagnostics.end(),
                         [&](const Diagnostic& d) { return d.severity == s; });
  };
  for (const Diagnostic& d : scene.diagnostics)
    fmt::print("{}{}\n", to_string(d), d.severity == Severity::unsupported ? " (render will stop here)" : "");
  fmt::print("{}: no errors, {} warnings, {} things that cannot be rendered\n", options.path, count(Severity::warning),
             count(Severity::unsupported));
}

}  // namespace

void add_check(CLI::App& app, Session& session) {
  CLI::App& command = *app.add_subcommand("check", "Read a scene and tell all that is wrong with it");
  auto options = std::make_shared<SceneOptions>();
  add_scene_arguments(command, *options);
  command.footer(R"(Examples:
  myrialux check room.xml
  myrialux check room.xml --strict      warnings count as mistakes

Lists every mistake as file:line:column: what is wrong; what is allowed. Exit code 0: can be read; 3: cannot.)");
  command.callback([options, &session] { session.run = [options, &session] { run(*options, session); }; });
}

}  // namespace myrialux::app
