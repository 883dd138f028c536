// Visibility of slices, side by side in one process: every active entry traced, against completions with any -D keys,
// on some slices of a frame at full size. Ratios are of one thread's CPU time (active sets, which all need, left out);
// errors are the pixels' own, as far as these slices make them. `slices_bench --help` tells the options.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bench_frame.h"
#include "myrialux/base/clock.h"
#include "myrialux/base/error.h"
#include "myrialux/pipeline/parameters.h"
#include "myrialux/shading/shade.h"
#include "myrialux/visibility/heavy_entries.h"
#include "myrialux/visibility/slice_visibility.h"

namespace myrialux {
namespace {

struct Options {
  bench::FrameParams frame{.width = 1280, .height = 720, .seed = 0};
  std::uint32_t n_slices = 100;
  int n_repeats = 1;
  bool json = false;
  std::vector<std::string> scenes, variants;
};

struct Variant {
  std::string text, method;
  TunedParams params;
  std::size_t every = 1;   ///< of `full`: one block of this many
  bool scattered = false;  ///< of `full`: one row of it
  bool occluders = false;  ///< triangles that blocked rays are remembered
};

/// One way to the bits of all slices looked at.
struct Tally {
  double seconds = 0;        ///< completion with its rays
  double trace_seconds = 0;  ///< of them, in rays
  std::uint64_t entries = 0, traced = 0, packets = 0, full_columns = 0;
  std::uint64_t wrong = 0, false_visible = 0;
  std::vector<Rgb> radiance;  ///< by receiver looked at
};

constexpr const char* kVariants =
    "What is compared with tracing all: METHOD key=value ...\n"
    "lbamc, bamc: keys as -D without the method's name; lbamc also slack=X (energies times X)\n"
    "full every=N: only every Nth block of 16 rows is traced, in coherent packets\n"
    "full every=N scattered=1: only one row of each of these, gathered in packets of 16\n"
    "all: occluders=0 or 1: whether triangles that blocked rays are remembered (full: 0, others: 1)\n";

Options read_options(int argc, char** argv) {
  Options o;
  std::string size = "1280x720";
  CLI::App app("Visibility of slices: tracing all against completions, in one process");
  app.add_option("SCENE", o.scenes, "Scenes")->required();
  app.add_option("--size", size, "Pixels");
  app.add_option("--spp", o.frame.spp, "Camera samples a pixel");
  app.add_option("--vpls", o.frame.n_lights, "Virtual lights");
  app.add_option("--clusters", o.frame.n_clusters, "Columns a slice");
  app.add_option("--rows", o.frame.n_rows, "Receivers a slice");
  app.add_option("--slices", o.n_slices, "Slices looked at, evenly spread over the frame");
  app.add_option("--repeat", o.n_repeats, "Runs of each, of which the fastest counts");
  app.add_option("--seed", o.frame.seed, "Random seed");
  app.add_flag("--json", o.json, "One JSON object a line");
  app.add_option("--variant", o.variants, kVariants);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    std::exit(app.exit(e));
  }
  if (std::sscanf(size.c_str(), "%dx%d", &o.frame.width, &o.frame.height) != 2)
    throw Error(ErrorKind::usage, "--size: expected WxH, got " + size);
  if (o.variants.empty()) o.variants = {"lbamc", "bamc"};
  return o;
}

Variant read_variant(const std::string& text) {
  Variant v{.text = text, .method = {}, .params = {}};
  std::istringstream words(text);
  words >> v.method;
  if (v.method != "lbamc" && v.method != "bamc" && v.method != "full")
    throw Error(ErrorKind::usage, "--variant " + text + ": begins with lbamc, bamc or full");
  v.occluders = v.method != "full";
  std::map<std::string, std::string> extra;
  float slack = 1;
  for (std::string word; words >> word;) {
    const std::size_t equal = word.find('=');
    if (equal == std::string::npos) throw Error(ErrorKind::usage, "--variant: expected key=value, got " + word);
    const std::string key = word.substr(0, equal), value = word.substr(equal + 1);
    if (v.method == "full" && key == "every")
      v.every = std::stoul(value);
    else if (v.method == "full" && key == "scattered")
      v.scattered = value == "1";
    else if (key == "occluders")
      v.occluders = value == "1";
    else if (v.method == "lbamc" && key == "slack")
      slack = std::stof(value);
    else
      extra[v.method + "." + key] = value;
  }
  apply_extra(extra, v.params);
  v.params.method.lbamc = with_slack(v.params.method.lbamc, slack);
  return v;
}

/// Rows of column j that a variant of `full` traces.
void choose_rows(const Variant& variant, Words active, std::size_t j, MutableWords wanted) {
  for (std::size_t w = 0; w < active.size(); ++w) {
    wanted[w] = 0;
    for (std::size_t b = 0; b < 4; ++b) {
      const std::uint64_t rows = active[w] & std::uint64_t{0xffff} << 16 * b;
      if ((4 * w + b + j) % variant.every == 0) wanted[w] |= variant.scattered ? rows & -rows : rows;
    }
  }
}

CompletionStats trace_some(const Variant& variant, SliceVisibility& slice, BitMatrix& bits) {
  CompletionStats stats;
  std::vector<std::uint64_t> wanted(bits.words_per_column());
  for (std::size_t j = 0; j < slice.n_columns(); ++j) {
    choose_rows(variant, slice.active(j), j, wanted);
    stats.entries += count_bits(slice.active(j)), stats.traced += count_bits(wanted);
    slice.trace(j, wanted, bits.column(j));
  }
  return stats;
}

/// All ways to the bits of some slices of a frame.
class Comparison {
 public:
  Comparison(const bench::Frame& frame, const Options& o);
  void run(const std::vector<Variant>& variants);
  void report(const std::string& scene, const std::vector<Variant>& variants) const;

