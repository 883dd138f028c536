// One JSON object a line for programs that watch: events stage, progress, stage_end, note, warning, error, done.
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "reporter.h"

namespace myrialux::app {
namespace {

using Json = nlohmann::ordered_json;

class JsonReporter final : public Reporter {
 public:
  JsonReporter() : Reporter(0.5) {}

 private:
  static Json describe(const char* event, const StageState& s) {
    Json j = {{"event", event}, {"stage", s.name}, {"done", s.done}};
    j["total"] = s.total > 0 ? Json(s.total) : Json(nullptr);
    j["unit"] = s.unit;
    return j;
  }

  void show_begin(const StageState& s) override { say(describe("stage", s)); }
  void show_state(const StageState& s) override {
    Json j = describe("progress", s);
    j["elapsed_s"] = s.elapsed_s;
    j["eta_s"] = s.seconds_left() >= 0 ? Json(s.seconds_left()) : Json(nullptr);
    say(j);
  }
  void show_end(const StageState& s, bool is_whole) override {
    Json j = describe("stage_end", s);
    j["elapsed_s"] = s.elapsed_s;
    j["whole"] = is_whole;
    say(j);
  }
  void show_note(const std::string& line) override { say({{"event", "note"}, {"message", line}}); }
  void show_warning(const std::string& text) override { say({{"event", "warning"}, {"message", text}}); }
  void show_failure(const std::string& text, int exit_code) override {
    say({{"event", "error"}, {"exit_code", exit_code}, {"message", text}});
  }
  void show_done(const std::vector<std::string>& lines, const std::vector<std::string>& outputs) override {
    say({{"event", "done"}, {"summary", lines}, {"outputs", outputs}});
  }

  static void say(const Json& j) {
    fmt::print(stderr, "{}\n", j.dump(-1, ' ', false, Json::error_handler_t::replace));
    std::fflush(stderr);
  }
};

}  // namespace

std::unique_ptr<Reporter> make_json_reporter() { return std::make_unique<JsonReporter>(); }

}  // namespace myrialux::app
