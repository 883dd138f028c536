// Runs the program under test and gives back what it wrote and how it ended.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace myrialux::test {

struct Outcome {
  int exit_code = -1;  ///< 128 + signal if it was killed
  std::string out, err;
  std::uint64_t peak_bytes = 0;  ///< memory at its largest; never below what this process held when it forked
};

struct RunOptions {
  std::vector<std::string> environment = {};  ///< NAME=VALUE, added to ours
  bool terminal = false;                      ///< stderr is a terminal of 80 columns
  std::string signal_after = {};              ///< once stderr holds this text, SIGINT is sent
};

/// Runs MYRIALUX_BINARY with the words of `arguments`.
inline Outcome run_program(const std::vector<std::string>& arguments, const RunOptions& options = {}) {
  int out[2], err[2];
  if (pipe2(out, O_CLOEXEC) != 0) abort();
  if (options.terminal) {
    err[0] = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (err[0] < 0 || grantpt(err[0]) != 0 || unlockpt(err[0]) != 0) abort();
    err[1] = open(ptsname(err[0]), O_RDWR | O_NOCTTY | O_CLOEXEC);
  } else if (pipe2(err, O_CLOEXEC) != 0) {
    abort();
  }
  const pid_t child = fork();
  if (child == 0) {
    dup2(out[1], STDOUT_FILENO);
    dup2(err[1], STDERR_FILENO);
    for (const char* name : {"NO_COLOR", "CLICOLOR_FORCE", "MYRIALUX_THREADS"}) unsetenv(name);
    setenv("TERM", "xterm", 1);
    for (const std::string& e : options.environment) putenv(const_cast<char*>(e.c_str()));
    std::vector<char*> argv = {const_cast<char*>("myrialux")};
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    execv(MYRIALUX_BINARY, argv.data());
    _exit(127);
  }
  close(out[1]);
  close(err[1]);
  Outcome outcome;
  bool sent = options.signal_after.empty();
  pollfd ends[2] = {{out[0], POLLIN, 0}, {err[0], POLLIN, 0}};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    poll(ends, 2, -1);
    for (int k = 0; k < 2; ++k) {
      if (ends[k].fd < 0 || ends[k].revents == 0) continue;
      char buffer[4096];
      const ssize_t n = read(ends[k].fd, buffer, sizeof buffer);
      if (n > 0)
        (k == 0 ? outcome.out : outcome.err).append(buffer, static_cast<std::size_t>(n));
      else
        ends[k].fd = -1;  // a terminal whose other end closed reads as an error
    }
    if (!sent && outcome.err.find(options.signal_after) != std::string::npos) {
      kill(child, SIGINT);
      sent = true;
    }
  }
  close(out[0]);
  close(err[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  outcome.peak_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

/// Text of a small room: floor and back wall, a lamp above, one line an element (see LineOf tests).
inline std::string room_xml(const std::string& extra = "") {
  return R"(<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="4"/></integrator>
<sensor type="perspective"><float name="fov" value="60"/>
<transform name="to_world"><lookat origin="0,1,4" target="0,1,0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/></film></sensor>
<bsdf type="diffuse" id="grey"><rgb name="reflectance" value="0.5"/></bsdf>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/></transform><ref id="grey"/></shape>
<shape type="rectangle"><transform name="to_world"><scale value="2"/><translate z="-2"/></transform><ref id="grey"/></shape>
<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="90"/><scale value="0.5"/><translate y="2"/></transform>
<emitter type="area"><rgb name="radiance" value="5"/></emitter></shape>
)" + extra +
         "</scene>\n";
}

}  // namespace myrialux::test
