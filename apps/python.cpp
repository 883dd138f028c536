// Finds Python and the project's package, runs a module of it, and explains failures.
#include "python.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "myrialux/base/cancel.h"
#include "myrialux/base/error.h"

namespace myrialux::app {
namespace {

namespace fs = std::filesystem;

constexpr int kMissingPackages = 69;  // sysexits.h: a support program is unavailable; they are named on stdout

struct Python {
  std::string program;
  fs::path root;           ///< folder with python/myrialux; empty: not found
  bool is_chosen = false;  ///< by MYRIALUX_PYTHON
};

/// The folder that holds python/myrialux.
fs::path find_root() {
  std::error_code none;
  const auto has_package = [&](const fs::path& folder) {
    return fs::exists(folder / "python" / "myrialux" / "__init__.py", none);
  };
  fs::path folder = fs::read_symlink("/proc/self/exe", none).parent_path();
  for (int level = 0; level < 4 && !folder.empty(); ++level, folder = folder.parent_path())
    if (has_package(folder)) return folder;
  return has_package(MYRIALUX_SOURCE_DIR) ? fs::path(MYRIALUX_SOURCE_DIR) : fs::path();
}

Python find_python() {
  Python python{.program = "python3", .root = find_root()};
  const char* chosen = std::getenv("MYRIALUX_PYTHON");
  const fs::path own = python.root / ".venv" / "bin" / "python";
  if (chosen && *chosen)
    python.program = chosen, python.is_chosen = true;
  else if (!python.root.empty() && access(own.c_str(), X_OK) == 0)
    python.program = own.string();
  return python;
}

/// The command that installs what a page needs.
std::string remedy(const Python& python) {
  if (python.root.empty()) return fmt::format("{} -m pip install flip-evaluator numpy pillow plotly", python.program);
  if (python.is_chosen)
    return fmt::format("{} -m pip install -r {}", python.program, (python.root / "python/requirements.txt").string());
  return (python.root / "tools/setup_python.sh").string();
}

/// Our environment with the package's folder first in PYTHONPATH.
std::vector<std::string> environment_for(const Python& python) {
  const std::string name = "PYTHONPATH=";
  std::string path = (python.root / "python").string();
  std::vector<std::string> all;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    if (!text.starts_with(name) || python.root.empty())
      all.push_back(text);
    else if (text.size() > name.size())
      path += ":" + text.substr(name.size());
  }
  if (!python.root.empty()) all.push_back(name + path);
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  all.reserve(texts.size() + 1);
  for (std::string& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

/// Exit code of a child; 128 + signal if it was killed. A request to stop ends it.
int wait_for(pid_t child) {
  int status = 0;
  bool was_told = false;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (cancel_requested() && !was_told) was_told = kill(child, SIGTERM) == 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

void run_python(const std::string& module, const std::vector<std::string>& arguments, const std::string& folder,
                const std::string& purpose) {
  const Python python = find_python();
  std::vector<std::string> words = {python.program, "-m", module};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<std::string> environment = environment_for(python);
  const std::string out = folder + "/stdout.txt", err = folder + "/stderr.txt";

  // In `folder`, since Python would take modules from where the user happens to stand.
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t child = 0;
  const int failed = posix_spawnp(&child, python.program.c_str(), &actions, nullptr, pointers(words).data(),
                                  pointers(environment).data());
  posix_spawn_file_actions_destroy(&actions);
  const auto fail = [&](const std::string& reason) {
    throw Error(ErrorKind::output, fmt::format("{}: {}", purpose, reason));
  };
  if (failed != 0)
    fail(fmt::format("Python cannot be started: {}: {}; {}", python.program, std::strerror(failed),
                     python.is_chosen ? "MYRIALUX_PYTHON names it" : "install python3, then run " + remedy(python)));
  const int exit_code = wait_for(child);
  throw_if_cancelled();
  const std::string complaint = read_text(err);
  if (exit_code == kMissingPackages)
    fail(
        fmt::format("{} lacks the packages {}; install them with: {}", python.program, read_text(out), remedy(python)));
  if (exit_code != 0 && python.root.empty() && complaint.find("No module named") != std::string::npos)
    fail(fmt::format("{} does not know the package myrialux; set PYTHONPATH to the project's folder python",
                     python.program));
  if (exit_code != 0)
    fail(fmt::format("{} -m {} ended with code {}:\n{}", python.program, module, exit_code, complaint));
}

}  // namespace myrialux::app
