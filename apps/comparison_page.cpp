// Hands a comparison to python/myrialux/compare.py in a folder of its own and reads back what it found.
#include "comparison_page.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "myrialux/base/output_file.h"
#include "python.h"
#include "scratch.h"

namespace myrialux::app {
namespace {

using Json = nlohmann::ordered_json;

/// As compare.py describes it.
Json job_of(const Comparison& comparison, const ScratchFolder& folder, const std::string& page) {
  Json measures = Json::array();
  for (const MeasureInfo& m : measure_table())
    measures.push_back({{"key", m.key},
                        {"name", m.name},
                        {"unit", m.unit},
                        {"meaning", m.meaning},
                        {"smaller_is_better", m.smaller_is_better ? Json(*m.smaller_is_better) : Json(nullptr)}});
  Json images = Json::array();
  for (std::size_t k = 0; k < comparison.images.size(); ++k)
    images.push_back(write_pixels(folder, std::to_string(k) + ".f32", comparison.images[k].picture.pixels));
  return {{"comparison", Json::parse(to_json(comparison))},
          {"measures", measures},
          {"relmse_epsilon", kRelmseEpsilon},
          {"pixels",
           {{"reference", write_pixels(folder, "reference.f32", comparison.reference.pixels)}, {"images", images}}},
          {"page", page.empty() ? Json(nullptr) : Json(std::filesystem::absolute(page).string())}};
}

double number_or_nan(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

void take_flip(Comparison& comparison, const Json& found) {
  const Json& s = found.at("settings");
  if (!s.is_null())
    comparison.flip = FlipSettings{.pixels_per_degree = s.at("pixels_per_degree"),
                                   .start_exposure = s.at("start_exposure"),
                                   .stop_exposure = s.at("stop_exposure"),
                                   .n_exposures = s.at("exposures"),
                                   .tone_mapper = s.at("tone_mapper")};
  for (std::size_t k = 0; k < comparison.images.size(); ++k) {
    const Json& image = found.at("images").at(k);
    comparison.images[k].flip = number_or_nan(image.at("flip"));
    comparison.images[k].flip_shown = number_or_nan(image.at("flip_shown"));
  }
}

}  // namespace

void add_flip_and_page(Comparison& comparison, const std::string& page) {
  const ScratchFolder folder;
  std::optional<OutputFile> output;
  if (!page.empty()) output.emplace(page);
  write_file(folder.file("job.json"), job_of(comparison, folder, output ? output->temporary() : "").dump());
  run_python("myrialux.compare", {"."}, folder.path(), page.empty() ? "FLIP" : page);
  std::ifstream found(folder.file("flip.json"));
  take_flip(comparison, Json::parse(found));
  if (output) output->commit();
}

}  // namespace myrialux::app
