// myrialux render: scene in; pictures and numbers out.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "commands.h"
#include "myrialux/base/output_file.h"
#include "myrialux/base/parallel.h"
#include "myrialux/pipeline/pipeline.h"
#include "scene_options.h"
#include "values.h"
#include "words.h"

namespace myrialux::app {
namespace {

struct RenderOptions {
  SceneOptions scene;
  std::vector<std::string> outputs;
  std::string method = RenderParams{}.method, size, filter, aov, stats, direct = "vpl", residual = "on";
  std::string memory_limit, clusters;
  double exposure = 0;
  RenderParams params;
};

void add_arguments(CLI::App& command, RenderOptions& o);
RenderParams to_params(const RenderOptions& o, const Definitions& definitions);
/// Everything that can be refused before work starts.
void check_outputs(const RenderOptions& o);
std::vector<std::string> summary(const RenderStats& stats, double write_s);
std::string footer();
std::vector<std::string> methods_that_keep_to_error();

void run(const RenderOptions& o, Session& session) {
  session.reporter = make_reporter(o.scene.progress);
  Reporter& reporter = *session.reporter;
  const Definitions definitions = sort_definitions(o.scene);
  RenderParams params = to_params(o, definitions);
  find_method(params.method);
  check_outputs(o);

  const ThreadScope threads(params.threads);
  Stopwatch clock;
  ProcessStopwatch cpu;
  const Scene scene = open_scene(o.scene, definitions, reporter);
  const double load_s = clock.lap(), load_cpu_s = cpu.lap();
  RenderOutput result = render(scene, params, reporter);
  reporter.warn(result.stats.warnings);
  throw_if_cancelled();

  // From here on everything is written, whatever happens to be pressed.
  clock.lap(), cpu.lap();
  reporter.stage("write", 0, "");
  result.metadata["myrialux.command"] = session.command_line;
  std::vector<std::string> written;
  for (const std::string& path : o.outputs) {
    write_picture(result.picture, path, result.metadata, static_cast<float>(o.exposure));
    written.push_back(absolute_path(path));
  }
  RenderStats& stats = result.stats;
  const double write_s = clock.lap(), write_cpu_s = cpu.lap();
  stats.memory.peak_rss = peak_rss_bytes();
  stats.time_s["load"] = load_s;
  stats.time_s["film"] += write_s;
  stats.time_s["total"] += load_s + write_s;
  stats.cpu_s["load"] = load_cpu_s, stats.cpu_s["film"] += write_cpu_s;
  stats.cpu_s["total"] += load_cpu_s + write_cpu_s;
  if (o.stats == "-")
    fmt::print("{}", to_json(stats));
  else if (!o.stats.empty()) {
    write_text_file(o.stats, to_json(stats));
    written.push_back(absolute_path(o.stats));
  }
  reporter.done(summary(stats, write_s), written);
}

}  // namespace

void add_render(CLI::App& app, Session& session) {
  CLI::App& command = *app.add_subcommand("render", "Render a scene to a picture");
  auto options = std::make_shared<RenderOptions>();
  add_arguments(command, *options);
  command.footer(footer);
  command.callback([options, &session] { session.run = [options, &session] { run(*options, session); }; });
}

namespace {

void add_arguments(CLI::App& c, RenderOptions& o) {
  add_scene_arguments(c, o.scene);
  add_list(c, "-o,--output", o.outputs, "FILE",
           "Picture to write: .exr (linear, float, all\nlayers), .png .jpg (sRGB curve) or .hdr;\nmay be repeated");
  c.get_option("-o")->required();
  RenderParams& p = o.params;
  c.add_option("--method", o.method, "How light is gathered; default lbamc (list below)")->option_text("NAME");
  c.add_option("--size", o.size, "Pixels; default: the scene's")->option_text("WxH");
  c.add_option("--spp", p.spp, "Camera samples a pixel and pass; default 4\n(method path: the scene's)")
      ->check(whole_number(1, 1 << 20))
      ->option_text("N");
  c.add_option("--vpls", p.n_lights, fmt::format("Virtual lights a pass; default {}", p.n_lights))
      ->check(whole_number(1, std::int64_t{1} << 31))
      ->option_text("N");
  c.add_option(
       "--clusters", o.clusters,
       fmt::format("Light clusters a slice; default {}\n(mdlc: pairs of clusters a pixel; {}).\nauto: as many as "
                   "pay off: the first pass\nestimates how much it errs because it has these\nlights and no "
                   "others and because clusters stand\nfor them, and takes the number from which many\npasses "
                   "gain most in their time",
                   MethodInfo{}.n_clusters, find_method("mdlc").n_clusters))
      ->check(whole_number_or("auto", 1, 1 << 24))
      ->option_text("N|auto");
  c.add_option("--visibility-error", p.visibility_error,
               fmt::format("How far copied visibility may take the picture\nfrom all shadow rays traced: root mean "
                           "square over\npixels, over the mean radiance. Slices traced\nwhole set how much is copied, "
                           "random true rays\ncheck it (stats: visibility.meter). 0: trace all.\nDefault {}; "
                           "methods: {}",
                           MethodParams{}.visibility_error, fmt::join(methods_that_keep_to_error(), ", ")))
      ->check(number(0, 1))
      ->option_text("FRACTION");
  c.add_option("--passes", p.passes, "Passes to average, each with its own samples\nand lights; default 1")
      ->check(whole_number(1, (1 << 24) - 1))
      ->option_text("N");
  c.add_option(
       "--max-depth", p.max_depth,
       "Edges of a path from camera to lamp: 1 lamps\nseen, 2 direct light, ...; -1 no limit.\nDefault: the scene's")
      ->check([](const std::string& text) {
        return text == "-1" ? std::string()
                            : whole_number(1, 1 << 20)(text) + (text == "0" ? " (or -1: no limit)" : "");
      })
      ->option_text("N");
  c.add_option("--direct", o.direct,
               "Direct light: vpl (by virtual lights) or sampled\n(shadow rays to the lamps at each receiver;\nnumber: "
               "-D direct.samples=). Default vpl")
      ->check(one_of({"vpl", "sampled"}))
      ->option_text("HOW");
  c.add_option("--clamp", p.clamp,
               fmt::format("Distance below which a virtual light grows no\nbrighter, as a fraction of the scene's "
                           "radius;\n0 = off. Default {}",
                           p.clamp))
      ->check(number(0, 10))
      ->option_text("FRACTION");
  c.add_option("--clamp-distance", p.clamp_distance, "The same distance in scene units; in place of\n--clamp")
      ->check(number(0, 1e30, "scene units"))
      ->excludes("--clamp")
      ->option_text("LENGTH");
  c.add_option("--residual", o.residual,
               "on: add by rays what virtual lights cannot\ncarry (clamped light, caustics). Default on")
      ->check(one_of({"on", "off"}))
      ->option_text("ON|OFF");
  c.add_option("--lights", p.lights_file, "Take the virtual lights from a PLY file\n(myrialux lights) instead")
      ->option_text("FILE");
  add_camera_arguments(c, o.scene);
  c.add_option("--filter", o.filter,
               "Pixel filter: " + fmt::format("{}", fmt::join(filter_names(), ", ")) + ".\nDefault: the scene's")
      ->check(one_of(filter_names()))
      ->option_text("NAME");
  c.add_option("--exposure", o.exposure, "Stops added in .png and .jpg; default 0")
      ->check(number(-100, 100, "stops"))
      ->option_text("STOPS");
  c.add_option(
       "--aov", o.aov,
       "Layers beside the colours in .exr, by commas:\nalbedo,normal,depth,slice,cut,visibility,error.\nDefault: all")
      ->option_text("LIST");
  c.add_option("--stats", o.stats, "Write counts, times and parameters as JSON;\n- = to stdout")->option_text("FILE");
  c.add_option("--seed", p.seed, "Another seed, another noise; default 0")
      ->check(whole_number(0, std::numeric_limits<std::int64_t>::max()))
      ->option_text("N");
  c.add_option("--memory-limit", o.memory_limit,
               "Never take more memory: a frame that would is\nrefused before work starts, with settings that\nfit. "
               "Bytes, or with K, M, G, T")
      ->option_text("BYTES");
  add_progress_argument(c, o.scene);
}

RenderParams to_params(const RenderOptions& o, const Definitions& definitions) {
  RenderParams p = o.params;
  p.method = o.method;
  p.auto_clusters = o.clusters == "auto";
  if (!o.clusters.empty() && !p.auto_clusters) p.n_clusters = static_cast<std::uint32_t>(std::stoul(o.clusters));
  if (!o.size.empty()) {
    const Size size = parse_size("--size", o.size);
    p.width = size.width, p.height = size.height;
  }
  p.direct = o.direct == "vpl" ? RenderParams::Direct::vpl : RenderParams::Direct::sampled;
  p.residual = o.residual == "on";
  p.has_filter = !o.filter.empty();
  if (p.has_filter) p.filter = named_filter(o.filter);
  if (!o.aov.empty())
    p.aovs = parse_names("--aov", o.aov, {"albedo", "normal", "depth", "slice", "cut", "visibility", "error"});
  if (!o.memory_limit.empty()) p.memory_limit = parse_bytes("--memory-limit", o.memory_limit);
  p.threads = thread_count(o.scene);
  p.extra = definitions.renderer;
  return p;
}

void check_outputs(const RenderOptions& o) {
  std::vector<std::string> all;
  for (const std::string& path : o.outputs) {
    picture_extension(path);
    all.push_back(path);
  }
  if (!o.stats.empty() && o.stats != "-") all.push_back(o.stats);
  std::error_code none;
  for (std::size_t k = 0; k < all.size(); ++k) {
    require_writable(all[k]);
    for (const std::string& input : {o.scene.path, o.params.lights_file})
      if (std::filesystem::equivalent(all[k], input, none))
        throw Error(ErrorKind::usage, all[k] + ": is read by this command; write to another file");
    for (std::size_t other = 0; other < k; ++other)
      if (absolute_path(all[other]) == absolute_path(all[k]))
        throw Error(ErrorKind::usage, all[k] + ": named twice as output");
  }
  if (!o.params.lights_file.empty() && !std::filesystem::exists(o.params.lights_file, none))
    throw Error(ErrorKind::input, o.params.lights_file + ": no such file; make it with: myrialux lights " +
                                      o.scene.path + " -o " + o.params.lights_file);
}

/// Counts, and the error that copies added where it was measured.
std::string visibility_words(const RenderStats::Visibility& v) {
  std::string words =
      fmt::format("visibility: {} of {} entries traced ({:.1f} %)", count_words(static_cast<double>(v.traced)),
                  count_words(static_cast<double>(v.entries)),
                  100 * static_cast<double>(v.traced) / static_cast<double>(v.entries));
  if (v.meter.rays == 0) return words;
  const MeterErrors e = meter_errors(v.meter);
  return words + fmt::format("; error by the others {}, {:.2f} % of all bits wrong", error_words(e), 100 * e.wrong);
}

std::vector<std::string> summary(const RenderStats& s, double write_s) {
  std::vector<std::string> lines;
  const double passes = static_cast<double>(std::max<std::uint64_t>(1, s.passes));
  const double receivers = static_cast<double>(s.receivers), lights = static_cast<double>(s.virtual_lights);
  std::string times = "time: ";
  double gather_s = 0;  // everything between receivers and film
  for (const char* stage : {"load", "build", "receivers", "lights", "choice", "cluster", "visibility", "complete",
                            "shade", "direct", "film", "total"}) {
    const auto it = s.time_s.find(stage);
    if (it == s.time_s.end()) continue;
    const bool is_gather = std::string("cluster visibility complete shade").find(stage) != std::string::npos;
    if (is_gather) gather_s += it->second;
    times += fmt::format("{}{} {}", times.size() > 6 ? ", " : "", stage, duration_words(it->second));
  }
  if (write_s >= 1) times += fmt::format(" (writing files {})", duration_words(write_s));
  lines.push_back(times);
  if (s.visibility.entries > 0) lines.push_back(visibility_words(s.visibility));
  if (s.virtual_lights > 0 && gather_s > 0)
    lines.push_back(fmt::format("speed: {}, {} receivers x {} virtual lights{}: {} pairs/s", s.method,
                                count_words(receivers / passes), count_words(lights / passes),
                                s.passes > 1 ? fmt::format(" x {} passes", s.passes) : "",
                                count_words(receivers * lights / passes / gather_s)));
  else if (s.rays.camera > 0 && gather_s > 0)
    lines.push_back(fmt::format("speed: {}, {} camera rays/s", s.method,
                                count_words(static_cast<double>(s.rays.camera) / gather_s)));
  const auto residual = s.parameters.find("myrialux.residual");
  if (s.clamped_energy_fraction > 0.001 && residual != s.parameters.end() && residual->second == "off")
    lines.push_back(fmt::format("clamping took away {:.1f} % of the light; --residual on adds it back",
                                100 * s.clamped_energy_fraction));
  lines.push_back("memory: " + bytes_words(s.memory.peak_rss) + " at most");
  return lines;
}

std::vector<std::string> methods_that_keep_to_error() {
  std::vector<std::string> names;
  for (const MethodInfo& m : all_methods())
    if (m.keeps_to_error) names.push_back(m.name);
  return names;
}

std::string footer() {
  std::string text = R"(Examples:
  myrialux render room.xml -o room.exr
  myrialux render room.xml -o room.exr -o room.png --exposure 0.5 --size 1280x720 --spp 16 --vpls 200000
  myrialux render room.xml -o quick.png --size 320x180 --vpls 20000 --clusters 250
  myrialux render room.xml -o truth.exr --method path --spp 1024
  myrialux render chair.obj -o chair.png --look-at 0,1,4,0,0.5,0 --fov 40
  myrialux render room.xml -o a.exr -D bamc.alpha=0.05 --passes 4 --stats a.json --progress json

Methods:
)";
  for (const MethodInfo& m : all_methods()) text += fmt::format("  {:<26} {}\n", m.name, m.summary);
  text += "\n" + definition_help();
  text += R"(
Exit codes: 0 done; 2 bad usage; 3 bad scene or file; 4 memory limit; 5 output not writable; 130 interrupted.
Pictures appear whole or not at all. Ctrl-C stops without leaving one; a second Ctrl-C stops at once.)";
  return text;
}

}  // namespace
}  // namespace myrialux::app
