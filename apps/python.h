// Runs the project's Python package (python/myrialux), which makes pages and evaluates FLIP.
#pragma once

#include <string>
#include <vector>

namespace myrialux::app {

/// Runs `python -m MODULE ARGUMENTS` in `folder` and waits. Python is $MYRIALUX_PYTHON, else that of .venv beside
/// the package (tools/setup_python.sh), else python3; the package is looked for above the program, then in the source
/// folder it was built from, then among what this Python has installed.
/// @throws Error (output), "`purpose`: ...", naming the command that installs what is missing; (interrupted)
void run_python(const std::string& module, const std::vector<std::string>& arguments, const std::string& folder,
                const std::string& purpose);

}  // namespace myrialux::app
