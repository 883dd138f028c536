// Visibility of slices, side by side in one process: every active entry traced, against completions with any -D keys,
// on some slices of a frame at full size. Ratios are of one thread's CPU time (active sets, which all need, left out);
// errors are the pixels' own, as far as these slices make them. `slices_bench --help` tells the options.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "myrialux/base/clock.h"
#include "myrialux/base/error.h"
#include "myrialux/clusters/cut.h"
#include "myrialux/pipeline/clamp.h"
#include "myrialux/pipeline/parameters.h"
#include "myrialux/scene/load.h"
#include "myrialux/shading/shade.h"
#include "myrialux/visibility/heavy_entries.h"
#include "myrialux/visibility/slice_visibility.h"

namespace myrialux {
namespace {

struct Options {
  int width = 1280, height = 720, spp = 4, n_repeats = 1;
  std::uint64_t n_lights = 100000, seed = 0;
  std::uint32_t n_clusters = 1000, n_slices = 100, n_rows = 1024;
  bool json = false;
  std::vector<std::string> scenes, variants;
};

struct Variant {
  std::string text, method;
  TunedParams params;
  std::size_t every = 1;   ///< of `full`: one block of this many
  bool scattered = false;  ///< of `full`: one row of it
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
    "full every=N scattered=1: only one row of each of these, gathered in packets of 16\n";

Options read_options(int argc, char** argv) {
  Options o;
  std::string size = "1280x720";
  CLI::App app("Visibility of slices: tracing all against completions, in one process");
  app.add_option("SCENE", o.scenes, "Scenes")->required();
  app.add_option("--size", size, "Pixels");
  app.add_option("--spp", o.spp, "Camera samples a pixel");
  app.add_option("--vpls", o.n_lights, "Virtual lights");
  app.add_option("--clusters", o.n_clusters, "Columns a slice");
  app.add_option("--rows", o.n_rows, "Receivers a slice");
  app.add_option("--slices", o.n_slices, "Slices looked at, evenly spread over the frame");
  app.add_option("--repeat", o.n_repeats, "Runs of each, of which the fastest counts");
  app.add_option("--seed", o.seed, "Random seed");
  app.add_flag("--json", o.json, "One JSON object a line");
  app.add_option("--variant", o.variants, kVariants);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    std::exit(app.exit(e));
  }
  if (std::sscanf(size.c_str(), "%dx%d", &o.width, &o.height) != 2)
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

/// Some slices of a frame: receivers, lights, tree as render() makes them in its first pass.
class Frame {
 public:
  Frame(const Scene& scene, const Options& o);
  void run(const std::vector<Variant>& variants);
  void report(const std::string& scene, const std::vector<Variant>& variants) const;

 private:
  void run_slice(std::size_t k, const Variant& variant, const std::vector<Column>& columns, Tally& tally,
                 BitMatrix& bits);
  void prepare(std::size_t k, const Variant& variant, const std::vector<Column>& columns, SliceVisibility& slice) const;
  std::vector<double> pixel_luminance(const Tally& tally) const;

