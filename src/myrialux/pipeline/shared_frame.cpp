// Receivers and lights as render() traces them in its first pass; methods by the registry.
#include "myrialux/pipeline/shared_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "myrialux/base/clock.h"
#include "myrialux/base/error.h"
#include "myrialux/pipeline/clamp.h"
#include "myrialux/pipeline/parameters.h"
#include "myrialux/scene/load.h"

namespace myrialux {
namespace {

constexpr const char* kClusters = "clusters";

/// Largest cut at budget 1.
std::uint32_t clusters(const MethodInfo& method, const SharedFrameParams& params) {
  return params.n_clusters > 0 ? params.n_clusters : method.n_clusters;
}
/// Parameters of a method at a budget.
TunedParams tuned_at(const MethodInfo& method, double budget, const SharedFrameParams& params);
/// The knob's value at a budget, and whether there is one.
std::string knob_value(const MethodInfo& method, double budget, const SharedFrameParams& params);

}  // namespace

struct SharedFrame::State {
  State(const Scene& scene, const SharedFrameParams& p)
      : params(p),
        tracer(scene),
        emitters(scene, tracer.bounds()),
        world{.scene = scene,
              .tracer = tracer,
              .emitters = emitters,
              .max_depth = scene.max_depth,
              .rr_depth = scene.rr_depth} {
    TunedParams tuned;
    apply_extra(p.extra, tuned);
    world.sharp_alpha = tuned.sharp_alpha;
  }

  SharedFrameParams params;
  Tracer tracer;
  Emitters emitters;
  World world;
  ReceiverResult rows;
  VirtualLights lights;
  float clamp_distance = 0, scene_radius = 0;
};

SharedFrame::SharedFrame(const Scene& scene, const SharedFrameParams& params, Progress& progress) {
  require_renderable(scene);
  progress.stage("build", 0, "");
  state_ = std::make_unique<State>(scene, params);
  const RandomKey key{params.seed, 0};
  state_->rows = trace_receivers(
      state_->world, {.width = params.width, .height = params.height, .spp = params.spp, .key = key}, progress);
  state_->lights =
      trace_lights(state_->world, {.n_lights = params.n_lights, .direct = true, .key = key}, progress).lights;
  state_->clamp_distance = clamp_length(params.clamp, -1, size_points(state_->rows.receivers, params.spp));
  state_->scene_radius = 0.5f * scene.bounds().diagonal();
}

SharedFrame::~SharedFrame() = default;
std::size_t SharedFrame::n_receivers() const { return state_->rows.receivers.size(); }
std::size_t SharedFrame::n_lights() const { return state_->lights.size(); }

FrameRun SharedFrame::run(const std::string& name, double budget, Progress& progress) const {
  const MethodInfo& method = find_method(name);
  if (!method.render) throw Error(ErrorKind::usage, name + ": has no virtual lights, so it cannot be compared on them");
  MethodParams params = tuned_at(method, budget, state_->params).method;
  params.key = params.tree.key = {state_->params.seed, 0};
  params.cut.clamp_distance = state_->clamp_distance;

  FrameRun run;
  const Receivers& receivers = state_->rows.receivers;
  Stopwatch wall;
  ProcessStopwatch cpu;
  const MethodResult result = method.render({.world = state_->world,
                                             .receivers = receivers,
                                             .lights = state_->lights,
                                             .scene_radius = state_->scene_radius,
                                             .spp = state_->params.spp,
                                             .n_samples = state_->rows.samples.size()},
                                            params, progress, run.stats);
  run.seconds = wall.elapsed(), run.cpu_seconds = cpu.elapsed();

  const auto spp = static_cast<std::size_t>(state_->params.spp);
  run.pixels.resize(state_->rows.samples.size() / spp);
  for (std::size_t i = 0; i < receivers.size(); ++i)
    run.pixels[receivers.sample[i] / spp] += receivers.beta[i] * result.radiance[i] * (1 / static_cast<float>(spp));
  run.stats.passes = 1;
  return run;
}

std::string knob_at(const std::string& name, double budget, const SharedFrameParams& params) {
  const MethodInfo& method = find_method(name);
  return method.knob.empty() ? std::string() : method.knob + "=" + knob_value(method, budget, params);
}

namespace {

std::string knob_value(const MethodInfo& method, double budget, const SharedFrameParams& params) {
  if (method.knob == kClusters)
    return std::to_string(std::max<long long>(1, std::llround(budget * static_cast<double>(clusters(method, params)))));
  TunedParams defaults;
  apply_extra(params.extra, defaults);
  for (const ParameterInfo& p : parameter_values(defaults))
    if (p.key == method.knob) return fmt::format("{}", static_cast<float>(std::stod(p.value) / budget));
  MYRIALUX_ASSERT(false);  // a method's knob is a key
  return {};
}

TunedParams tuned_at(const MethodInfo& method, double budget, const SharedFrameParams& params) {
  TunedParams tuned;
  apply_extra(params.extra, tuned);
  tuned.method.cut.n_clusters = clusters(method, params);
  if (method.knob == kClusters)
    tuned.method.cut.n_clusters = static_cast<std::uint32_t>(std::stoul(knob_value(method, budget, params)));
  else if (!method.knob.empty())
    apply_extra({{method.knob, knob_value(method, budget, params)}}, tuned);
  return tuned;
}

}  // namespace
}  // namespace myrialux
