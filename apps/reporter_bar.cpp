// One line a stage on a terminal: bar, share, rate and time left while it runs, its time when it has ended.
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

#include "reporter.h"
#include "words.h"

namespace myrialux::app {
namespace {

std::size_t terminal_columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

class BarReporter final : public Reporter {
 public:
  BarReporter() : Reporter(0.1) {}
  ~BarReporter() override { erase(); }

 private:
  void show_begin(const StageState& s) override { show_state(s); }

  void show_state(const StageState& s) override {
    std::string line = fmt::format("{:<12}", s.name);
    if (s.total > 0) {
      constexpr std::size_t kCells = 24;
      const std::size_t full = kCells * static_cast<std::size_t>(s.percent()) / 100;
      line += fmt::format("[{}{}] {:3} %", std::string(full, '#'), std::string(kCells - full, '.'), s.percent());
    } else {
      line += "...";
    }
    if (s.done > 0) line += fmt::format("  {} {}/s", count_words(s.rate()), s.unit);
    if (s.seconds_left() >= 0) line += "  " + duration_words(s.seconds_left()) + " left";
    show(line);
  }

  void show_end(const StageState& s, bool is_whole) override {
    erase();
    if (!is_whole && s.elapsed_s < 1) return;
    if (s.repeated) return;  // later passes leave no line; the sums come at the end
    std::string line = fmt::format("{:<12}{:>12}", s.name, is_whole ? duration_words(s.elapsed_s) : "stopped");
    if (s.done > 0)
      line += fmt::format("   {} {}, {} {}/s", count_words(static_cast<double>(s.done)), s.unit, count_words(s.rate()),
                          s.unit);
    fmt::print(stderr, "{}\n", line);
  }

  void show_note(const std::string& line) override {
    erase();
    fmt::print(stderr, "{}\n", coloured(line, Colour::dim));
  }
  void show_warning(const std::string& text) override {
    erase();
    Reporter::show_warning(text);
  }
  void show_failure(const std::string& text, int exit_code) override {
    erase();
    Reporter::show_failure(text, exit_code);
  }
  void show_done(const std::vector<std::string>& lines, const std::vector<std::string>& outputs) override {
    for (const std::string& line : lines) fmt::print(stderr, "{}\n", line);
    for (const std::string& path : outputs) fmt::print(stderr, "wrote {}\n", path);
  }

  /// Replaces the running line; never wraps.
  void show(const std::string& line) {
    fmt::print(stderr, "\r\x1b[K{}", line.substr(0, terminal_columns() - 1));
    std::fflush(stderr);
    has_line_ = true;
  }
  void erase() {
    if (has_line_) fmt::print(stderr, "\r\x1b[K");
    has_line_ = false;
  }

  bool has_line_ = false;
};

}  // namespace

std::unique_ptr<Reporter> make_bar_reporter() { return std::make_unique<BarReporter>(); }

}  // namespace myrialux::app