  const Options& o_;
  Tracer tracer_;
  Emitters emitters_;
  World world_;
  ReceiverResult rows_;
  VirtualLights lights_;
  float clamp_distance_ = 0, mean_radiance_ = 0;
  Slices slices_;
  LightTree tree_;
  std::vector<std::size_t> chosen_;  ///< slices looked at
  Tally full_;
  std::vector<Tally> tallies_;
};

Frame::Frame(const Scene& scene, const Options& o)
    : o_(o),
      tracer_(scene),
      emitters_(scene, tracer_.bounds()),
      world_{.scene = scene,
             .tracer = tracer_,
             .emitters = emitters_,
             .max_depth = scene.max_depth,
             .rr_depth = scene.rr_depth} {
  Progress progress;
  const RandomKey key{o.seed, 0};
  rows_ = trace_receivers(world_, {.width = o.width, .height = o.height, .spp = o.spp, .key = key}, progress);
  lights_ = trace_lights(world_, {.n_lights = o.n_lights, .direct = true, .key = key}, progress).lights;
  clamp_distance_ = clamp_length(0.02f, -1, size_points(rows_.receivers, o.spp));
  const float radius = 0.5f * scene.bounds().diagonal();
  slices_ = make_slices(rows_.receivers, radius, {.max_rows = o.n_rows});
  tree_ = build_light_tree(world_, lights_, radius, {.key = key});
  const std::size_t n = std::min<std::size_t>(o.n_slices, slices_.size());
  for (std::size_t k = 0; k < n; ++k) chosen_.push_back((2 * k + 1) * slices_.size() / (2 * n));
}

/// Tells the source what the method asks of it, as the slice driver does.
void Frame::prepare(std::size_t k, const Variant& variant, const std::vector<Column>& columns,
                    SliceVisibility& slice) const {
  const std::span<const ReceiverId> rows = slices_.rows(chosen_[k]);
  if (variant.method == "lbamc")
    slice.set_block_energies(
        BlockEnergies(world_, rows_.receivers, rows, lights_, tree_, columns, clamp_distance_, mean_radiance_));
  if (variant.method == "bamc" && variant.params.method.bamc_guard > 0)
    slice.require(heavy_entries(world_, rows_.receivers, rows, lights_, tree_, columns, slice.active_matrix(),
                                clamp_distance_, variant.params.method.bamc_guard * mean_radiance_));
}

/// Least time of some repetitions; the bits are always the same.
void Frame::run_slice(std::size_t k, const Variant& variant, const std::vector<Column>& columns, Tally& tally,
                      BitMatrix& bits) {
  const std::span<const ReceiverId> rows = slices_.rows(chosen_[k]);
  double least = 0, least_trace = 0;
  for (int repeat = 0; repeat < o_.n_repeats; ++repeat) {
    const bool first = repeat == 0;
    bits = BitMatrix(rows.size(), columns.size());
    SliceVisibility slice(world_, rows_.receivers, rows, lights_, columns, true);  // active bits: all need them
    ThreadStopwatch cpu;
    prepare(k, variant, columns, slice);
    Rng rng(RandomKey{o_.seed, 0}, Stage::visibility, chosen_[k]);
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
  shade_slice(world_, rows_.receivers, rows, lights_, columns, bits, {.clamp_distance = clamp_distance_}, radiance);
  tally.radiance.insert(tally.radiance.end(), radiance.begin(), radiance.end());
}

void Frame::run(const std::vector<Variant>& variants) {
  const Variant full{.text = "full", .method = "full", .params = {}};
  tallies_.assign(variants.size(), {});
  std::vector<std::vector<Column>> columns;
  std::vector<BitMatrix> truth(chosen_.size());
  double sum = 0, n = 0;
  for (std::size_t k = 0; k < chosen_.size(); ++k) {
    columns.push_back(light_cut(world_, rows_.receivers, slices_.rows(chosen_[k]), lights_, tree_,
                                {.n_clusters = o_.n_clusters, .clamp_distance = clamp_distance_}));
    // The mean radiance is needed first; its time counts with those of the others, slice by slice, below.
    Tally first;
    run_slice(k, full, columns[k], first, truth[k]);
    std::size_t r = 0;
    for (const ReceiverId i : slices_.rows(chosen_[k]))
      sum += luminance(rows_.receivers.beta[index(i)] * first.radiance[r++]), n += 1;
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
std::vector<double> Frame::pixel_luminance(const Tally& tally) const {
  std::map<std::uint32_t, double> pixels;
  std::size_t r = 0;
  for (const std::size_t s : chosen_)
    for (const ReceiverId i : slices_.rows(s))
      pixels[rows_.receivers.sample[index(i)] / static_cast<std::uint32_t>(o_.spp)] +=
          luminance(rows_.receivers.beta[index(i)] * tally.radiance[r++]) / o_.spp;
  std::vector<double> values;
  values.reserve(pixels.size());
  for (const auto& [pixel, value] : pixels) values.push_back(value);
  return values;
}

void Frame::report(const std::string& scene, const std::vector<Variant>& variants) const {
  const std::vector<double> reference = pixel_luminance(full_);
  double mean = 0;
  for (const double v : reference) mean += v / static_cast<double>(reference.size());
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const Tally& t = tallies_[v];
    const std::vector<double> pixels = pixel_luminance(t);
    std::vector<double> squares(pixels.size());
    double bias = 0, sum = 0, trimmed = 0;
    for (std::size_t k = 0; k < pixels.size(); ++k) {
      squares[k] = (pixels[k] - reference[k]) * (pixels[k] - reference[k]);
      bias += (pixels[k] - reference[k]) / static_cast<double>(pixels.size());
    }
    std::sort(squares.begin(), squares.end());
    for (std::size_t k = 0; k < squares.size(); ++k) {
      sum += squares[k] / static_cast<double>(squares.size());
      if (k < squares.size() - squares.size() / 1000) trimmed += squares[k] / static_cast<double>(squares.size());
    }
    const double entries = static_cast<double>(full_.entries);
    const nlohmann::ordered_json line = {
        {"scene", scene},
        {"variant", variants[v].text},
        {"speedup", full_.seconds / t.seconds},
        {"rmse_percent", 100 * std::sqrt(sum) / mean},
        {"trimmed_rmse_percent", 100 * std::sqrt(trimmed) / mean},
        {"bias_percent", 100 * bias / mean},
        {"traced_percent", 100 * static_cast<double>(t.traced) / entries},
        {"packets_percent", 100 * static_cast<double>(t.packets) / static_cast<double>(full_.packets)},
        {"wrong_percent", 100 * static_cast<double>(t.wrong) / entries},
        {"false_visible_percent", 100 * static_cast<double>(t.false_visible) / entries},
        {"full_ms_a_slice", 1e3 * full_.seconds / static_cast<double>(chosen_.size())},
        {"ms_a_slice", 1e3 * t.seconds / static_cast<double>(chosen_.size())},
        {"trace_ms_a_slice", 1e3 * t.trace_seconds / static_cast<double>(chosen_.size())}};
    if (o_.json) {
      fmt::print("{}\n", line.dump());
    } else {
      fmt::print(
          "{:12} {:5.2f}x err {:5.2f} ({:5.2f}) % bias {:+.2f} traced {:5.1f} pk {:5.1f} wrong {:.3f} (vis {:.3f}) % | "
          "ms full {:.2f} this {:.2f} rays {:.2f} | {}\n",
          scene, full_.seconds / t.seconds, 100 * std::sqrt(sum) / mean, 100 * std::sqrt(trimmed) / mean,
          100 * bias / mean, 100 * static_cast<double>(t.traced) / entries,
          100 * static_cast<double>(t.packets) / static_cast<double>(full_.packets),
          100 * static_cast<double>(t.wrong) / entries, 100 * static_cast<double>(t.false_visible) / entries,
          1e3 * full_.seconds / static_cast<double>(chosen_.size()),
          1e3 * t.seconds / static_cast<double>(chosen_.size()),
          1e3 * t.trace_seconds / static_cast<double>(chosen_.size()), variants[v].text);
    }
    std::fflush(stdout);
  }
}

void run(int argc, char** argv) {
  const Options options = read_options(argc, argv);
  std::vector<Variant> variants;
  for (const std::string& text : options.variants) variants.push_back(read_variant(text));
  for (const std::string& path : options.scenes) {
    const Scene scene = load_scene(path);
    Frame frame(scene, options);
    frame.run(variants);
    const std::size_t end = path.rfind('/'), begin = path.rfind('/', end - 1);
    frame.report(path.substr(begin + 1, end - begin - 1), variants);
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
