// myrialux bench: methods x budgets x scenes on the same receivers and lights, against brute force on these lights.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "bench_page.h"
#include "bench_records.h"
#include "commands.h"
#include "myrialux/base/output_file.h"
#include "myrialux/base/parallel.h"
#include "myrialux/kernels/isa.h"
#include "myrialux/pipeline/shared_frame.h"
#include "scene_options.h"
#include "values.h"
#include "words.h"

namespace myrialux::app {
namespace {

namespace fs = std::filesystem;
constexpr const char* kReference = "brute-force";

struct BenchOptions {
  SceneOptions scene;  ///< its path is set for one scene after another
  std::vector<std::string> scenes;
  std::string methods = "slice-lightcuts,bamc", budgets = "0.25,0.5,1,2", size = "640x360", folder;
  int repeats = 3;
  bool page = true;
  SharedFrameParams frame;
};

/// Methods and budgets of a bench, and the name of each scene.
struct Plan {
  std::vector<std::string> methods, names;
  std::vector<double> budgets;
  std::vector<Definitions> definitions;
};

void add_arguments(CLI::App& command, BenchOptions& o);
Plan make_plan(BenchOptions& o);
nlohmann::ordered_json config_of(const BenchOptions& o);
void run_scene(const BenchOptions& o, const Plan& plan, std::size_t scene, BenchFolder& folder, Reporter& reporter);
void write_results(const BenchOptions& o, const BenchFolder& folder, Reporter& reporter);
std::string footer();

void run(BenchOptions& o, Session& session) {
  session.reporter = make_reporter(o.scene.progress);
  Reporter& reporter = *session.reporter;
  const Plan plan = make_plan(o);
  BenchFolder folder(o.folder, config_of(o));
  if (!folder.records().empty())
    reporter.note(fmt::format("{} runs are in {} already; going on", folder.records().size(), o.folder));
  const ThreadScope threads(thread_count(o.scene));
  for (std::size_t s = 0; s < plan.names.size(); ++s) run_scene(o, plan, s, folder, reporter);
  write_results(o, folder, reporter);
}

}  // namespace

void add_bench(CLI::App& app, Session& session) {
  CLI::App& command = *app.add_subcommand("bench", "Compare methods: error over time on the same lights");
  auto options = std::make_shared<BenchOptions>();
  add_arguments(command, *options);
  command.footer(footer);
  command.callback([options, &session] { session.run = [options, &session] { run(*options, session); }; });
}

namespace {

void add_arguments(CLI::App& c, BenchOptions& o) {
  c.add_option("SCENE", o.scenes, "Scene files: Mitsuba .xml or Wavefront .obj")->required()->option_text("...");
  c.add_option("-o,--output", o.folder, "Folder for pictures, tables and page; a bench that\nwas stopped goes on")
      ->required()
      ->option_text("DIR");
  c.add_option("--methods", o.methods, fmt::format("By commas; all: every one. Default\n{}", o.methods))
      ->option_text("LIST");
  c.add_option("--budgets", o.budgets,
               fmt::format("Efforts as multiples of each method's defaults:\nclusters times it, error thresholds over "
                           "it.\nDefault {}",
                           o.budgets))
      ->option_text("LIST");
  c.add_option("--repeats", o.repeats, "Runs of each, for times; default 3")
      ->check(whole_number(1, 1000))
      ->option_text("N");
  c.add_option("--size", o.size, "Pixels; default " + o.size)->option_text("WxH");
  c.add_option("--spp", o.frame.spp, "Camera samples a pixel; default 4")
      ->check(whole_number(1, 1 << 12))
      ->option_text("N");
  c.add_option("--vpls", o.frame.n_lights, fmt::format("Virtual lights; default {}", o.frame.n_lights))
      ->check(whole_number(1, std::int64_t{1} << 31))
      ->option_text("N");
  c.add_option("--clusters", o.frame.n_clusters,
               fmt::format("Light clusters at budget 1; default {}\n(mdlc: {}, at every budget)",
                           MethodInfo{}.n_clusters, find_method("mdlc").n_clusters))
      ->check(whole_number(1, 1 << 24))
      ->option_text("N");
  c.add_option("--clamp", o.frame.clamp, "As for render; default 0.02")->check(number(0, 10))->option_text("FRACTION");
  c.add_option("--seed", o.frame.seed, "Other samples and lights; default 0")
      ->check(whole_number(0, std::numeric_limits<std::int64_t>::max()))
      ->option_text("N");
  c.add_flag("!--no-page", o.page, "Write tables only: needs no Python");
  add_list(c, "-D,--define", o.scene.definitions, "KEY=VALUE",
           "A key of the renderer, for all methods (render\n--help lists them); may be repeated");
  c.add_option("--threads", o.scene.threads,
               "Threads; 0 = all this process may use.\nDefault: $MYRIALUX_THREADS, else 0")
      ->envname("MYRIALUX_THREADS")
      ->check(whole_number(0, 4096))
      ->option_text("N");
  add_progress_argument(c, o.scene);
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    parts.push_back(text.substr(at, comma - at));
    at = comma + 1;
  }
  return parts;
}

std::vector<double> parse_budgets(const std::string& text) {
  std::vector<double> budgets;
  for (const std::string& part : split(text)) {
    char* end = nullptr;
    const double value = std::strtod(part.c_str(), &end);
    if (part.empty() || *end != 0 || !(value > 0) || value > 1e6)
      throw Error(ErrorKind::usage,
                  fmt::format("--budgets {}: allowed are numbers above 0 by commas, for example 0.25,0.5,1,2", text));
    budgets.push_back(value);
  }
  std::sort(budgets.begin(), budgets.end());
  budgets.erase(std::unique(budgets.begin(), budgets.end()), budgets.end());
  return budgets;
}

std::vector<std::string> parse_methods(const std::string& text) {
  std::vector<std::string> methods;
  for (const MethodInfo& m : all_methods())
    if (text == "all" && m.render && m.name != kReference) methods.push_back(m.name);
  if (!methods.empty()) return methods;
  for (const std::string& name : split(text)) {
    if (!find_method(name).render || name == kReference)
      throw Error(ErrorKind::usage, fmt::format("--methods {}: {} {}; leave it out", text, name,
                                                name == kReference ? "is the reference of every bench"
                                                                   : "has no virtual lights to be compared on"));
    if (std::find(methods.begin(), methods.end(), name) == methods.end()) methods.push_back(name);
  }
  return methods;
}

/// Folder of a scene.xml, stem of others; numbered where that is not unique.
std::vector<std::string> names_of(const std::vector<std::string>& scenes) {
  std::vector<std::string> names;
  for (const std::string& scene : scenes) {
    const fs::path path(absolute_path(scene));
    const std::string base = path.stem() == "scene" ? path.parent_path().filename().string() : path.stem().string();
    std::string name = base;
    for (int k = 2; std::find(names.begin(), names.end(), name) != names.end(); ++k)
      name = fmt::format("{}-{}", base, k);
    names.push_back(name);
  }
  return names;
}

Plan make_plan(BenchOptions& o) {
  Plan plan{.methods = parse_methods(o.methods),
            .names = names_of(o.scenes),
            .budgets = parse_budgets(o.budgets),
            .definitions = {}};
  const Size size = parse_size("--size", o.size);
  o.frame.width = size.width, o.frame.height = size.height;
  for (const std::string& path : o.scenes) {
    o.scene.path = path;
    plan.definitions.push_back(sort_definitions(o.scene));
  }
  o.frame.extra = plan.definitions.front().renderer;
  return plan;
}

nlohmann::ordered_json config_of(const BenchOptions& o) {
  return {{"version", MYRIALUX_VERSION},
          {"size", o.size},
          {"spp", o.frame.spp},
          {"vpls", o.frame.n_lights},
          {"clusters", o.frame.n_clusters > 0 ? nlohmann::ordered_json(o.frame.n_clusters) : "default"},
          {"clamp", o.frame.clamp},
          {"seed", o.frame.seed},
          {"defines", o.scene.definitions},
          {"threads", thread_count(o.scene)},
          {"isa", isa_name()}};
}

/// What a method tells while it runs is too much here.
Progress& silent() {
  static Progress progress;
  return progress;
}

void save_picture(const BenchOptions& o, const std::string& path, const std::vector<Rgb>& pixels,
                  const Metadata& metadata) {
  Picture picture;
  picture.width = o.frame.width, picture.height = o.frame.height;
  Picture::Layer& layer = picture.add_layer("", {"R", "G", "B"});
  for (std::size_t i = 0; i < pixels.size(); ++i)
    layer.pixels[3 * i] = pixels[i].r, layer.pixels[3 * i + 1] = pixels[i].g, layer.pixels[3 * i + 2] = pixels[i].b;
  write_picture(picture, path, metadata);
}

BenchRecord record_of(const FrameRun& run) {
  BenchRecord r;
  r.seconds = run.seconds, r.cpu_seconds = run.cpu_seconds;
  r.shadow_rays = run.stats.rays.shadow;
  r.entries = run.stats.visibility.entries, r.traced = run.stats.visibility.traced;
  r.bytes = run.stats.memory.slices_peak;
  r.clusters_mean = run.stats.clusters_mean;
  r.rmse = r.relative_rmse = r.relative_rmse_without_worst = r.relmse = r.bias = r.flip =
      std::numeric_limits<double>::quiet_NaN();
  return r;
}

struct Job {
  std::string method;
  double budget = 1;
  int repeat = 0;
};

/// The runs of one scene that are not in the folder yet: every method at every budget, then all once more.
std::vector<Job> missing_jobs(const BenchOptions& o, const Plan& plan, const std::string& scene,
                              const BenchFolder& folder) {
  std::vector<Job> jobs;
  if (!folder.has(scene, kReference, 1, 0)) jobs.push_back({kReference, 1, 0});
  for (int repeat = 0; repeat < o.repeats; ++repeat)
    for (const double budget : plan.budgets)
      for (const std::string& method : plan.methods)
        if (!folder.has(scene, method, budget, repeat)) jobs.push_back({method, budget, repeat});
  return jobs;
}

void run_scene(const BenchOptions& o, const Plan& plan, std::size_t s, BenchFolder& folder, Reporter& reporter) {
  const std::string& name = plan.names[s];
  const std::vector<Job> jobs = missing_jobs(o, plan, name, folder);
  if (jobs.empty()) return;
  reporter.note(fmt::format("{}: {} of {} scenes", name, s + 1, plan.names.size()));
  SceneOptions options = o.scene;
  options.path = o.scenes[s];
  const Scene scene = open_scene(options, plan.definitions[s], reporter);
  const SharedFrame frame(scene, o.frame, reporter);
  std::error_code error;
  fs::create_directories(folder.file(name), error);

  std::vector<Rgb> reference;
  if (folder.has(name, kReference, 1, 0)) reference = read_pixels(folder.file(name + "/" + kReference + ".exr"));
  reporter.stage(name, jobs.size(), "runs");
  for (const Job& job : jobs) {
    const FrameRun run = frame.run(job.method, job.budget, silent());
    throw_if_cancelled();
    BenchRecord record = record_of(run);
    record.scene = name, record.method = job.method, record.budget = job.budget, record.repeat = job.repeat;
    record.knob = knob_at(job.method, job.budget, o.frame);
    if (job.method == kReference) {
      reference = run.pixels;
      record.picture = fmt::format("{}/{}.exr", name, kReference);
    } else {
      const ErrorMeasures e = image_errors(reference, run.pixels).luminance;
      record.rmse = e.rmse, record.relative_rmse = e.relative_rmse, record.relmse = e.relmse, record.bias = e.bias;
      record.relative_rmse_without_worst = e.relative_rmse_without_worst;
      record.picture = fmt::format("{}/{}-{}.exr", name, job.method, job.budget);
    }
    if (job.repeat == 0)
      save_picture(o, folder.file(record.picture), run.pixels,
                   {{"myrialux.method", job.method}, {"myrialux.bench_knob", record.knob}});
    folder.add(record);
    reporter.advance(1);
  }
  reporter.end_stage();
}

void write_tables(const BenchFolder& folder, const std::vector<BenchResult>& results) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const BenchResult& r : results) list.push_back(to_json(r));
  write_file(folder.file("results.csv"), to_csv(results));
  write_file(folder.file("results.json"),
             nlohmann::ordered_json{{"config", folder.config()}, {"results", list}}.dump(1) + "\n");
}

