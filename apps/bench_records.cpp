#include "bench_records.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>

#include "myrialux/base/error.h"
#include "myrialux/base/output_file.h"

namespace myrialux::app {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

double number_or_nan(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

Json record_json(const BenchRecord& r) {
  return {{"scene", r.scene},
          {"method", r.method},
          {"budget", r.budget},
          {"knob", r.knob},
          {"repeat", r.repeat},
          {"seconds", r.seconds},
          {"cpu_seconds", r.cpu_seconds},
          {"shadow_rays", r.shadow_rays},
          {"entries", r.entries},
          {"traced", r.traced},
          {"clusters_mean", r.clusters_mean},
          {"method_bytes", r.bytes},
          {"rmse", r.rmse},
          {"relative_rmse", r.relative_rmse},
          {"relative_rmse_without_worst", r.relative_rmse_without_worst},
          {"relmse", r.relmse},
          {"bias", r.bias},
          {"picture", r.picture}};
}

BenchRecord record_of(const Json& j) {
  return {.scene = j.at("scene"),
          .method = j.at("method"),
          .knob = j.at("knob"),
          .budget = j.at("budget"),
          .repeat = j.at("repeat"),
          .seconds = j.at("seconds"),
          .cpu_seconds = j.contains("cpu_seconds") ? number_or_nan(j["cpu_seconds"]) : number_or_nan({}),
          .shadow_rays = j.at("shadow_rays"),
          .entries = j.at("entries"),
          .traced = j.at("traced"),
          .bytes = j.at("method_bytes"),
          .clusters_mean = j.at("clusters_mean"),
          .rmse = number_or_nan(j.at("rmse")),
          .relative_rmse = number_or_nan(j.at("relative_rmse")),
          .relative_rmse_without_worst = number_or_nan(j.at("relative_rmse_without_worst")),
          .relmse = number_or_nan(j.at("relmse")),
          .bias = number_or_nan(j.at("bias")),
          .picture = j.at("picture"),
          .flip = std::numeric_limits<double>::quiet_NaN()};
}

/// A run that was being written when the machine stopped leaves a line without end, which is dropped from the file.
std::vector<BenchRecord> read_records(const std::string& path) {
  std::vector<BenchRecord> records;
  std::ifstream file(path);
  std::string whole;
  int n = 0;
  for (std::string line; std::getline(file, line);) {
    ++n;
    if (file.eof()) break;
    try {
      records.push_back(record_of(Json::parse(line)));
    } catch (const Json::exception& error) {
      throw Error(ErrorKind::input, fmt::format("{}:{}: no record of a run ({}); delete the line, and that run is made "
                                                "again",
                                                path, n, error.what()));
    }
    whole += line + "\n";
  }
  std::error_code none;
  if (fs::exists(path, none) && fs::file_size(path, none) != whole.size()) write_file(path, whole);
  return records;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

/// "size 640x360, was 320x180; ..." of the keys that differ.
std::string differences(const Json& now, const Json& before) {
  std::string text;
  for (const auto& [key, value] : now.items())
    if (!before.contains(key) || before.at(key) != value)
      text += fmt::format("{}{} {} (there: {})", text.empty() ? "" : "; ", key, value.dump(),
                          before.contains(key) ? before.at(key).dump() : "none");
  return text;
}

}  // namespace

BenchFolder::BenchFolder(const std::string& path, const Json& config) : path_(path), config_(config) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error)
    throw Error(ErrorKind::output,
                fmt::format("{}: the folder cannot be made ({}); name another with -o", path, error.message()));
  if (!fs::exists(file("config.json"))) {
    write_file(file("config.json"), config.dump(1) + "\n");
    return;
  }
  Json before;
  try {
    std::ifstream stream(file("config.json"));
    before = Json::parse(stream);
  } catch (const Json::exception& e) {
    throw Error(ErrorKind::input, fmt::format("{}: {}; name another folder with -o", file("config.json"), e.what()));
  }
  const std::string changed = differences(config, before);
  if (!changed.empty())
    throw Error(ErrorKind::usage,
                fmt::format("-o {}: holds a bench with other settings: {}; name another folder", path, changed));
  records_ = read_records(file("runs.jsonl"));
}

