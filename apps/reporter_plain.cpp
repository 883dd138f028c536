// Plain lines for logs: one at most every five seconds while a stage runs, one when it ends.
#include <fmt/format.h>

#include <cstdio>

#include "reporter.h"
#include "words.h"

namespace myrialux::app {
namespace {

constexpr double kInterval_s = 5;

class PlainReporter final : public Reporter {
 public:
  PlainReporter() : Reporter(kInterval_s) {}

 private:
  void show_state(const StageState& s) override {
    std::string line = s.name + ":";
    if (s.total > 0) line += fmt::format(" {} %", s.percent());
    line += fmt::format(" after {}", duration_words(s.elapsed_s));
    if (s.done > 0) line += fmt::format(", {} {}/s", count_words(s.rate()), s.unit);
    if (s.seconds_left() >= 0) line += ", " + duration_words(s.seconds_left()) + " left";
    say(line);
  }

  void show_end(const StageState& s, bool is_whole) override {
    // Passes repeat their stages: short ones need no line each time.
    if (s.repeated && is_whole && since_line_.elapsed() < kInterval_s) return;
    if (!is_whole && s.elapsed_s < 1) return;
    std::string line =
        fmt::format("{}: {} {}", s.name, is_whole ? "done in" : "stopped after", duration_words(s.elapsed_s));
    if (s.done > 0)
      line += fmt::format(", {} {}, {} {}/s", count_words(static_cast<double>(s.done)), s.unit, count_words(s.rate()),
                          s.unit);
    say(line);
  }

  void show_note(const std::string& line) override { say(line); }
  void show_done(const std::vector<std::string>& lines, const std::vector<std::string>& outputs) override {
    for (const std::string& line : lines) say(line);
    for (const std::string& path : outputs) say("wrote " + path);
  }

  void say(const std::string& line) {
    fmt::print(stderr, "{}\n", line);
    since_line_.lap();
  }

  Stopwatch since_line_;
};

}  // namespace

std::unique_ptr<Reporter> make_plain_reporter() { return std::make_unique<PlainReporter>(); }

}  // namespace myrialux::app
