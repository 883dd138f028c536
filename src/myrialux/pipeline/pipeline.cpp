// One frame: receivers and lights of each pass, the method between them, local rays, film.
#include "myrialux/pipeline/pipeline.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "myrialux/base/clock.h"
#include "myrialux/base/parallel.h"
#include "myrialux/kernels/isa.h"
#include "myrialux/pipeline/frame_state.h"
#include "myrialux/pipeline/local_light.h"
#include "myrialux/pipeline/parameters.h"
#include "myrialux/reference/path_tracer.h"
#include "myrialux/scene/load.h"

namespace myrialux {
namespace {

/// RenderParams with everything the scene decides filled in.
struct Settings {
  RenderParams render;
  TunedParams tuned;
  Filter filter;
  int max_depth = -1;
};
Settings settle(const Scene& scene, const RenderParams& params);

/// Predicted bytes of a many-light pass. @throws Error (limit) naming what to make smaller
void check_memory(const Settings& settings, std::uint64_t scene_bytes);

void render_pass(const World& world, const Settings& settings, int pass, FrameState& frame, Progress& progress,
                 RenderStats& stats);
void render_path(const World& world, const Settings& settings, FrameState& frame, Progress& progress,
                 RenderStats& stats);

void add_light_stats_means(RenderStats& stats);
Metadata describe(const Scene& scene, const Settings& settings, const RenderStats& stats);

}  // namespace

RenderOutput render(const Scene& scene, const RenderParams& params, Progress& progress) {
  Stopwatch total, wall;
  const MethodInfo& method = find_method(params.method);
  const Settings settings = settle(scene, params);
  require_renderable(scene);
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
  stats.time_s["build"] = wall.lap();
  stats.memory.scene = tracer.memory_bytes();

  FrameState frame(settings.render.width, settings.render.height, settings.filter);
  if (!method.render) {
    render_path(world, settings, frame, progress, stats);
  } else {
    check_memory(settings, stats.memory.scene);
    for (int pass = 0; pass < settings.render.passes; ++pass)
      render_pass(world, settings, pass, frame, progress, stats);
    add_light_stats_means(stats);
  }
  wall.lap();
  progress.stage("film", 0, "");
  output.picture = frame.picture(params.aovs);
  stats.time_s["film"] += wall.lap();

  stats.scene = scene.path, stats.method = params.method, stats.seed = params.seed, stats.threads = n_threads;
  stats.isa = isa_name();
  for (const Diagnostic& d : scene.diagnostics) stats.warnings.push_back(to_string(d));
  stats.time_s["total"] = total.elapsed();
  stats.memory.peak_rss = peak_rss_bytes();
  output.metadata = describe(scene, settings, stats);
  stats.parameters = output.metadata;
  return output;
}

float robust_radius(const Receivers& receivers) {
  if (receivers.size() == 0) return 0;
  Vec3 extent;
  std::vector<float> values(receivers.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = receivers.p[i][axis];
    const std::size_t low = values.size() / 50, high = values.size() - 1 - low;
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(low), values.end());
    const float lower = values[low];
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(high), values.end());
    extent[axis] = values[high] - lower;
  }
  return 0.5f * length(extent);
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
  s.tuned.method.cut.n_clusters = params.n_clusters;
  apply_extra(params.extra, s.tuned);
  return s;
}

void check_memory(const Settings& settings, std::uint64_t scene_bytes) {
  const std::uint64_t limit = settings.render.memory_limit;
  if (limit == 0) return;
  // Bytes a receiver (with its slice order, result and kd-tree keys), a camera sample, a light with its tree.
  constexpr std::uint64_t kReceiver = 200, kSample = 60, kLight = 260, kPixel = 150, kFixed = 100u << 20;
  const std::uint64_t pixels = std::uint64_t(settings.render.width) * std::uint64_t(settings.render.height);
  const std::uint64_t predicted = kFixed + 2 * scene_bytes +
                                  pixels * (kPixel + (kReceiver + kSample) * std::uint64_t(settings.render.spp)) +
                                  settings.render.n_lights * kLight;
  if (predicted <= limit) return;
  throw Error(ErrorKind::limit,
              fmt::format("about {} MiB are needed but --memory-limit allows {} MiB; render fewer samples at once "
                          "(--spp {} --passes {}), fewer lights (--vpls {}) or a smaller picture",
                          predicted >> 20, limit >> 20, std::max(1, settings.render.spp / 4),
                          settings.render.passes * std::min(4, settings.render.spp), settings.render.n_lights / 4));
}