bool BenchFolder::has(const std::string& scene, const std::string& method, double budget, int repeat) const {
  return std::any_of(records_.begin(), records_.end(), [&](const BenchRecord& r) {
    return r.scene == scene && r.method == method && r.budget == budget && r.repeat == repeat;
  });
}

void BenchFolder::add(const BenchRecord& record) {
  const std::string path = file("runs.jsonl"), line = record_json(record).dump() + "\n";
  FILE* stream = fopen(path.c_str(), "a");
  const bool written = stream != nullptr && fwrite(line.data(), 1, line.size(), stream) == line.size() &&
                       fflush(stream) == 0 && fsync(fileno(stream)) == 0;
  if (stream != nullptr) fclose(stream);
  if (!written) throw Error(ErrorKind::output, path + ": cannot be written; is the disk full?");
  records_.push_back(record);
}

std::vector<BenchResult> summarise(const std::vector<BenchRecord>& records) {
  std::vector<BenchResult> results;
  std::vector<std::vector<double>> seconds, cpu_seconds;
  for (const BenchRecord& r : records) {
    const auto same = std::find_if(results.begin(), results.end(), [&](const BenchResult& o) {
      return o.first.scene == r.scene && o.first.method == r.method && o.first.budget == r.budget;
    });
    const auto at = static_cast<std::size_t>(same - results.begin());
    if (same == results.end()) results.push_back({.first = r}), seconds.emplace_back(), cpu_seconds.emplace_back();
    seconds[at].push_back(r.seconds), cpu_seconds[at].push_back(r.cpu_seconds);
  }
  for (std::size_t k = 0; k < results.size(); ++k) {
    results[k].seconds = median(seconds[k]), results[k].cpu_seconds = median(cpu_seconds[k]);
    results[k].least_s = *std::min_element(seconds[k].begin(), seconds[k].end());
    results[k].most_s = *std::max_element(seconds[k].begin(), seconds[k].end());
    results[k].repeats = static_cast<int>(seconds[k].size());
  }
  // Repeats and budgets take turns while running; readers want each method's budgets together.
  std::vector<std::string> order;
  const auto place = [&](const std::string& name) {
    const auto it = std::find(order.begin(), order.end(), name);
    if (it != order.end()) return it - order.begin();
    order.push_back(name);
    return static_cast<std::ptrdiff_t>(order.size()) - 1;
  };
  for (const BenchResult& r : results) place("scene " + r.first.scene), place("method " + r.first.method);
  std::stable_sort(results.begin(), results.end(), [&](const BenchResult& a, const BenchResult& b) {
    const auto key = [&](const BenchResult& r) {
      return std::tuple(place("scene " + r.first.scene), place("method " + r.first.method), r.first.budget);
    };
    return key(a) < key(b);
  });
  return results;
}

Json to_json(const BenchResult& r) {
  Json json = record_json(r.first);
  json.erase("repeat");
  json["seconds"] = r.seconds, json["seconds_least"] = r.least_s, json["seconds_most"] = r.most_s;
  json["cpu_seconds"] = r.cpu_seconds;
  json["repeats"] = r.repeats;
  json["flip"] = r.first.flip;
  return json;
}

std::string to_csv(const std::vector<BenchResult>& results) {
  std::string text =
      "scene,method,budget,knob,seconds,seconds_least,seconds_most,cpu_seconds,repeats,shadow_rays,entries,traced,"
      "clusters_mean,"
      "method_bytes,relative_rmse,relative_rmse_without_worst,rmse,relmse,bias,flip\n";
  const auto cell = [](double value) { return std::isnan(value) ? std::string() : fmt::format("{:.6g}", value); };
  for (const BenchResult& r : results) {
    const BenchRecord& f = r.first;
    text += fmt::format("{},{},{},{},{:.4f},{:.4f},{:.4f},{},{},{},{},{},{:.1f},{},{},{},{},{},{},{}\n", f.scene,
                        f.method, f.budget, f.knob, r.seconds, r.least_s, r.most_s, cell(r.cpu_seconds), r.repeats,
                        f.shadow_rays, f.entries, f.traced, f.clusters_mean, f.bytes, cell(f.relative_rmse),
                        cell(f.relative_rmse_without_worst), cell(f.rmse), cell(f.relmse), cell(f.bias), cell(f.flip));
  }
  return text;
}

}  // namespace myrialux::app
