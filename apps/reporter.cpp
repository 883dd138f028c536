#include "reporter.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace myrialux::app {
namespace {

bool is_set(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

bool takes_control_codes() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && terminal != nullptr && std::string(terminal) != "dumb";
}

/// Warnings and errors only.
class QuietReporter final : public Reporter {
 public:
  QuietReporter() : Reporter(1e9) {}
};

}  // namespace

int StageState::percent() const {
  if (total == 0) return 0;
  const double share = 100 * static_cast<double>(done) / static_cast<double>(total);
  return done >= total ? 100 : std::min(99, static_cast<int>(share));
}

double StageState::rate() const { return elapsed_s > 0 ? static_cast<double>(done) / elapsed_s : 0; }

double StageState::seconds_left() const {
  if (total == 0 || done == 0 || done > total) return -1;
  return elapsed_s * static_cast<double>(total - done) / static_cast<double>(done);
}

StageState Reporter::state() const {
  return {name_, unit_, done_.load(std::memory_order_relaxed), total_, clock_.elapsed(), ended_.contains(name_)};
}

void Reporter::stage(const std::string& name, std::uint64_t n_items, const std::string& unit) {
  end_stage();
  const std::lock_guard lock(mutex_);
  name_ = name, unit_ = unit, total_ = n_items;
  done_ = 0, is_running_ = true;
  clock_.lap();
  next_s_ = interval_s_;
  show_begin(state());
}

void Reporter::advance(std::uint64_t n_items) {
  done_.fetch_add(n_items, std::memory_order_relaxed);
  if (clock_.elapsed() < next_s_.load(std::memory_order_relaxed)) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock() || clock_.elapsed() < next_s_) return;  // another thread shows it
  next_s_ = clock_.elapsed() + interval_s_;
  show_state(state());
}

void Reporter::note(const std::string& line) {
  end_stage();
  const std::lock_guard lock(mutex_);
  show_note(line);
}

void Reporter::end_stage(bool is_whole) {
  const std::lock_guard lock(mutex_);
  if (!is_running_) return;
  is_running_ = false;
  show_end(state(), is_whole);
  if (is_whole) ended_.insert(name_);
}

void Reporter::warn(const std::vector<Diagnostic>& diagnostics) {
  std::map<std::string, std::size_t> count;  // of those not told yet, by text without its place
  for (const Diagnostic& d : diagnostics)
    if (!warned_.contains(to_string(d))) ++count[d.message];
  end_stage();
  const std::lock_guard lock(mutex_);
  for (const Diagnostic& d : diagnostics) {
    warned_.insert(to_string(d));
    const auto it = count.find(d.message);
    if (it == count.end()) continue;
    show_warning(to_string(d) + (it->second > 1 ? fmt::format(" ({} times in all)", it->second) : ""));
    count.erase(it);
  }
}

void Reporter::warn(const std::vector<std::string>& lines) {
  std::vector<Diagnostic> fresh;
  for (const std::string& line : lines) {
    if (warned_.contains(line)) continue;
    Diagnostic& d = fresh.emplace_back();
    d.severity = Severity::warning, d.message = line;
  }
  warn(fresh);
}

void Reporter::fail(const std::string& message, int exit_code) {
  end_stage(false);
  const std::lock_guard lock(mutex_);
  show_failure(message, exit_code);
}

void Reporter::done(const std::vector<std::string>& lines, const std::vector<std::string>& outputs) {
  end_stage();
  const std::lock_guard lock(mutex_);
  show_done(lines, outputs);
}

void Reporter::show_warning(const std::string& text) { fmt::print(stderr, "{}\n", coloured(text, Colour::yellow)); }

void Reporter::show_failure(const std::string& text, int) {
  fmt::print(stderr, "{}{}\n", coloured("error: ", Colour::red), text);
}

std::unique_ptr<Reporter> make_reporter(const std::string& kind) {
  if (kind == "none") return std::make_unique<QuietReporter>();
  if (kind == "json") return make_json_reporter();
  if (kind == "bar" || (kind == "auto" && takes_control_codes())) return make_bar_reporter();
  return make_plain_reporter();
}

std::string coloured(const std::string& text, Colour colour) {
  if (!is_set("CLICOLOR_FORCE") && (is_set("NO_COLOR") || !takes_control_codes())) return text;
  const char* code = colour == Colour::red ? "1;31" : colour == Colour::yellow ? "33" : "2";
  return fmt::format("\x1b[{}m{}\x1b[0m", code, text);
}

}  // namespace myrialux::app
