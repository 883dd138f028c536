// Path-traced frames with an error bar for each pixel.
#include "myrialux/reference/path_tracer.h"

#include <cmath>

#include "myrialux/base/parallel.h"

namespace myrialux {
namespace {

/// Largest number of passes up to 16 that divides spp.
int passes_for(int spp) {
  int n = std::min(16, spp);
  while (spp % n != 0) --n;
  return n;
}

/// @param sample of the whole picture; @param k its place in `out`
void trace_sample(const World& world, const ReceiverParams& params, std::size_t sample, std::size_t k, PathSamples& out,
                  PathCounters& rays);

}  // namespace

PathSamples trace_paths(const World& world, const ReceiverParams& params, Progress& progress) {
  const auto n = static_cast<std::uint64_t>(params.width) * static_cast<std::uint64_t>(params.height);
  progress.stage("paths", n * static_cast<std::uint64_t>(params.spp), "samples");
  return trace_path_rows(world, params, 0, params.height, progress);
}

PathSamples trace_path_rows(const World& world, const ReceiverParams& params, int y_begin, int y_end,
                            Progress& progress) {
  PathSamples out;
  out.samples.width = params.width, out.samples.height = params.height, out.samples.spp = params.spp;
  out.samples.first_row = y_begin;
  const auto n_rows = static_cast<std::size_t>(y_end - y_begin);
  const std::size_t per_row = static_cast<std::size_t>(params.width) * static_cast<std::size_t>(params.spp);
  const std::size_t n = per_row * n_rows, first = per_row * static_cast<std::size_t>(y_begin);
  out.samples.position.resize(n), out.samples.emission.resize(n), out.samples.albedo.resize(n);
  out.samples.normal.resize(n), out.samples.depth.resize(n), out.radiance.resize(n);
  std::vector<PathCounters> rays(n_rows);
  parallel_for(n_rows, [&](std::size_t y) {
    for (std::size_t k = y * per_row; k < (y + 1) * per_row; ++k)
      trace_sample(world, params, first + k, k, out, rays[y]);
    progress.advance(per_row);
  });
  for (const PathCounters& r : rays) out.rays += r;
  return out;
}

PathTracerResult render_paths(const World& world, const PathTracerParams& params, Progress& progress) {
  PathTracerResult result;
  result.width = params.width, result.height = params.height, result.n_passes = passes_for(params.spp);
  const auto n_pixels = static_cast<std::size_t>(params.width) * static_cast<std::size_t>(params.height);
  const int spp = params.spp / result.n_passes;
  result.sum_rgb.resize(3 * n_pixels), result.weight.resize(n_pixels), result.variance.resize(3 * n_pixels);
  std::vector<double> mean(3 * n_pixels), squares(3 * n_pixels);  // over passes: mean, sum of squared deviations
  for (int pass = 0; pass < result.n_passes; ++pass) {
    const RandomKey key{params.key.seed, params.key.pass + static_cast<std::uint32_t>(pass)};
    const PathSamples traced =
        trace_paths(world, {.width = params.width, .height = params.height, .spp = spp, .key = key}, progress);
    result.rays += traced.rays;
    std::vector<double> sum(3 * n_pixels), weight(n_pixels);
    accumulate(traced.samples.position, traced.radiance, params.width, params.height, spp, params.filter, sum, weight);
    for (std::size_t i = 0; i < 3 * n_pixels; ++i) {
      result.sum_rgb[i] += sum[i];
      const double value = weight[i / 3] != 0 ? sum[i] / weight[i / 3] : 0, change = value - mean[i];
      mean[i] += change / (pass + 1);
      squares[i] += change * (value - mean[i]);
    }
    for (std::size_t i = 0; i < n_pixels; ++i) result.weight[i] += weight[i];
  }
  if (const double n = result.n_passes; n > 1)
    for (std::size_t i = 0; i < 3 * n_pixels; ++i) result.variance[i] = static_cast<float>(squares[i] / (n * (n - 1)));
  return result;
}

Picture to_picture(const PathTracerResult& result) {
  Picture picture;
  picture.width = result.width, picture.height = result.height;
  std::vector<float>& beauty = picture.add_layer("", {"R", "G", "B"}).pixels;
  for (std::size_t i = 0; i < beauty.size(); ++i)
    beauty[i] = result.weight[i / 3] != 0 ? static_cast<float>(result.sum_rgb[i] / result.weight[i / 3]) : 0;
  std::vector<float>& error = picture.add_layer("stderr", {"R", "G", "B"}).pixels;
  for (std::size_t i = 0; i < error.size(); ++i) error[i] = std::sqrt(result.variance[i]);
  return picture;
}

namespace {

void trace_sample(const World& world, const ReceiverParams& params, std::size_t sample, std::size_t k, PathSamples& out,
                  PathCounters& rays) {
  const auto spp = static_cast<std::size_t>(params.spp);
  const Camera& camera = world.scene.camera;
  const CameraSample drawn =
      camera_sample(camera, params.width, sample / spp, static_cast<int>(sample % spp), params.spp, params.key);
  const Ray ray = camera_ray(camera, params.width, params.height, drawn);
  Rng rng(params.key, Stage::path, sample);
  out.samples.position[k] = drawn.film;
  out.samples.emission[k] = out.samples.albedo[k] = {};
  out.samples.normal[k] = {}, out.samples.depth[k] = kInfinity;
  FirstHit first;
  out.radiance[k] = path_radiance(world, ray, 0, rng, rays, &first);
  if (!first.any) return;
  out.samples.albedo[k] = first.albedo;
  out.samples.normal[k] = first.n;
  out.samples.depth[k] = length(first.p - lens_point(camera, drawn));
}

}  // namespace
}  // namespace myrialux
