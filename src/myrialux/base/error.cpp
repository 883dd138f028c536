// Text of error messages and the collector that lists them.
#include "myrialux/base/error.h"

#include <algorithm>

namespace myrialux {

std::string to_string(const TextPosition& at) {
  std::string s = at.file;
  if (at.line > 0) s += ":" + std::to_string(at.line);
  if (at.line > 0 && at.column > 0) s += ":" + std::to_string(at.column);
  return s;
}

std::string to_string(const Diagnostic& d) {
  const std::string place = to_string(d.at);
  const std::string lead = place.empty() ? "" : place + ": ";
  if (d.severity == Severity::warning) return lead + "warning: " + d.message;
  return lead + d.message;
}

bool Diagnostics::has(Severity severity) const {
  return std::any_of(found_.begin(), found_.end(), [&](const Diagnostic& d) { return d.severity == severity; });
}

void Diagnostics::throw_if(Severity severity) const {
  std::string message;
  for (const Diagnostic& d : found_)
    if (d.severity >= severity) message += (message.empty() ? "" : "\n") + to_string(d);
  if (!message.empty()) throw Error(ErrorKind::input, message);
}

}  // namespace myrialux
