// Rows of the light matrix: where camera paths first meet a surface that is not a mirror. [wang20, 4.2]
#pragma once

#include <cstdint>
#include <vector>

#include "myrialux/base/array.h"
#include "myrialux/base/progress.h"
#include "myrialux/base/rng.h"
#include "myrialux/transport/paths.h"

namespace myrialux {

/// All arrays have length size().
struct Receivers {
  Array<Vec3> p;        ///< on the surface
  Array<float> offset;  ///< see SurfacePoint::offset
  Array<Vec3> ng, n;    ///< geometric and shading normal; n on the side of wo (= -(the BSDF's) if inside), ng on
                        ///< the side of n
  Array<Vec3> wo;       ///< unit, towards where the camera path came from
  Array<BsdfParams> bsdf;
  Array<Rgb> beta;                 ///< path weight from the camera, choice of lobes included
  Array<std::uint32_t> sample;     ///< camera sample it belongs to, among those traced: pixel * spp + k
  Array<std::uint8_t> depth;       ///< path edges from the camera to here, >= 1
  Array<std::uint8_t> inside;      ///< 1: seen from the back of a one-sided (refracting) material: local wo.z < 0
  std::uint64_t first_sample = 0;  ///< place in the picture of the first sample traced
  std::size_t size() const { return p.size(); }
  void reserve(std::size_t n);
  void resize(std::size_t n);
};
/// Memory of one receiver.
inline constexpr std::size_t kReceiverBytes =
    4 * sizeof(Vec3) + sizeof(float) + sizeof(BsdfParams) + sizeof(Rgb) + sizeof(std::uint32_t) + 2;

/// What a camera sample saw on its way, for film and AOVs; indexed by camera sample.
struct CameraSamples {
  int width = 0, height = 0, spp = 0;
  int first_row = 0;     ///< of the picture's rows of pixels that the samples belong to
  Array<Vec2> position;  ///< on the film, pixels from the top left
  Array<Rgb> emission;   ///< emission and environment seen directly or through sharp lobes, weighted
  Array<Rgb> albedo;     ///< at the first hit
  Array<Vec3> normal;    ///< at the first hit, world; 0 for none
  Array<float> depth;    ///< distance to the first hit, infinity for none
  std::size_t size() const { return position.size(); }
  /// Frees what only the layers need: albedo, normal, depth.
  void drop_layers() {
    Array<Rgb>().swap(albedo);
    Array<Vec3>().swap(normal);
    Array<float>().swap(depth);
  }
};
/// Memory of one camera sample: what is kept to the end of a pass, and what only the layers need.
inline constexpr std::size_t kSampleBytes = sizeof(Vec2) + sizeof(Rgb),
                             kSampleLayerBytes = sizeof(Rgb) + sizeof(Vec3) + sizeof(float);

struct ReceiverParams {
  int width = 0, height = 0, spp = 1;
  RandomKey key;
};

struct ReceiverResult {
  Receivers receivers;  ///< ordered by camera sample; at most one a sample
  CameraSamples samples;
  std::uint64_t camera_rays = 0;   ///< closest hits
  std::uint64_t shadow_rays = 0;   ///< of emitter samples at near-mirrors
  std::uint64_t inside_walls = 0;  ///< first hits that show the back of a one-sided surface: camera inside a wall?
};

/// Stratified camera samples, followed through sharp lobes to the first vertex where the wide lobes are chosen.
/// At a vertex with both kinds one is chosen with sharp_probability(). Emission found on the way counts: at sharp
/// vertices by emitter samples, too (MIS). Receivers are made only where one more edge is within max_depth.
/// Same bits for any number of threads.
ReceiverResult trace_receivers(const World& world, const ReceiverParams& params, Progress& progress);

/// The same for the pixels of rows [y_begin, y_end) only; calls progress.advance() alone.
ReceiverResult trace_receiver_rows(const World& world, const ReceiverParams& params, int y_begin, int y_end,
                                   Progress& progress);

/// Positions alone, of the first n_samples of each pixel's: those that trace_receivers() gives these samples.
/// @param rays closest hits are added to it
std::vector<Vec3> trace_receiver_positions(const World& world, const ReceiverParams& params, int n_samples,
                                           PathCounters& rays);

/// Film position (pixels) of sample k of a pixel: jittered in a grid of spp cells, as square as spp's factors allow;
/// cell numbers are shifted by a random offset a pixel, so that the first samples of a pixel are no worse than the
/// last.
Vec2 film_position(int width, std::uint64_t pixel, int k, int spp, RandomKey key);

/// What one camera sample draws.
struct CameraSample {
  Vec2 film;        ///< pixels from the top left
  Vec2 lens{};      ///< on the unit disc; the centre for pinholes
  double time = 0;  ///< in the shutter's interval; 0 for cameras that stand
};

/// Sample k of a pixel: film as above; the lens jittered in a grid of as many cells, the time in as many parts of the
/// shutter's interval, which random permutations of the pixel's pair with the cells of the film.
CameraSample camera_sample(const Camera& camera, int width, std::uint64_t pixel, int k, int spp, RandomKey key);

/// Where on the lens the sample's path begins, world space, at the sample's time.
Vec3 lens_point(const Camera& camera, const CameraSample& sample);

/// Ray from there to the point of the focus plane that the film position shows; direction unit; from the near to the
/// far plane of the camera.
Ray camera_ray(const Camera& camera, int width, int height, const CameraSample& sample);

/// The receiver as a path vertex again (BSDF rebuilt), for next-event and residual estimates.
Vertex receiver_vertex(const World& world, const Receivers& receivers, std::size_t i);

}  // namespace myrialux
