// Reads pictures, refuses what cannot be compared, measures, and writes JSON.
#include "myrialux/report/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "myrialux/base/error.h"

namespace myrialux {
namespace {

using Json = nlohmann::ordered_json;

/// A file as far as it could be read.
struct Candidate {
  std::string path;
  int width = 0, height = 0;  ///< 0: unreadable
  Metadata header;
  std::vector<Rgb> pixels;  ///< empty: has none
};

Candidate open(const std::string& path, Diagnostics& found);
/// Each tells what is wrong; false: cannot be compared, or was told before.
bool check_size(const Candidate& reference, const Candidate& image, Diagnostics& found);
bool check_region(const Candidate& reference, const Region& region, Diagnostics& found);
/// Only the region; complains about what is not finite there.
ComparedPicture cut_out(Candidate& candidate, const Region& region, Diagnostics& found);

void name_images(Comparison& comparison) {
  const auto stem = [](const std::string& path) { return std::filesystem::path(path).stem().string(); };
  for (Comparison::Image& image : comparison.images) {
    const auto n = std::count_if(comparison.images.begin(), comparison.images.end(), [&](const auto& other) {
      return stem(other.picture.path) == stem(image.picture.path);
    });
    image.picture.name = n == 1 ? stem(image.picture.path) : image.picture.path;
  }
  comparison.reference.name = stem(comparison.reference.path);
}

}  // namespace

Comparison compare_pictures(const std::string& reference, const std::vector<std::string>& images,
                            const ComparisonOptions& options) {
  Diagnostics found;
  Candidate truth = open(reference, found);
  Comparison comparison;
  comparison.width = truth.width, comparison.height = truth.height;
  comparison.exposure = options.exposure;
  comparison.region = options.region.value_or(Region{0, 0, truth.width, truth.height});
  const bool is_inside = check_region(truth, comparison.region, found);
  if (is_inside) comparison.reference = cut_out(truth, comparison.region, found);
  for (const std::string& path : images) {
    Candidate candidate = open(path, found);
    if (check_size(truth, candidate, found) && is_inside)
      comparison.images.push_back({.picture = cut_out(candidate, comparison.region, found), .errors = {}});
  }
  found.throw_if(Severity::error);

  name_images(comparison);
  for (Comparison::Image& image : comparison.images)
    image.errors = image_errors(comparison.reference.pixels, image.picture.pixels, options.exposure);
  return comparison;
}

std::vector<std::size_t> by_error(const Comparison& comparison) {
  std::vector<std::size_t> order(comparison.images.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return comparison.images[a].errors.luminance.rmse < comparison.images[b].errors.luminance.rmse;
  });
  return order;
}

