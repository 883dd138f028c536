// The numbers of a render as stats.json; what was not measured is null.
#include "myrialux/report/stats.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "myrialux/base/output_file.h"

namespace myrialux {
namespace {

using Json = nlohmann::ordered_json;

/// -1 stands for "not measured"; so does what is not a number.
Json measured(double value) { return value >= 0 ? Json(value) : Json(nullptr); }

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

Json share(std::uint64_t part, std::uint64_t whole) {
  return whole > 0 ? Json(static_cast<double>(part) / static_cast<double>(whole)) : Json(nullptr);
}

Json interval_json(double estimate, Interval interval) {
  return {{"estimate", estimate}, {"low", interval.low}, {"high", interval.high}};
}

/// Estimates are means over passes.
Json meter_json(const RenderStats::Visibility::Meter& m) {
  if (m.rays == 0) return nullptr;
  const MeterErrors errors = meter_errors(m);
  return {{"rays", m.rays},
          {"more_rays", m.more_rays},
          {"wrong", interval_json(errors.wrong, errors.wrong_interval)},
          {"error", interval_json(errors.error, errors.error_interval)},
          {"bias", interval_json(errors.bias, errors.bias_interval)},
          {"mean_radiance", m.mean_radiance},
          {"pilot_error", m.pilot_error},
          {"slack", m.slack},
          {"slices", m.slices},
          {"redone_slices", m.redone_slices}};
}

Json visibility_json(const RenderStats::Visibility& v) {
  return {{"entries", v.entries},
          {"traced", v.traced},
          {"fraction", share(v.traced, v.entries)},
          {"false_visible_estimate", share(v.false_visible, v.checked)},
          {"false_occluded_estimate", share(v.false_occluded, v.checked)},
          {"fully_sampled_columns", v.fully_sampled_columns},
          {"verified_columns", v.verified_columns},
          {"meter", meter_json(v.meter)}};
}

/// The stages of the contract in their order, then any others.
Json times_json(const std::map<std::string, double>& time_s) {
  Json times = Json::object();
  for (const char* stage :
       {"load", "build", "receivers", "lights", "cluster", "visibility", "complete", "shade", "film", "total"}) {
    const auto it = time_s.find(stage);
    times[stage] = it == time_s.end() ? Json(nullptr) : Json(it->second);
  }
  for (const auto& [stage, seconds] : time_s)
    if (!times.contains(stage)) times[stage] = seconds;
  return times;
}

}  // namespace

MeterErrors meter_errors(const RenderStats::Visibility::Meter& m) {
  MeterErrors e;
  if (m.rays == 0) return e;
  e.wrong = static_cast<double>(m.wrong) / static_cast<double>(m.rays);
  e.wrong_interval = share_interval(m.wrong, m.rays);
  const double half_bias = kNormal95 * std::sqrt(m.bias_variance);
  e.error = std::sqrt(std::max(0.0, m.error_square));
  const Interval square = skewed_interval(m.error_square, m.error_square_variance, m.error_square_third);
  e.error_interval = {std::sqrt(std::max(0.0, square.low)), std::sqrt(std::max(0.0, square.high))};
  e.bias = m.bias;
  e.bias_interval = {m.bias - half_bias, m.bias + half_bias};
  return e;
}

std::string error_words(const MeterErrors& e) {
  if (e.error <= 0) return fmt::format("at most {:.2f} % (95 %)", 100 * e.error_interval.high);
  return fmt::format("{:.2f} % (95 %: {:.2f} to {:.2f})", 100 * e.error, 100 * e.error_interval.low,
                     100 * e.error_interval.high);
}

std::string to_json(const RenderStats& s) {
  Json parameters = Json::object();
  for (const auto& [key, value] : s.parameters) parameters[key] = value;
  const RenderStats::ClustersAuto& c = s.clusters_auto;
  const Json json = {
      {"version", MYRIALUX_VERSION},
      {"scene", s.scene},
      {"method", s.method},
      {"parameters", parameters},
      {"seed", s.seed},
      {"threads", s.threads},
      {"isa", text_or_null(s.isa)},
      {"device", text_or_null(s.device)},
      {"receivers", s.receivers},
      {"virtual_lights", s.virtual_lights},
      {"slices", s.slices},
      {"clusters_mean", s.slices > 0 || s.clusters_mean > 0 ? measured(s.clusters_mean) : Json(nullptr)},
      {"clusters_auto",
       {{"chosen", c.chosen > 0 ? Json(c.chosen) : Json(nullptr)},
        {"light_set_error", c.chosen > 0 ? measured(c.light_set_error) : Json(nullptr)},
        {"cluster_error", c.chosen > 0 ? measured(c.cluster_error) : Json(nullptr)},
        {"visibility_error", c.chosen > 0 ? measured(c.visibility_error) : Json(nullptr)}}},
      {"passes", s.passes},
      {"visibility", visibility_json(s.visibility)},
      {"refinement",
       {{"bounds", s.refinement.bounds > 0 ? Json(s.refinement.bounds) : Json(nullptr)},
        {"approximate_rays", s.refinement.bounds > 0 ? Json(s.refinement.approximate_rays) : Json(nullptr)}}},
      {"rays",
       {{"camera", s.rays.camera},
        {"light", s.rays.light},
        {"shadow", s.rays.shadow},
        {"compensation", s.rays.compensation}}},
      {"time_s", times_json(s.time_s)},
      {"cpu_s", s.cpu_s.empty() ? Json(nullptr) : Json(s.cpu_s)},
      {"memory_bytes",
       {{"peak_rss", s.memory.peak_rss},
        {"predicted", s.memory.predicted > 0 ? Json(s.memory.predicted) : Json(nullptr)},
        {"scene", s.memory.scene},
        {"slices_peak", s.memory.slices_peak},
        {"trees", s.memory.trees > 0 ? Json(s.memory.trees) : Json(nullptr)}}},
      {"error", {{"estimate", measured(s.error_estimate)}, {"confidence", measured(s.error_confidence)}}},
      {"clamped_energy_fraction", measured(s.clamped_energy_fraction)},
      {"warnings", s.warnings}};
  // File names need not be UTF-8; JSON must be.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::uint64_t peak_rss_bytes() {
  // getrusage() would also count the program that started this one: its memory at the time of exec().
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::uint64_t kib = 0;
    if (word == "VmHWM:" && status >> kib) return kib * 1024;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

void write_text_file(const std::string& path, const std::string& text) { write_file(path, text); }

}  // namespace myrialux
