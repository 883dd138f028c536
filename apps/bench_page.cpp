// Hands results and pictures to python/myrialux/bench.py in a folder of its own and reads FLIP back.
#include "bench_page.h"

#include <fstream>
#include <limits>

#include "myrialux/film/film.h"
#include "python.h"
#include "scratch.h"

namespace myrialux::app {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::vector<Rgb> read_pixels(const std::string& path) {
  const Picture picture = read_picture(path);
  const Picture::Layer* beauty = picture.find("");
  if (beauty == nullptr || beauty->channels.size() != 3)
    throw Error(ErrorKind::input, path + ": has no channels R, G and B; delete it and its line in runs.jsonl");
  // Channels stand in alphabetical order in the file; read_picture gives them as R G B or B G R.
  std::size_t at[3] = {};
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t c = 0; c < 3; ++c)
      if (beauty->channels[c] == std::string(1, "RGB"[k])) at[k] = c;
  std::vector<Rgb> pixels;
  for (std::size_t i = 0; i < beauty->pixels.size(); i += 3)
    pixels.push_back({beauty->pixels[i + at[0]], beauty->pixels[i + at[1]], beauty->pixels[i + at[2]]});
  return pixels;
}

void write_bench_page(const BenchFolder& folder, std::vector<BenchResult>& results, const std::string& page) {
  const ScratchFolder scratch;
  OutputFile output(page);
  Json list = Json::array();
  for (std::size_t k = 0; k < results.size(); ++k) {
    Json json = to_json(results[k]);
    json["pixels"] =
        write_pixels(scratch, std::to_string(k) + ".f32", read_pixels(folder.file(results[k].first.picture)));
    list.push_back(json);
  }
  const Json job = {
      {"config", folder.config()}, {"results", list}, {"page", std::filesystem::absolute(output.temporary()).string()}};
  write_file(scratch.file("job.json"), job.dump());
  run_python("myrialux.bench", {"."}, scratch.path(), page);
  std::ifstream found(scratch.file("flip.json"));
  const Json flip = Json::parse(found);
  for (std::size_t k = 0; k < results.size(); ++k)
    results[k].first.flip = flip.at(k).is_null() ? std::numeric_limits<double>::quiet_NaN() : flip.at(k).get<double>();
  output.commit();
}

}  // namespace myrialux::app