/// Lights of bounce 0 stand for direct light; they go where direct light is sampled at the receivers.
VirtualLights read_or_trace(const World& world, const Settings& settings, RandomKey key, Progress& progress,
                            RenderStats& stats) {
  const bool direct = settings.render.direct == RenderParams::Direct::vpl;
  if (!settings.render.lights_file.empty()) {
    VirtualLights lights = read_lights(settings.render.lights_file, world.scene);
    if (!direct) remove_direct(lights);
    return lights;
  }
  LightResult traced =
      trace_lights(world, {.n_lights = settings.render.n_lights, .direct = direct, .key = key}, progress);
  stats.rays.light += traced.light_rays;
  return std::move(traced.lights);
}

void render_pass(const World& world, const Settings& settings, int pass, FrameState& frame, Progress& progress,
                 RenderStats& stats) {
  const RenderParams& params = settings.render;
  const RandomKey key{params.seed, static_cast<std::uint32_t>(pass)};
  if (params.passes > 1) progress.note(fmt::format("pass {} of {}", pass + 1, params.passes));
  Stopwatch wall;

  // Rows and columns of the light matrix.
  ReceiverResult rows =
      trace_receivers(world, {.width = params.width, .height = params.height, .spp = params.spp, .key = key}, progress);
  const Receivers& receivers = rows.receivers;
  stats.rays.camera += rows.camera_rays;
  stats.receivers += receivers.size();
  stats.time_s["receivers"] += wall.lap();
  const VirtualLights lights = read_or_trace(world, settings, key, progress, stats);
  stats.virtual_lights += lights.size();
  stats.time_s["lights"] += wall.lap();

  // The method: which entries are joined, and how they are summed.
  MethodParams method_params = settings.tuned.method;
  method_params.key = method_params.tree.key = key;
  method_params.cut.clamp_distance = params.clamp * robust_radius(receivers);
  const float scene_radius = 0.5f * world.scene.bounds().diagonal();
  MethodResult result =
      find_method(params.method).render({world, receivers, lights, scene_radius}, method_params, progress, stats);
  wall.lap();

  // What virtual lights leave out, by rays of each receiver's own.
  const bool direct = params.direct == RenderParams::Direct::sampled;
  if (direct || params.residual) {
    const PathCounters counters = add_local_light(world, receivers,
                                                  {.direct = direct,
                                                   .direct_samples = static_cast<int>(settings.tuned.direct_samples),
                                                   .residual = params.residual,
                                                   .clamp_distance = method_params.cut.clamp_distance,
                                                   .key = key},
                                                  result.radiance, progress);
    stats.rays.compensation += counters.closest + counters.occlusion;
    stats.time_s["direct"] += wall.lap();
  }

  // Camera samples: what was seen directly, plus the receiver's light.
  std::vector<Rgb> radiance = std::move(rows.samples.emission);
  parallel_for(
      receivers.size(), [&](std::size_t i) { radiance[receivers.sample[i]] += receivers.beta[i] * result.radiance[i]; },
      4096);
  frame.add_pass(rows.samples, receivers, radiance, result);
  stats.time_s["film"] += wall.lap();
  ++stats.passes;
  if (rows.inside_walls * 10 > rows.samples.size() * 9 && pass == 0)
    stats.warnings.push_back(
        "nearly all camera rays meet the inner side of a one-sided surface: the camera stands inside a wall or object; "
        "move it (--look-at) or make the material two-sided");
}

void render_path(const World& world, const Settings& settings, FrameState& frame, Progress& progress,
                 RenderStats& stats) {
  // A pass holds few samples a pixel, so that memory does not grow with --spp.
  constexpr int kSamplesAtOnce = 16;
  const RenderParams& params = settings.render;
  Stopwatch wall;
  std::uint32_t pass = 0;
  for (int left = params.passes * params.spp; left > 0; left -= kSamplesAtOnce, ++pass) {
    const PathSamples paths = trace_paths(world,
                                          {.width = params.width,
                                           .height = params.height,
                                           .spp = std::min(left, kSamplesAtOnce),
                                           .key = {params.seed, pass}},
                                          progress);
    stats.rays.camera += paths.rays.closest;
    stats.rays.shadow += paths.rays.occlusion;
    stats.time_s["shade"] += wall.lap();
    frame.add_pass(paths.samples, {}, paths.radiance, {});
    stats.time_s["film"] += wall.lap();
    ++stats.passes;
  }
}

/// Sums over passes that stand for a mean.
void add_light_stats_means(RenderStats& stats) {
  const double n = static_cast<double>(std::max<std::uint64_t>(1, stats.passes));
  stats.clusters_mean /= n;
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
  if (p.method != "path") {
    m["myrialux.vpls"] = std::to_string(p.n_lights);
    m["myrialux.clusters"] = std::to_string(p.n_clusters);
    m["myrialux.direct"] = p.direct == RenderParams::Direct::vpl ? "vpl" : "sampled";
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
