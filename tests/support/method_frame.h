// Receivers and lights of a small frame, traced once, for methods to be run on; and the distance of their pictures.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "myrialux/methods/render.h"
#include "support/build_scene.h"

namespace myrialux::test {

struct MethodFrame {
  Scene scene;
  Tracer tracer;
  Emitters emitters;
  World world;
  Receivers receivers;
  VirtualLights lights;
  MethodParams params;

  /// A picture of size x size pixels, one sample each.
  MethodFrame(Scene s, std::uint64_t n_lights, int size)
      : scene(std::move(s)),
        tracer(scene),
        emitters(scene, tracer.bounds()),
        world{.scene = scene, .tracer = tracer, .emitters = emitters, .max_depth = -1} {
    Progress silent;
    receivers = trace_receivers(world, {.width = size, .height = size, .spp = 1, .key = {3}}, silent).receivers;
    lights = trace_lights(world, {.n_lights = n_lights, .direct = true, .key = {3}}, silent).lights;
    params.cut.clamp_distance = 0.05f;
    params.key = params.tree.key = {3};
  }
  MethodFrame(const MethodFrame&) = delete;  // `world` refers to the members
  MethodResult run(const char* method, RenderStats& stats) const {
    Progress silent;
    const float radius = 0.5f * scene.bounds().diagonal();
    return find_method(method).render({world, receivers, lights, radius}, params, silent, stats);
  }
  MethodResult run(const char* method) const {
    RenderStats stats;
    return run(method, stats);
  }
};

/// Root mean square difference over the mean of the reference, luminance.
inline double relative_rmse(const std::vector<Rgb>& reference, const std::vector<Rgb>& image) {
  double squares = 0, sum = 0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const double d = static_cast<double>(luminance(image[i]) - luminance(reference[i]));
    squares += d * d, sum += static_cast<double>(luminance(reference[i]));
  }
  const double n = static_cast<double>(reference.size());
  return std::sqrt(squares / n) / (sum / n);
}

}  // namespace myrialux::test