void write_results(const BenchOptions& o, const BenchFolder& folder, Reporter& reporter) {
  std::vector<BenchResult> results = summarise(folder.records());
  std::vector<std::string> written = {absolute_path(folder.file("results.csv")),
                                      absolute_path(folder.file("results.json"))};
  write_tables(folder, results);  // they stand even where the page cannot be made
  if (o.page) {
    reporter.stage("flip, page", 0, "");
    write_bench_page(folder, results, folder.file("index.html"));
    reporter.end_stage();
    write_tables(folder, results);
    written.push_back(absolute_path(folder.file("index.html")));
  }
  std::vector<std::string> lines;
  lines.reserve(results.size());
  for (const BenchResult& r : results)
    lines.push_back(fmt::format("{:<16} {:<32} {:>9} {:>10} rays{}", r.first.scene,
                                r.first.method + (r.first.knob.empty() ? "" : " " + r.first.knob),
                                duration_words(r.seconds), count_words(static_cast<double>(r.first.shadow_rays)),
                                std::isnan(r.first.relative_rmse)
                                    ? std::string()
                                    : fmt::format("   error {:.3g} %", 100 * r.first.relative_rmse)));
  reporter.done(lines, written);
}

std::string footer() {
  std::string text = R"(Examples:
  myrialux bench room.xml -o bench
  myrialux bench room.xml hall.xml -o bench --methods all --budgets 0.5,1,2 --repeats 5
  myrialux bench room.xml -o quick --size 160x90 --spp 1 --vpls 10000 --repeats 1 --no-page

All methods get the same receivers and virtual lights, in one process, and take turns. The truth is brute-force on
these lights: every receiver, every light, every ray (at 640x360x4 with 100 k lights some minutes a scene). Only
light from virtual lights counts. Budget 1 is each method's default; what the budget turns:
)";
  for (const MethodInfo& m : all_methods())
    if (m.render && m.name != kReference)
      text += fmt::format("  {:<26} {}\n", m.name,
                          m.knob == "clusters" ? "--clusters times budget" : m.knob + " over budget");
  text += R"(
DIR holds config.json, runs.jsonl (a line a run, kept at once: stop and start as you like), pictures, results.csv,
results.json and index.html: error over time and over shadow rays, pictures with a slider, error maps.)";
  return text;
}

}  // namespace
}  // namespace myrialux::app
