// The subcommands of myrialux, and what they share with main().
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>

#include "reporter.h"

namespace myrialux::app {

struct Session {
  std::string command_line;  ///< as typed, quoted for a shell
  std::unique_ptr<Reporter> reporter = make_reporter("none");
  std::function<void()> run;  ///< the chosen subcommand; its arguments are read by then
};

// Each adds one subcommand with its options; `session` must outlive the app.
void add_render(CLI::App& app, Session& session);
void add_info(CLI::App& app, Session& session);
void add_check(CLI::App& app, Session& session);
void add_lights(CLI::App& app, Session& session);
void add_compare(CLI::App& app, Session& session);
void add_bench(CLI::App& app, Session& session);

}  // namespace myrialux::app
