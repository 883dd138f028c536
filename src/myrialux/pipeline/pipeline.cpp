// One frame: receivers and lights of each pass, the method between them, local rays, film.
#include "myrialux/pipeline/pipeline.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/base/process.h"
#include "myrialux/kernels/isa.h"
#include "myrialux/methods/auto_clusters.h"
#include "myrialux/methods/slice_driver.h"
#include "myrialux/pipeline/clamp.h"
#include "myrialux/pipeline/frame_state.h"
#include "myrialux/pipeline/local_light.h"
#include "myrialux/pipeline/memory.h"
#include "myrialux/pipeline/parameters.h"
#include "myrialux/reference/path_tracer.h"
#include "myrialux/scene/load.h"

namespace myrialux {
namespace {

/// The path tracer takes at most so many samples a pixel and pass, so that memory does not grow with --spp.
constexpr int kPathSamplesAtOnce = 16;

/// RenderParams with everything the scene decides filled in.
struct Settings {
  RenderParams render;
  TunedParams tuned;
  Filter filter;
  int max_depth = -1;
  float scene_radius = 0;  ///< of the bounding sphere
};
Settings settle(const Scene& scene, const RenderParams& params);

/// Keeps the promise of RenderParams::memory_limit: predicts before the frame what it will take, and again where a
/// pass has more lights than foreseen.
class MemoryGuard {
 public:
  MemoryGuard(const World& world, const Settings& settings);
  /// Where the method allows it, bands are made small enough first. @throws Error (limit)
  void require();
  void require_for(const VirtualLights& lights);
  const FrameExtent& extent() const { return extent_; }
  std::uint64_t predicted_bytes() const { return std::max(peak_, held_ + frame_bytes(extent_)); }

