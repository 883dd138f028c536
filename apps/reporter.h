// Tells people or programs on stderr how far the work is: a bar, plain lines, JSON lines, or only warnings and errors.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "myrialux/base/clock.h"
#include "myrialux/base/error.h"
#include "myrialux/base/progress.h"

namespace myrialux::app {

/// One stage as it stands now.
struct StageState {
  std::string name, unit;
  std::uint64_t done = 0, total = 0;  ///< total 0: unknown
  double elapsed_s = 0;
  bool repeated = false;  ///< a stage of this name has ended before (in an earlier pass)

  int percent() const;          ///< rounded down: 100 only when all is done
  double rate() const;          ///< items a second
  double seconds_left() const;  ///< at the mean rate so far; below 0: unknown
};

/// Keeps count; what is shown and how is up to the kinds below.
class Reporter : public Progress {
 public:
  void stage(const std::string& name, std::uint64_t n_items, const std::string& unit) final;
  void advance(std::uint64_t n_items) final;
  void note(const std::string& line) final;

  /// Ends the stage that runs. `is_whole`: it came to its end.
  void end_stage(bool is_whole = true);
  /// Warnings, once each: equal text at other places is counted behind the first.
  void warn(const std::vector<Diagnostic>& diagnostics);
  /// The same for lines made by to_string(Diagnostic); those told already are left out.
  void warn(const std::vector<std::string>& lines);
  void fail(const std::string& message, int exit_code);
  /// Last words: numbers worth reading, then the absolute path of every file written.
  void done(const std::vector<std::string>& lines, const std::vector<std::string>& outputs);

 protected:
  explicit Reporter(double interval_s) : interval_s_(interval_s) {}
  virtual void show_begin(const StageState&) {}
  virtual void show_state(const StageState&) {}  ///< at most every interval_s
  virtual void show_end(const StageState&, bool is_whole) { (void)is_whole; }
  virtual void show_note(const std::string&) {}
  virtual void show_warning(const std::string& text);
  virtual void show_failure(const std::string& text, int exit_code);
  virtual void show_done(const std::vector<std::string>&, const std::vector<std::string>&) {}

 private:
  StageState state() const;

  const double interval_s_;
  std::mutex mutex_;  ///< held while something is shown
  std::string name_, unit_;
  std::uint64_t total_ = 0;
  std::atomic<std::uint64_t> done_{0};
  std::atomic<double> next_s_{0};  ///< of clock_: when to show again
  bool is_running_ = false;
  Stopwatch clock_;
  std::set<std::string> ended_, warned_;
};

/// @param kind auto, bar, plain, json or none; auto: a bar on a terminal, else plain lines
std::unique_ptr<Reporter> make_reporter(const std::string& kind);

/// The kinds make_reporter chooses from.
std::unique_ptr<Reporter> make_bar_reporter();
std::unique_ptr<Reporter> make_plain_reporter();
std::unique_ptr<Reporter> make_json_reporter();

/// Escape codes around `text` if stderr takes colours: a terminal without NO_COLOR, or CLICOLOR_FORCE.
enum class Colour { red, yellow, dim };
std::string coloured(const std::string& text, Colour colour);

}  // namespace myrialux::app
