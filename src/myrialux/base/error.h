// Errors a user can mend: one exception type with a place and a remedy, and a collector that lists all mistakes at
// once.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace myrialux {

/// What kind of mistake it was; the values are the program's exit codes.
enum class ErrorKind : int { usage = 2, input = 3, limit = 4, output = 5, interrupted = 130 };

/// The only exception the library throws at users. `what()` is one complete message, "place: what is wrong; remedy".
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

/// A place in a text or binary file. Lines and columns count from 1; 0 means unknown.
struct TextPosition {
  std::string file;
  std::uint32_t line = 0, column = 0;
};

/// "file:line:column", without the parts that are unknown.
std::string to_string(const TextPosition& at);

enum class Severity : std::uint8_t {
  warning,      ///< the meaning is kept, or kept nearly; the render goes on
  unsupported,  ///< understood, but cannot be rendered yet; `info` and `check` go on, `render` stops
  error,        ///< a mistake in the input
};

struct Diagnostic {
  TextPosition at;
  Severity severity;
  std::string message;
};

std::string to_string(const Diagnostic& d);

/// Collects what is wrong with an input, so that one run tells all of it.
class Diagnostics {
 public:
  void error(const TextPosition& at, std::string message) { add(at, Severity::error, std::move(message)); }
  void warning(const TextPosition& at, std::string message) { add(at, Severity::warning, std::move(message)); }
  void unsupported(const TextPosition& at, std::string message) { add(at, Severity::unsupported, std::move(message)); }
  void add(const TextPosition& at, Severity severity, std::string message) {
    found_.push_back({at, severity, std::move(message)});
  }
  const std::vector<Diagnostic>& all() const { return found_; }
  bool has(Severity severity) const;
  /// Throws one Error (input) that lists everything found of at least this severity, one a line; else returns.
  void throw_if(Severity severity) const;

 private:
  std::vector<Diagnostic> found_;
};

}  // namespace myrialux
