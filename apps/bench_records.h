// What `myrialux bench` keeps in its folder: one line a run, so that an interrupted bench goes on where it stopped.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "myrialux/report/image_errors.h"

namespace myrialux::app {

/// One run of one method on one scene.
struct BenchRecord {
  std::string scene, method, knob;  ///< knob: what the budget came to, "clusters=500"
  double budget = 1;
  int repeat = 0;
  double seconds = 0, cpu_seconds = 0;  ///< wall time; CPU time of all threads, NaN if not recorded
  std::uint64_t shadow_rays = 0, entries = 0, traced = 0, bytes = 0;  ///< bytes: working memory of the method
  double clusters_mean = 0;
  /// Of the picture against brute force on the same lights, luminance; NaN in records of brute force itself.
  double rmse = 0, relative_rmse = 0, relative_rmse_without_worst = 0, relmse = 0, bias = 0;
  std::string picture;  ///< within the folder; the same for all repeats
  double flip = 0;      ///< HDR-FLIP; NaN: not evaluated; not kept in runs.jsonl
};

/// A folder with config.json, runs.jsonl, pictures and, at the end, results.csv, results.json, index.html.
class BenchFolder {
 public:
  /// Makes the folder or takes up what is in it.
  /// @throws Error (usage) if it holds a bench with other settings, naming them; (output) if it cannot be written;
  /// (input) if its records cannot be read
  BenchFolder(const std::string& path, const nlohmann::ordered_json& config);

  const std::vector<BenchRecord>& records() const { return records_; }
  bool has(const std::string& scene, const std::string& method, double budget, int repeat) const;
  /// Appends a line; on disk when it returns.
  void add(const BenchRecord& record);
  std::string file(const std::string& name) const { return path_ + "/" + name; }
  const nlohmann::ordered_json& config() const { return config_; }

 private:
  std::string path_;
  nlohmann::ordered_json config_;
  std::vector<BenchRecord> records_;
};

/// One line of results: all repeats of a method at a budget.
struct BenchResult {
  BenchRecord first;                            ///< pictures and counts are the same in all repeats
  double seconds = 0, least_s = 0, most_s = 0;  ///< median, smallest, largest
  double cpu_seconds = 0;                       ///< median
  int repeats = 0;
};
/// In the order of scenes, methods and budgets as they first appear.
std::vector<BenchResult> summarise(const std::vector<BenchRecord>& records);

nlohmann::ordered_json to_json(const BenchResult& result);
std::string to_csv(const std::vector<BenchResult>& results);

}  // namespace myrialux::app