 private:
  FrameExtent extent_;
  std::uint64_t limit_, held_, peak_;
};

void render_pass(const World& world, const Settings& settings, int pass, MemoryGuard& memory, FrameState& frame,
                 Progress& progress, RenderStats& stats);
void render_pass_in_bands(const World& world, const Settings& settings, int pass, MemoryGuard& memory,
                          FrameState& frame, Progress& progress, RenderStats& stats);
/// Light of all or some rows' receivers. Takes out of `rows` what it has used.
void add_to_frame(const World& world, const Settings& settings, const Method& method, const MethodParams& method_params,
                  const VirtualLights& lights, ReceiverResult& rows, FrameState& frame, Progress& progress,
                  RenderStats& stats);
void render_path(const World& world, const Settings& settings, const FrameExtent& extent, FrameState& frame,
                 Progress& progress, RenderStats& stats);

void add_light_stats_means(RenderStats& stats);
Metadata describe(const Scene& scene, const Settings& settings, const RenderStats& stats);

}  // namespace

RenderOutput render(const Scene& scene, const RenderParams& params, Progress& progress) {
  const Stopwatch total;
  const ProcessStopwatch total_cpu;
  StageClock clock;
  const MethodInfo& method = find_method(params.method);
  const Settings settings = settle(scene, params);
  require_renderable(scene);
  require_able(method, scene,
               {.lights_from_file = !params.lights_file.empty(),
                .auto_clusters = params.auto_clusters,
                .visibility_error = params.visibility_error >= 0});
  const int n_threads = params.threads > 0 ? params.threads : available_threads();
  const ThreadScope threads(n_threads);

  RenderOutput output;
  RenderStats& stats = output.stats;
  stats.clamped_energy_fraction = 0;

  progress.stage("build", 0, "");
  const Tracer tracer(scene);
  const Emitters emitters(scene, tracer.bounds());
  const World world{.scene = scene,
                    .tracer = tracer,
                    .emitters = emitters,
                    .max_depth = settings.max_depth,
                    .rr_depth = scene.rr_depth,
                    .sharp_alpha = settings.tuned.sharp_alpha};
  clock.lap("build", stats);
  stats.memory.scene = tracer.memory_bytes();

  MemoryGuard memory(world, settings);
  memory.require();
  stats.memory.predicted = memory.predicted_bytes();
  FrameState frame(settings.render.width, settings.render.height, settings.filter);
  if (!method.render) {
    render_path(world, settings, memory.extent(), frame, progress, stats);
  } else {
    for (int pass = 0; pass < settings.render.passes; ++pass)
      render_pass(world, settings, pass, memory, frame, progress, stats);
    add_light_stats_means(stats);
  }
  clock.skip();
  progress.stage("film", 0, "");
  output.picture = frame.picture(params.aovs);
  clock.lap("film", stats);

  stats.scene = scene.path, stats.method = params.method, stats.seed = params.seed, stats.threads = n_threads;
  stats.isa = isa_name();
  for (const Diagnostic& d : scene.diagnostics) stats.warnings.push_back(to_string(d));
  stats.time_s["total"] = total.elapsed(), stats.cpu_s["total"] = total_cpu.elapsed();
  stats.memory.peak_rss = peak_rss_bytes();
  output.metadata = describe(scene, settings, stats);
  stats.parameters = output.metadata;
  return output;
}

namespace {

Settings settle(const Scene& scene, const RenderParams& params) {
  Settings s;
  s.render = params;
  if (s.render.width == 0 || s.render.height == 0) {
    s.render.width = scene.film.width, s.render.height = scene.film.height;
  }
  if (s.render.spp == 0) s.render.spp = params.method == "path" ? scene.film.spp : 4;
  s.max_depth = params.max_depth != 0 ? params.max_depth : scene.max_depth;
  s.filter = params.has_filter ? params.filter : scene.film.filter;
  if (s.render.n_clusters == 0) s.render.n_clusters = find_method(params.method).n_clusters;
  s.tuned.method.cut.n_clusters = s.render.n_clusters;
  s.tuned.method.auto_clusters = params.auto_clusters;
  if (params.visibility_error >= 0) s.tuned.method.visibility_error = params.visibility_error;
  apply_extra(params.extra, s.tuned);
  s.scene_radius = 0.5f * scene.bounds().diagonal();
  return s;
}

RandomKey key_of_pass(const RenderParams& params, int pass) { return {params.seed, static_cast<std::uint32_t>(pass)}; }

LightParams light_params(const RenderParams& params, int pass) {
  return {.n_lights = params.n_lights,
          .direct = params.direct == RenderParams::Direct::vpl,
          .key = key_of_pass(params, pass)};
}

MemoryGuard::MemoryGuard(const World& world, const Settings& settings) : limit_(settings.render.memory_limit) {
  const RenderParams& p = settings.render;
  FrameExtent& e = extent_;
  e.has_lights = p.method != "path", e.has_pixel_cuts = p.method == "mdlc";
  e.has_slices = e.has_lights && !e.has_pixel_cuts, e.has_cuts = e.has_lights && p.method != "brute-force";
  e.has_packets = p.method == "lightcuts", e.has_auto_clusters = p.auto_clusters;
  const MethodParams& m = settings.tuned.method;
  e.has_pilot = p.method == "lbamc" || (p.method == "bamc" && m.bamc_guard > 0) ||
                (p.method == "amc" && m.amc_guard > 0) || (p.method == "gauss-jordan" && m.gauss_jordan_guard > 0) ||
                (p.method == "matrix-separation" && m.separation_guard > 0);
  // amc: at most omega of an entry's row takes part in a decomposition in double precision, and its copies.
  // matrix-separation: matrices of floats, and its subspace once the rank is full.
  e.completion_bytes = p.method == "amc" ? 16 : p.method == "matrix-separation" ? 72 : 0;
  e.has_point_tree = p.method.starts_with("illumination-cut");
  e.width = p.width, e.height = p.height, e.passes = p.passes, e.n_threads = allowed_threads();
  e.spp = e.has_lights ? p.spp : std::min(p.spp * p.passes, kPathSamplesAtOnce);
  e.n_clusters = e.has_auto_clusters ? kMostAutoClusters : e.has_cuts ? p.n_clusters : kBruteForceColumns;
  e.slice_rows = settings.tuned.method.slices.max_rows;
  if (p.method == "lightslice") {
    const LightSliceParams& own = settings.tuned.method.lightslice;
    e.slice_rows = lightslice_rows(std::uint64_t(p.width) * std::uint64_t(p.height) * std::uint64_t(p.spp),
                                   own.n_slices, settings.tuned.method.slices.block_rows);
    e.reduced_rows = own.n_slices, e.reduced_dimensions = own.n_dimensions;
  }
  e.has_errors = find_method(p.method).keeps_to_error && m.visibility_error > 0;
  e.n_channels = FrameState::n_channels(p.aovs, e.has_slices && e.has_cuts, e.has_errors);
  std::error_code none;
  if (e.has_lights && p.lights_file.empty()) {
    const LightForecast forecast = forecast_lights(world, light_params(p, 0));
    e.n_lights = forecast.n_lights, e.n_glossy = forecast.n_glossy;
  } else if (e.has_lights) {
    e.n_lights = e.n_glossy = count_lights(p.lights_file);
    e.lights_file_bytes = std::max<std::uintmax_t>(1, std::filesystem::file_size(p.lights_file, none));
  }
  release_freed_memory();
  held_ = resident_bytes(), peak_ = peak_rss_bytes();
  if (find_method(p.method).prepare) e.band_samples = kBandSamples, e.band_rows = p.rows_at_once;
}

void MemoryGuard::require() {
  if (limit_ == 0) return;
  if (extent_.band_samples > 0 && predicted_bytes() > limit_) extent_.band_samples = kSmallBandSamples;
  require_memory(extent_, held_, peak_, limit_);
}

void MemoryGuard::require_for(const VirtualLights& lights) {
  if (lights.size() <= extent_.n_lights && lights.glossy.size() <= extent_.n_glossy) return;
  extent_.n_lights = std::max<std::uint64_t>(extent_.n_lights, lights.size());
  extent_.n_glossy = std::max<std::uint64_t>(extent_.n_glossy, lights.glossy.size());
  require();
}

/// Lights of bounce 0 stand for direct light; they go where direct light is sampled at the receivers.
VirtualLights read_or_trace(const World& world, const Settings& settings, int pass, Progress& progress,
                            RenderStats& stats) {
  const LightParams params = light_params(settings.render, pass);
  VirtualLights lights;
  if (!settings.render.lights_file.empty()) {
    lights = read_lights(settings.render.lights_file, world.scene);
    if (!params.direct) remove_direct(lights);
  } else {
    LightResult traced = trace_lights(world, params, progress);
    stats.rays.light += traced.light_rays;
    lights = std::move(traced.lights);
  }
  stats.virtual_lights += lights.size();
  return lights;
}

ReceiverParams receiver_params(const RenderParams& params, int pass) {
  return {.width = params.width, .height = params.height, .spp = params.spp, .key = key_of_pass(params, pass)};
}

/// The number of clusters that the first pass chose holds for the others, too: it depends on what the scene makes of
/// walks and receivers, not on which they are.
MethodParams params_of_pass(const Settings& settings, int pass, float clamp_distance, const RenderStats& stats) {
  MethodParams params = settings.tuned.method;
  if (stats.clusters_auto.chosen > 0) {
    params.cut.n_clusters = static_cast<std::uint32_t>(stats.clusters_auto.chosen);
    params.auto_clusters = false;
  }
  params.key = params.tree.key = key_of_pass(settings.render, pass);
  params.cut.clamp_distance = clamp_distance;
  return params;
}

std::uint64_t n_samples(const RenderParams& params) {
  return static_cast<std::uint64_t>(params.width) * static_cast<std::uint64_t>(params.height) *
         static_cast<std::uint64_t>(params.spp);
}

/// Counts, and what the camera samples met first, which need not be held any longer.
void add_first_hits(ReceiverResult& rows, FrameState& frame, RenderStats& stats) {
  stats.rays.camera += rows.camera_rays;
  stats.receivers += rows.receivers.size();
  StageClock clock;
  frame.add_first_hits(rows.samples);
  rows.samples.drop_layers();
  clock.lap("film", stats);
}

void warn_inside_walls(std::uint64_t inside_walls, std::uint64_t n_first_hits, RenderStats& stats) {
  if (inside_walls * 10 > n_first_hits * 9)
    stats.warnings.push_back(
        "nearly all camera rays meet the inner side of a one-sided surface: the camera stands inside a wall or object; "
        "move it (--look-at) or make the material two-sided");
}

void render_pass(const World& world, const Settings& settings, int pass, MemoryGuard& memory, FrameState& frame,
                 Progress& progress, RenderStats& stats) {
  const RenderParams& params = settings.render;
  if (params.passes > 1) progress.note(fmt::format("pass {} of {}", pass + 1, params.passes));
  if (rows_at_once(memory.extent()) < params.height)
    return render_pass_in_bands(world, settings, pass, memory, frame, progress, stats);
  StageClock clock;

  // Rows and columns of the light matrix.
  ReceiverResult rows = trace_receivers(world, receiver_params(params, pass), progress);
  clock.lap("receivers", stats);
  add_first_hits(rows, frame, stats);
  clock.skip();
  const VirtualLights lights = read_or_trace(world, settings, pass, progress, stats);
  memory.require_for(lights);
  clock.lap("lights", stats);
  const float clamp = clamp_length(params.clamp, params.clamp_distance, size_points(rows.receivers, params.spp));

  const MethodParams method_params = params_of_pass(settings, pass, clamp, stats);
  add_to_frame(world, settings, find_method(params.method).render, method_params, lights, rows, frame, progress, stats);
  ++stats.passes;
  if (pass == 0) warn_inside_walls(rows.inside_walls, n_samples(params), stats);
}

/// As above, with no more receivers at once than a band of rows of pixels has.
void render_pass_in_bands(const World& world, const Settings& settings, int pass, MemoryGuard& memory,
                          FrameState& frame, Progress& progress, RenderStats& stats) {
  const RenderParams& params = settings.render;
  StageClock clock;
  const VirtualLights lights = read_or_trace(world, settings, pass, progress, stats);
  memory.require_for(lights);
  clock.lap("lights", stats);
  float clamp = params.clamp_distance;
  if (clamp < 0) {
    PathCounters rays;
    const auto points = trace_receiver_positions(world, receiver_params(params, pass), kSizeSamples, rays);
    clamp = clamp_length(params.clamp, -1, points);
    stats.rays.camera += rays.closest;
    clock.lap("receivers", stats);
  }

  const MethodParams method_params = params_of_pass(settings, pass, clamp, stats);
  const Method method =
      find_method(params.method).prepare(world, lights, settings.scene_radius, method_params, progress, stats);
  progress.stage("bands of rows", n_samples(params) / static_cast<std::uint64_t>(params.spp), "pixels");
  Progress silent;
  std::uint64_t inside_walls = 0;
  const int n_rows = rows_at_once(memory.extent());
  for (int y = 0; y < params.height; y += n_rows) {
    const int end = std::min(params.height, y + n_rows);
    clock.skip();
    ReceiverResult rows = trace_receiver_rows(world, receiver_params(params, pass), y, end, silent);
    clock.lap("receivers", stats);
    add_first_hits(rows, frame, stats);
    add_to_frame(world, settings, method, method_params, lights, rows, frame, silent, stats);
    inside_walls += rows.inside_walls;
    progress.advance(static_cast<std::uint64_t>(end - y) * static_cast<std::uint64_t>(params.width));
  }
  ++stats.passes;
  if (pass == 0) warn_inside_walls(inside_walls, n_samples(params), stats);
}

void add_to_frame(const World& world, const Settings& settings, const Method& method, const MethodParams& method_params,
                  const VirtualLights& lights, ReceiverResult& rows, FrameState& frame, Progress& progress,
                  RenderStats& stats) {
  const RenderParams& params = settings.render;
  const Receivers& receivers = rows.receivers;
  StageClock clock;

  // The method: which entries are joined, and how they are summed.
  MethodResult result = method({.world = world,
                                .receivers = receivers,
                                .lights = lights,
                                .scene_radius = settings.scene_radius,
                                .spp = params.spp,
                                .n_samples = rows.samples.size()},
                               method_params, progress, stats);
  clock.skip();

  // What virtual lights leave out, by rays of each receiver's own.
  const bool direct = params.direct == RenderParams::Direct::sampled;
  if (direct || params.residual) {
    const PathCounters counters = add_local_light(world, receivers,
                                                  {.direct = direct,
                                                   .direct_samples = static_cast<int>(settings.tuned.direct_samples),
                                                   .residual = params.residual,
                                                   .clamp_distance = method_params.cut.clamp_distance,
                                                   .key = method_params.key},
                                                  result.radiance, progress);
    stats.rays.compensation += counters.closest + counters.occlusion;
    clock.lap("direct", stats);
  }

  // Camera samples: what was seen directly, plus the receiver's light.
  Array<Rgb> radiance = std::move(rows.samples.emission);
  parallel_for(
      receivers.size(), [&](std::size_t i) { radiance[receivers.sample[i]] += receivers.beta[i] * result.radiance[i]; },
      4096);
  frame.add_radiance(rows.samples, radiance);
  frame.add_slices(receivers, result, params.spp);
  clock.lap("film", stats);
}

void render_path(const World& world, const Settings& settings, const FrameExtent& extent, FrameState& frame,
                 Progress& progress, RenderStats& stats) {
  const RenderParams& params = settings.render;
  StageClock clock;
  std::uint32_t pass = 0;
  for (int left = params.passes * params.spp; left > 0; left -= kPathSamplesAtOnce, ++pass) {
    const ReceiverParams samples{.width = params.width,
                                 .height = params.height,
                                 .spp = std::min(left, kPathSamplesAtOnce),
                                 .key = {params.seed, pass}};
    const auto n_pixels = static_cast<std::uint64_t>(params.width) * static_cast<std::uint64_t>(params.height);
    progress.stage("paths", n_pixels * static_cast<std::uint64_t>(samples.spp), "samples");
    const int n_rows = path_rows_at_once(extent);
    for (int y = 0; y < params.height; y += n_rows) {
      const PathSamples paths = trace_path_rows(world, samples, y, std::min(params.height, y + n_rows), progress);
      stats.rays.camera += paths.rays.closest;
      stats.rays.shadow += paths.rays.occlusion;
      clock.lap("shade", stats);
      frame.add_first_hits(paths.samples);
      frame.add_radiance(paths.samples, paths.radiance);
      clock.lap("film", stats);
    }
    ++stats.passes;
  }
}

/// Sums over passes that stand for a mean.
void add_light_stats_means(RenderStats& stats) {
  const double n = static_cast<double>(std::max<std::uint64_t>(1, stats.passes));
  stats.clusters_mean /= n;
  stats.visibility.meter.divide(n);
  stats.clamped_energy_fraction /= n;
}

Metadata describe(const Scene& scene, const Settings& settings, const RenderStats& stats) {
  const RenderParams& p = settings.render;
  Metadata m;
  m["Software"] = "Myrialux " MYRIALUX_VERSION;
  m["myrialux.version"] = MYRIALUX_VERSION;
  m["myrialux.scene_sha256"] = scene.sha256;
  m["myrialux.method"] = p.method;
  m["myrialux.size"] = fmt::format("{}x{}", p.width, p.height);
  m["myrialux.spp"] = std::to_string(p.spp);
  m["myrialux.seed"] = std::to_string(p.seed);
  m["myrialux.passes"] = std::to_string(p.passes);
  m["myrialux.max_depth"] = std::to_string(settings.max_depth);
  constexpr const char* kFilters[] = {"box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"};
  m["myrialux.filter"] =
      fmt::format("{} {}", kFilters[static_cast<std::size_t>(settings.filter.kind)], settings.filter.radius);
  m["myrialux.camera_to_world"] = fmt::format("{}", fmt::join(scene.camera.to_world.rows(), " "));
  m["myrialux.fov_x_deg"] = fmt::format("{}", scene.camera.fov_x_deg);
  if (scene.camera.aperture_radius > 0) {
    m["myrialux.aperture_radius"] = fmt::format("{}", scene.camera.aperture_radius);
    m["myrialux.focus_distance"] = fmt::format("{}", scene.camera.focus_distance);
  }
  if (scene.camera.moves()) {
    m["myrialux.shutter"] = fmt::format("{} {}", scene.camera.shutter_open, scene.camera.shutter_close);
    std::string& keys = m["myrialux.camera_motion"];
    for (const CameraKey& key : scene.camera.motion)
      keys += fmt::format("{}{}: {}", keys.empty() ? "" : "; ", key.time, fmt::join(key.to_world.rows(), " "));
  }
  if (p.method != "path") {
    m["myrialux.vpls"] = std::to_string(p.n_lights);
    m["myrialux.clusters"] = p.auto_clusters ? "auto" : std::to_string(p.n_clusters);
    if (p.auto_clusters) m["myrialux.clusters_chosen"] = std::to_string(stats.clusters_auto.chosen);
    if (find_method(p.method).keeps_to_error)
      m["myrialux.visibility_error"] = fmt::format("{}", settings.tuned.method.visibility_error);
    m["myrialux.direct"] = p.direct == RenderParams::Direct::vpl ? "vpl" : "sampled";
    if (p.clamp_distance >= 0)
      m["myrialux.clamp_distance"] = fmt::format("{}", p.clamp_distance);
    else
      m["myrialux.clamp"] = fmt::format("{}", p.clamp);
    m["myrialux.residual"] = p.residual ? "on" : "off";
    if (!p.lights_file.empty()) m["myrialux.lights"] = p.lights_file;
    if (stats.visibility.entries > 0)
      m["myrialux.entries_sampled_fraction"] =
          fmt::format("{:.6f}", double(stats.visibility.traced) / double(stats.visibility.entries));
  }
  for (const ParameterInfo& key : parameter_values(settings.tuned)) m["myrialux." + key.key] = key.value;
  return m;
}

}  // namespace
}  // namespace myrialux
