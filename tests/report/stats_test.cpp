// stats.json: the keys of the contract, and text that parses whatever it holds.
#include "myrialux/report/stats.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "myrialux/base/error.h"
#include "support/temporary_folder.h"

namespace myrialux {
namespace {

using nlohmann::ordered_json;
using testing::ElementsAre;

std::vector<std::string> keys(const ordered_json& object) {
  std::vector<std::string> names;
  for (const auto& [name, value] : object.items()) names.push_back(name);
  return names;
}

RenderStats some_stats() {
  RenderStats s;
  s.scene = "room.xml", s.method = "bamc", s.seed = ~std::uint64_t{0}, s.threads = 7, s.isa = "AVX2";
  s.receivers = 1000, s.virtual_lights = 2000, s.slices = 3, s.passes = 1, s.clusters_mean = 250.5;
  s.visibility.entries = 400, s.visibility.traced = 100;
  s.parameters["bamc.alpha"] = "0.025";
  for (const char* stage : {"load", "build", "total", "direct"}) s.time_s[stage] = 0.5;
  s.warnings = {"a", "b"};
  return s;
}

TEST(Stats, HasTheKeysOfTheContractInOrder) {
  const ordered_json j = ordered_json::parse(to_json(some_stats()));
  EXPECT_THAT(keys(j), ElementsAre("version", "scene", "method", "parameters", "seed", "threads", "isa", "device",
                                   "receivers", "virtual_lights", "slices", "clusters_mean", "clusters_auto", "passes",
                                   "visibility", "refinement", "rays", "time_s", "cpu_s", "memory_bytes", "error",
                                   "clamped_energy_fraction", "warnings"));
  EXPECT_THAT(keys(j["visibility"]),
              ElementsAre("entries", "traced", "fraction", "false_visible_estimate", "false_occluded_estimate",
                          "fully_sampled_columns", "verified_columns", "meter"));
  EXPECT_THAT(keys(j["rays"]), ElementsAre("camera", "light", "shadow", "compensation"));
  EXPECT_THAT(keys(j["time_s"]), ElementsAre("load", "build", "receivers", "lights", "cluster", "visibility",
                                             "complete", "shade", "film", "total", "direct"));
  EXPECT_THAT(keys(j["memory_bytes"]), ElementsAre("peak_rss", "predicted", "scene", "slices_peak", "trees"));
  EXPECT_THAT(keys(j["clusters_auto"]), ElementsAre("chosen", "light_set_error", "cluster_error", "visibility_error"));
  EXPECT_THAT(keys(j["error"]), ElementsAre("estimate", "confidence"));
}

TEST(Stats, ValuesAreThoseCounted) {
  const ordered_json j = ordered_json::parse(to_json(some_stats()));
  EXPECT_EQ(j["version"], MYRIALUX_VERSION);
  EXPECT_EQ(j["seed"].get<std::uint64_t>(), ~std::uint64_t{0}) << "64-bit seeds must not pass through a double";
  EXPECT_EQ(j["visibility"]["fraction"], 0.25);
  EXPECT_EQ(j["clusters_mean"], 250.5);
  EXPECT_EQ(j["parameters"]["bamc.alpha"], "0.025");
  EXPECT_EQ(j["warnings"].size(), 2u);
  EXPECT_EQ(j["time_s"]["build"], 0.5);
}

TEST(Stats, ErrorsAreToldInWords) {
  EXPECT_EQ(error_words({.error = 0.0053, .error_interval = {0.0037, 0.0066}}), "0.53 % (95 %: 0.37 to 0.66)");
  EXPECT_EQ(error_words({.error = 0, .error_interval = {0, 0.0033}}), "at most 0.33 % (95 %)");
}

TEST(Stats, WrongBitsAreSharesOfTheCheckedEntries) {
  RenderStats s;
  s.visibility.entries = 1000, s.visibility.checked = 200;
  s.visibility.false_visible = 1, s.visibility.false_occluded = 3;
  const ordered_json j = ordered_json::parse(to_json(s));
  EXPECT_EQ(j["visibility"]["false_visible_estimate"], 0.005);
  EXPECT_EQ(j["visibility"]["false_occluded_estimate"], 0.015);
}

TEST(Stats, MeterTellsEstimatesWithTheirIntervals) {
  RenderStats s;
  RenderStats::Visibility::Meter& m = s.visibility.meter;
  m.rays = 1000, m.wrong = 10, m.more_rays = 400, m.slices = 40, m.redone_slices = 3;
  m.error_square = 4e-4, m.error_square_variance = 1e-8;  // standard error 1e-4
  m.bias = -1e-3, m.bias_variance = 4e-8, m.mean_radiance = 0.3, m.slack = 2, m.pilot_error = 0.004;
  const ordered_json j = ordered_json::parse(to_json(s))["visibility"]["meter"];
  EXPECT_THAT(keys(j), ElementsAre("rays", "more_rays", "wrong", "error", "bias", "mean_radiance", "pilot_error",
                                   "slack", "slices", "redone_slices"));
  for (const char* key : {"wrong", "error", "bias"})
    EXPECT_THAT(keys(j[key]), ElementsAre("estimate", "low", "high")) << key;
  EXPECT_EQ(j["rays"], 1000);
  EXPECT_EQ(j["more_rays"], 400);
  EXPECT_EQ(j["slices"], 40);
  EXPECT_EQ(j["redone_slices"], 3);
  EXPECT_EQ(j["pilot_error"], 0.004);
  EXPECT_EQ(j["slack"], 2);
  EXPECT_EQ(j["mean_radiance"], 0.3);
  const Interval wrong = share_interval(10, 1000);
  EXPECT_EQ(j["wrong"]["estimate"], 0.01);
  EXPECT_EQ(j["wrong"]["low"], wrong.low);
  EXPECT_EQ(j["wrong"]["high"], wrong.high);
  EXPECT_DOUBLE_EQ(j["error"]["estimate"], 0.02);
  EXPECT_DOUBLE_EQ(j["error"]["low"], std::sqrt(4e-4 - kNormal95 * 1e-4));
  EXPECT_DOUBLE_EQ(j["error"]["high"], std::sqrt(4e-4 + kNormal95 * 1e-4));
  EXPECT_DOUBLE_EQ(j["bias"]["estimate"], -1e-3);
  EXPECT_DOUBLE_EQ(j["bias"]["low"], -1e-3 - kNormal95 * 2e-4);
  EXPECT_DOUBLE_EQ(j["bias"]["high"], -1e-3 + kNormal95 * 2e-4);
  m.error_square_variance = 1;
  EXPECT_EQ(meter_errors(m).error_interval.low, 0) << "no root of a negative number";
  m.error_square = -1e-4;  // estimates of squares may come out below 0
  EXPECT_EQ(meter_errors(m).error, 0);
}

TEST(Stats, MeterOfManyPassesIsTheirMean) {
  RenderStats::Visibility::Meter sum;
  for (const double k : {1.0, 3.0})
    sum += {.rays = 100,
            .wrong = 1,
            .more_rays = 40,
            .slices = 10,
            .redone_slices = 1,
            .error_square = 1e-4 * k,
            .error_square_variance = 1e-10,
            .error_square_third = 1e-16,
            .bias = 1e-3 * k,
            .bias_variance = 1e-8,
            .mean_radiance = k,
            .slack = k,
            .pilot_error = 0.01 * k};
  sum.divide(2);
  EXPECT_EQ(sum.rays, 200u) << "counts stay sums";
  EXPECT_EQ(sum.wrong, 2u);
  EXPECT_EQ(sum.more_rays, 80u);
  EXPECT_EQ(sum.slices, 20u);
  EXPECT_EQ(sum.redone_slices, 2u);
  EXPECT_DOUBLE_EQ(sum.error_square, 2e-4);
  EXPECT_DOUBLE_EQ(sum.error_square_variance, 5e-11) << "of a mean of two";
  EXPECT_DOUBLE_EQ(sum.error_square_third, 2.5e-17);
  EXPECT_DOUBLE_EQ(sum.mean_radiance, 2);
  EXPECT_DOUBLE_EQ(sum.bias, 2e-3);
  EXPECT_DOUBLE_EQ(sum.bias_variance, 5e-9);
  EXPECT_DOUBLE_EQ(sum.slack, 2);
  EXPECT_DOUBLE_EQ(sum.pilot_error, 0.02);
}

TEST(Stats, WhatWasNotMeasuredIsNull) {
  RenderStats s;
  s.clamped_energy_fraction = std::numeric_limits<double>::quiet_NaN();
  const ordered_json j = ordered_json::parse(to_json(s));
  for (const char* pointer :
       {"/visibility/fraction", "/visibility/false_visible_estimate", "/visibility/false_occluded_estimate",
        "/visibility/meter", "/clusters_mean", "/isa", "/clusters_auto/chosen", "/clusters_auto/cluster_error",
        "/time_s/load", "/time_s/total", "/error/estimate", "/error/confidence", "/clamped_energy_fraction"})
    EXPECT_TRUE(j.at(ordered_json::json_pointer(pointer)).is_null()) << pointer;
  EXPECT_TRUE(j["parameters"].is_object());
  EXPECT_TRUE(j["warnings"].is_array());
}

TEST(Stats, AnyTextIsEscaped) {
  RenderStats s;
  s.scene = "a \"quoted\" \\ name\nwith\ttabs \xff and \xc3\xa9.xml";
  s.warnings = {std::string("nul \0 inside", 12)};
  const ordered_json j = ordered_json::parse(to_json(s));
  EXPECT_EQ(j["scene"], "a \"quoted\" \\ name\nwith\ttabs \xef\xbf\xbd and \xc3\xa9.xml");
  EXPECT_EQ(j["warnings"][0], (std::string("nul \0 inside", 12)));
}

TEST(Stats, PeakMemoryCoversWhatWasTouched) {
  const std::vector<char> block(64 << 20, 1);
  EXPECT_GE(peak_rss_bytes(), block.size());
  EXPECT_LT(peak_rss_bytes(), std::uint64_t{1} << 40);
}

TEST(WriteTextFile, ReplacesWholeFilesAndLeavesNothingElse) {
  const test::TemporaryFolder folder;
  write_text_file(folder.file("a.json"), "one");
  write_text_file(folder.file("a.json"), "two, longer");
  EXPECT_EQ(folder.read("a.json"), "two, longer");
  EXPECT_THAT(folder.names(), ElementsAre("a.json"));
}

TEST(WriteTextFile, RefusesFoldersAndMissingFolders) {
  const test::TemporaryFolder folder;
  for (const std::string& path : {folder.path().string(), folder.file("none/a.json"), std::string()}) try {
      write_text_file(path, "text");
      FAIL() << path;
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::output);
    }
}

}  // namespace
}  // namespace myrialux