 private:
  void run_slice(std::size_t k, const Variant& variant, const std::vector<Column>& columns, Tally& tally,
                 BitMatrix& bits);
  void prepare(std::size_t k, const Variant& variant, const std::vector<Column>& columns, SliceVisibility& slice) const;
  std::vector<double> pixel_luminance(const Tally& tally) const;

  const bench::Frame& f_;
  const Options& o_;
  float mean_radiance_ = 0;
  std::vector<std::size_t> chosen_;  ///< slices looked at
  Tally full_;
  std::vector<Tally> tallies_;
};

Comparison::Comparison(const bench::Frame& frame, const Options& o) : f_(frame), o_(o) {
  const std::size_t n_slices = frame.slices.size(), n = std::min<std::size_t>(o.n_slices, n_slices);
  for (std::size_t k = 0; k < n; ++k) chosen_.push_back((2 * k + 1) * n_slices / (2 * n));
}

/// Tells the source what the method asks of it, as the slice driver does.
void Comparison::prepare(std::size_t k, const Variant& variant, const std::vector<Column>& columns,
                         SliceVisibility& slice) const {
  const std::span<const ReceiverId> rows = f_.slices.rows(chosen_[k]);
  if (variant.method == "lbamc")
    slice.set_block_energies(BlockEnergies(f_.world, f_.rows(), rows, f_.lights.lights, f_.tree, columns,
                                           f_.cut.clamp_distance, mean_radiance_));
  if (variant.method == "bamc" && variant.params.method.bamc_guard > 0)
    slice.require(heavy_entries(f_.world, f_.rows(), rows, f_.lights.lights, f_.tree, columns, slice.active_matrix(),
                                f_.cut.clamp_distance, variant.params.method.bamc_guard * mean_radiance_));
}

/// Least time of some repetitions; the bits are always the same.
void Comparison::run_slice(std::size_t k, const Variant& variant, const std::vector<Column>& columns, Tally& tally,
                           BitMatrix& bits) {
  const std::span<const ReceiverId> rows = f_.slices.rows(chosen_[k]);
  double least = 0, least_trace = 0;
  for (int repeat = 0; repeat < o_.n_repeats; ++repeat) {
    const bool first = repeat == 0;
    bits = BitMatrix(rows.size(), columns.size());
    SliceVisibility slice(f_.world, f_.rows(), rows, f_.lights.lights, columns, true);  // active bits: all need them
    if (!variant.occluders) slice.forget_occluders();
    ThreadStopwatch cpu;
    prepare(k, variant, columns, slice);
    Rng rng(f_.key, Stage::visibility, chosen_[k]);
    CompletionStats stats;
    const MethodParams& p = variant.params.method;
    if (variant.method == "full")
      stats = variant.every > 1 ? trace_some(variant, slice, bits) : trace_all(slice, bits);
    else if (variant.method == "lbamc")
      stats = complete_localized(slice, p.lbamc, rng, bits);
    else
      stats = complete_bamc(slice, p.bamc, rng, bits);
    const double seconds = cpu.lap();
    if (first || seconds < least) least = seconds, least_trace = slice.trace_seconds();
    if (!first) continue;
    tally.entries += stats.entries, tally.traced += stats.traced, tally.full_columns += stats.full_columns;
    tally.packets += slice.packets();
  }
  tally.seconds += least, tally.trace_seconds += least_trace;
  std::vector<Rgb> radiance(rows.size());
  shade_slice(f_.world, f_.rows(), rows, f_.lights.lights, columns, bits, {.clamp_distance = f_.cut.clamp_distance},
              radiance);
  tally.radiance.insert(tally.radiance.end(), radiance.begin(), radiance.end());
}

void Comparison::run(const std::vector<Variant>& variants) {
  const Variant full{.text = "full", .method = "full", .params = {}};
  tallies_.assign(variants.size(), {});
  std::vector<std::vector<Column>> columns;
  std::vector<BitMatrix> truth(chosen_.size());
  double sum = 0, n = 0;
  for (std::size_t k = 0; k < chosen_.size(); ++k) {
    columns.push_back(f_.columns(chosen_[k]));
    // The mean radiance is needed first; its time counts with those of the others, slice by slice, below.
    Tally first;
    run_slice(k, full, columns[k], first, truth[k]);
    std::size_t r = 0;
    for (const ReceiverId i : f_.slices.rows(chosen_[k]))
      sum += luminance(f_.rows().beta[index(i)] * first.radiance[r++]), n += 1;
  }
  mean_radiance_ = static_cast<float>(sum / n);
  for (std::size_t k = 0; k < chosen_.size(); ++k) {
    BitMatrix bits;
    run_slice(k, full, columns[k], full_, bits);
    for (std::size_t v = 0; v < variants.size(); ++v) {
      run_slice(k, variants[v], columns[k], tallies_[v], bits);
      for (std::size_t j = 0; j < columns[k].size(); ++j) {
        const Words a = std::as_const(bits).column(j), b = std::as_const(truth[k]).column(j);
        for (std::size_t w = 0; w < a.size(); ++w) {
          tallies_[v].wrong += static_cast<std::uint64_t>(std::popcount(a[w] ^ b[w]));
          tallies_[v].false_visible += static_cast<std::uint64_t>(std::popcount(a[w] & ~b[w]));
        }
      }
    }
  }
}

/// Of pixels that slices looked at reach, by the samples of those slices.
std::vector<double> Comparison::pixel_luminance(const Tally& tally) const {
  std::map<std::uint32_t, double> pixels;
  std::size_t r = 0;
  for (const std::size_t s : chosen_)
    for (const ReceiverId i : f_.slices.rows(s))
      pixels[f_.rows().sample[index(i)] / static_cast<std::uint32_t>(o_.frame.spp)] +=
          luminance(f_.rows().beta[index(i)] * tally.radiance[r++]) / o_.frame.spp;
  std::vector<double> values;
  values.reserve(pixels.size());
  for (const auto& [pixel, value] : pixels) values.push_back(value);
  return values;
}

/// Differences of pixels, over the reference's mean.
struct PixelErrors {
  double rmse = 0, trimmed_rmse = 0, bias = 0;  ///< trimmed: without the worst thousandth
};

PixelErrors pixel_errors(const std::vector<double>& reference, const std::vector<double>& pixels) {
  const auto n = static_cast<double>(reference.size());
  std::vector<double> squares;
  double mean = 0, sum = 0, trimmed = 0, bias = 0;
  for (std::size_t k = 0; k < pixels.size(); ++k) {
    const double difference = pixels[k] - reference[k];
    mean += reference[k] / n, bias += difference / n;
    squares.push_back(difference * difference);
  }
  std::sort(squares.begin(), squares.end());
  for (std::size_t k = 0; k < squares.size(); ++k) {
    sum += squares[k] / n;
    if (k < squares.size() - squares.size() / 1000) trimmed += squares[k] / n;
  }
  return {std::sqrt(sum) / mean, std::sqrt(trimmed) / mean, bias / mean};
}

void Comparison::report(const std::string& scene, const std::vector<Variant>& variants) const {
  const std::vector<double> reference = pixel_luminance(full_);
  const auto percent = [](auto part, auto whole) {
    return 100 * static_cast<double>(part) / static_cast<double>(whole);
  };
  const auto ms_a_slice = [&](double seconds) { return 1e3 * seconds / static_cast<double>(chosen_.size()); };
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const Tally& t = tallies_[v];
    const PixelErrors errors = pixel_errors(reference, pixel_luminance(t));
    const nlohmann::ordered_json line = {{"scene", scene},
                                         {"variant", variants[v].text},
                                         {"speedup", full_.seconds / t.seconds},
                                         {"rmse_percent", 100 * errors.rmse},
                                         {"trimmed_rmse_percent", 100 * errors.trimmed_rmse},
                                         {"bias_percent", 100 * errors.bias},
                                         {"traced_percent", percent(t.traced, full_.entries)},
                                         {"packets_percent", percent(t.packets, full_.packets)},
                                         {"wrong_percent", percent(t.wrong, full_.entries)},
                                         {"false_visible_percent", percent(t.false_visible, full_.entries)},
                                         {"full_ms_a_slice", ms_a_slice(full_.seconds)},
                                         {"ms_a_slice", ms_a_slice(t.seconds)},
                                         {"trace_ms_a_slice", ms_a_slice(t.trace_seconds)}};
    if (o_.json)
      fmt::print("{}\n", line.dump());
    else
      fmt::print(
          "{:14} {:5.2f} times as fast, error {:5.2f} % ({:.2f} without the worst 0.1 %), bias {:+.2f} %, traced "
          "{:.1f} % in {:.1f} % of the packets, wrong {:.3f} %: {}\n",
          scene, line["speedup"].get<double>(), 100 * errors.rmse, 100 * errors.trimmed_rmse, 100 * errors.bias,
          line["traced_percent"].get<double>(), line["packets_percent"].get<double>(),
          line["wrong_percent"].get<double>(), variants[v].text);
    std::fflush(stdout);
  }
}

void run(int argc, char** argv) {
  const Options options = read_options(argc, argv);
  std::vector<Variant> variants;
  for (const std::string& text : options.variants) variants.push_back(read_variant(text));
  for (const std::string& path : options.scenes) {
    const bench::Frame frame(load_scene(path), options.frame);
    Comparison comparison(frame, options);
    comparison.run(variants);
    comparison.report(std::filesystem::path(path).parent_path().filename().string(), variants);
  }
}

}  // namespace
}  // namespace myrialux

int main(int argc, char** argv) {
  try {
    myrialux::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "slices_bench: {}\n", error.what());
    return 2;
  }
}