namespace {

Candidate open(const std::string& path, Diagnostics& found) {
  Candidate candidate{.path = path, .header = {}, .pixels = {}};
  Picture picture;
  try {
    picture = read_picture(path, &candidate.header);
  } catch (const Error& error) {
    found.error({}, error.what());
    return candidate;
  }
  candidate.width = picture.width, candidate.height = picture.height;
  const Picture::Layer* beauty = picture.find("");
  std::array<std::size_t, 3> at{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto is_wanted = [&](const std::string& name) { return name == std::string(1, "RGB"[k]); };
    const auto& names = beauty ? beauty->channels : std::vector<std::string>();
    const auto it = std::find_if(names.begin(), names.end(), is_wanted);
    if (it == names.end()) {
      std::vector<std::string> layers;
      for (const Picture::Layer& layer : picture.layers)
        for (const std::string& c : layer.channels) layers.push_back(layer.name.empty() ? c : layer.name + "." + c);
      found.error({path}, fmt::format("has no channels R, G and B (it has {}); compare pictures in colour",
                                      fmt::join(layers, ", ")));
      return candidate;
    }
    at[k] = static_cast<std::size_t>(it - names.begin());
  }
  const std::size_t n = beauty->channels.size();
  for (std::size_t i = 0; i < beauty->pixels.size(); i += n)
    candidate.pixels.push_back({beauty->pixels[i + at[0]], beauty->pixels[i + at[1]], beauty->pixels[i + at[2]]});
  return candidate;
}

bool check_size(const Candidate& reference, const Candidate& image, Diagnostics& found) {
  if (reference.width == 0 || image.width == 0) return false;  // told already
  if (reference.width == image.width && reference.height == image.height) return true;
  const bool is_larger = image.width > reference.width;
  const Candidate &large = is_larger ? image : reference, &small = is_larger ? reference : image;
  std::string remedy = fmt::format("render with --size {}x{}", reference.width, reference.height);
  if (large.width % small.width == 0 && large.height % small.height == 0)
    remedy += fmt::format(", or average the larger one down: oiiotool {} --resize:filter=box {}x{} -d float -o {}",
                          large.path, small.width, small.height, "smaller.exr");
  found.error({image.path}, fmt::format("has {}x{} pixels, the reference {} has {}x{}; {}", image.width, image.height,
                                        reference.path, reference.width, reference.height, remedy));
  return false;
}

bool check_region(const Candidate& reference, const Region& r, Diagnostics& found) {
  if (reference.width == 0) return false;
  if (r.x >= 0 && r.y >= 0 && r.width > 0 && r.height > 0 && r.x <= reference.width - r.width &&
      r.y <= reference.height - r.height)
    return true;
  found.error({reference.path},
              fmt::format("has {}x{} pixels; the region {},{},{},{} (x, y, width, height) reaches out", reference.width,
                          reference.height, r.x, r.y, r.width, r.height));
  return false;
}

ComparedPicture cut_out(Candidate& candidate, const Region& region, Diagnostics& found) {
  ComparedPicture picture{.path = candidate.path, .name = {}, .header = std::move(candidate.header), .pixels = {}};
  std::size_t n_bad = 0;
  std::string first;
  for (int y = region.y; y < region.y + region.height && !candidate.pixels.empty(); ++y)
    for (int x = region.x; x < region.x + region.width; ++x) {
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(candidate.width) + static_cast<std::size_t>(x);
      const Rgb p = candidate.pixels[i];
      picture.pixels.push_back(p);
      if (is_finite(p)) continue;
      if (n_bad++ == 0) first = fmt::format("{},{} with {} {} {}", x, y, p.r, p.g, p.b);
    }
  if (n_bad > 0)
    found.error({candidate.path}, fmt::format("{} of its pixels {} not finite, the first at {}; leave {} out with "
                                              "--region, or render again",
                                              n_bad, n_bad == 1 ? "is" : "are", first, n_bad == 1 ? "it" : "them"));
  return picture;
}

Json measures_json(const ErrorMeasures& m) {
  Json json = {{"mean_reference", m.mean_reference}, {"mean", m.mean}};
  for (const MeasureInfo& info : measure_table()) json[info.key] = info.value(m);
  json["differing_pixels"] = m.differing_pixels;
  return json;
}

Json ratios(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  Json list = Json::array();
  for (std::size_t k = 0; k < 3; ++k) list.push_back(b[k] > 0 ? Json(a[k] / b[k]) : Json(nullptr));
  return list;
}

}  // namespace

std::string to_json(const Comparison& c) {
  const Region& r = c.region;
  Json images = Json::array();
  for (const Comparison::Image& image : c.images)
    images.push_back({{"path", image.picture.path},
                      {"name", image.picture.name},
                      {"luminance", measures_json(image.errors.luminance)},
                      {"rgb", measures_json(image.errors.rgb)},
                      {"mean_rgb", image.errors.mean_rgb},
                      {"mean_rgb_ratio", ratios(image.errors.mean_rgb, image.errors.mean_rgb_reference)},
                      {"flip", image.flip},
                      {"flip_shown", image.flip_shown},
                      {"header", image.picture.header}});
  Json flip = nullptr;
  if (c.flip)
    flip = {{"pixels_per_degree", c.flip->pixels_per_degree},
            {"start_exposure", c.flip->start_exposure},
            {"stop_exposure", c.flip->stop_exposure},
            {"exposures", c.flip->n_exposures},
            {"tone_mapper", c.flip->tone_mapper}};
  const Json json = {{"version", MYRIALUX_VERSION},
                     {"size", {c.width, c.height}},
                     {"region", {r.x, r.y, r.width, r.height}},
                     {"exposure", c.exposure},
                     {"reference", {{"path", c.reference.path}, {"header", c.reference.header}}},
                     {"flip_settings", flip},
                     {"images", images}};
  // File names and headers need not be UTF-8; JSON must be. Numbers that are not finite become null.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace myrialux
