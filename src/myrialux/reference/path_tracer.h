// A whole frame by the plain path tracer: the reference for every many-light method.
#pragma once

#include <vector>

#include "myrialux/film/film.h"
#include "myrialux/receivers/receivers.h"

namespace myrialux {

/// One set of camera samples with the radiance each of them saw.
struct PathSamples {
  CameraSamples samples;      ///< `emission` is all zero: it is part of `radiance`
  std::vector<Rgb> radiance;  ///< [samples.size()], W m^-2 sr^-1
  PathCounters rays;
};
/// Traces params.spp stratified paths a pixel. Same bits for any number of threads.
PathSamples trace_paths(const World& world, const ReceiverParams& params, Progress& progress);

/// The same for the pixels of rows [y_begin, y_end) only; calls progress.advance() alone.
PathSamples trace_path_rows(const World& world, const ReceiverParams& params, int y_begin, int y_end,
                            Progress& progress);
/// Memory of one sample of it.
inline constexpr std::size_t kPathSampleBytes = kSampleBytes + kSampleLayerBytes + sizeof(Rgb);

struct PathTracerParams {
  int width = 0, height = 0, spp = 16;
  Filter filter;
  RandomKey key;  ///< `pass` is the first pass; passes count up from it
};
struct PathTracerResult {
  int width = 0, height = 0, n_passes = 0;
  std::vector<double> sum_rgb, weight;  ///< [3 n_pixels], [n_pixels]: filtered sums as film's accumulate() makes them
  std::vector<float> variance;  ///< [3 n_pixels] of the pixel's mean, from the spread of the passes; 0 for 1 pass
  PathCounters rays;
};
/// Renders spp samples a pixel in up to 16 passes of equal size, each stratified by itself, so that their spread is an
/// unbiased estimate of the picture's variance whatever the filter.
PathTracerResult render_paths(const World& world, const PathTracerParams& params, Progress& progress);

/// Beauty, and layer "stderr": standard error of each channel.
Picture to_picture(const PathTracerResult& result);

}  // namespace myrialux
