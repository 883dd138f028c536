// The myrialux program: picks the subcommand, turns errors into messages and exit codes.
#include <fmt/format.h>
#include <malloc.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <new>

#include "commands.h"
#include "myrialux/base/cancel.h"
#include "myrialux/base/suggest.h"
#include "myrialux/kernels/isa.h"

namespace myrialux::app {
namespace {

constexpr int kInternalError = 70;  // sysexits.h: a defect of the program

/// First signal: stop soon and tidy up. Second: stop at once.
void on_signal(int) {
  if (cancel_requested()) _exit(static_cast<int>(ErrorKind::interrupted));
  request_cancel();
}

void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

/// The command as one may paste it into a shell.
std::string quote(int argc, char** argv) {
  std::string line = "myrialux";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool is_plain = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
      return std::isalnum(c) || std::string_view("-_./=,:+%@").find(static_cast<char>(c)) != std::string_view::npos;
    });
    std::string quoted = "'";
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += " " + (is_plain ? word : quoted + "'");
  }
  return line;
}

std::vector<std::string> flags_of(const CLI::App& app) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
    for (const std::string& name : option->get_snames()) flags.push_back("-" + name);
  }
  return flags;
}

/// What was wrong with the command line, in our words.
std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  const auto chosen = app.get_subcommands();
  const CLI::App& command = chosen.empty() ? app : *chosen.front();
  const std::string help = fmt::format("\nrun '{} --help' for what it takes",
                                       chosen.empty() ? "myrialux" : "myrialux " + command.get_name());
  std::vector<std::string> subcommands;
  for (const CLI::App* sub : app.get_subcommands({})) subcommands.push_back(sub->get_name());
  for (const std::string& word : app.remaining(true)) {
    if (word.starts_with('-') && word.size() > 1) {
      const std::string flag = word.substr(0, word.find('='));
      return fmt::format("unknown option {}{}{}", flag, did_you_mean(flag, flags_of(command)), help);
    }
    if (chosen.empty())
      return fmt::format("unknown command {}{} (commands: {}){}", word, did_you_mean(word, subcommands),
                         fmt::join(subcommands, ", "), help);
    return fmt::format("one argument too many: {}{}", word, help);
  }
  return error.what() + help;
}

int fail(Session& session, const std::string& message, int exit_code) {
  session.reporter->fail(message, exit_code);
  return exit_code;
}

int run(int argc, char** argv) {
  Session session{.command_line = quote(argc, argv), .run = {}};
  CLI::App app("Myrialux: global illumination by many virtual lights", "myrialux");
  app.set_version_flag("--version", std::string("myrialux ") + MYRIALUX_VERSION + " (" + isa_name() + ")");
  app.set_help_flag("-h,--help", "Print this help");
  app.get_formatter()->column_width(26);
  add_render(app, session);
  add_info(app, session);
  add_check(app, session);
  add_lights(app, session);
  add_compare(app, session);
  add_bench(app, session);
  // Set last: subcommands would inherit it.
  app.footer(R"(Examples:
  myrialux render room.xml -o room.exr -o room.png
  myrialux info room.xml
  myrialux compare truth.exr room.exr
  myrialux render --help

Results go to files or stdout, everything else to stderr. NO_COLOR and MYRIALUX_THREADS are respected.)");
  app.require_subcommand(0, 1);

  constexpr int kUsage = static_cast<int>(ErrorKind::usage);
  try {
    app.parse(argc, argv);
    if (!session.run) {
      fmt::print(stderr, "{}", app.help());
      return kUsage;
    }
    install_signal_handlers();
    session.run();
    return 0;
  } catch (const CLI::Success& asked) {
    return app.exit(asked);  // --help, --version
  } catch (const CLI::ParseError& error) {
    return fail(session, explain(app, error), kUsage);
  } catch (const Error& error) {
    return fail(session, error.kind() == ErrorKind::interrupted ? "interrupted; nothing was written" : error.what(),
                static_cast<int>(error.kind()));
  } catch (const std::bad_alloc&) {
    return fail(session,
                "out of memory; render fewer samples at once (--spp with --passes), fewer lights (--vpls) or a "
                "smaller picture (--size)",
                static_cast<int>(ErrorKind::limit));
  } catch (const std::exception& error) {
    return fail(session,
                fmt::format("defect in myrialux: {}; please report it with this command: {}", error.what(),
                            session.command_line),
                kInternalError);
  }
}

}  // namespace
}  // namespace myrialux::app

int main(int argc, char** argv) {
  // Large arrays go back to the system as soon as they are freed, whatever was freed before: memory can be foretold.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  // But what a slice needs stays for the next one.
  mallopt(M_TRIM_THRESHOLD, 4 << 20);
  return myrialux::app::run(argc, argv);
}
