// Columns of the light matrix: virtual point lights. [wang20, 4.3]; instant radiosity [keller97].
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "myrialux/base/progress.h"
#include "myrialux/base/rng.h"
#include "myrialux/transport/paths.h"

namespace myrialux {

/// How a virtual light sends its light out. The exact intensity of a surface lit from wi has the geometric cosine of
/// departure, |w . ng| [veach97, 5.3]; oriented lights therefore carry ng as their normal, glossy ones need n as frame
/// of the BSDF (arrival's |wi . n| / |wi . ng| is in `light`).
enum class LightKind : std::uint8_t {
  oriented,     ///< Lambertian: radiant intensity = light * cos, W/sr (area emitters, diffuse surfaces)
  glossy,       ///< light * f(wi, w) cos w with the surface's wide lobes; light = power that arrived there, W
  point,        ///< intensity = light in all directions (point and spot emitters; spots scaled by their falloff)
  directional,  ///< parallel light along n: light = irradiance on a facing surface, W m^-2; p is meaningless
};
inline constexpr int kLightKinds = 4;

/// All arrays have length size(); `glossy` only holds entries for lights of that kind.
struct VirtualLights {
  std::vector<Vec3> p;  ///< on the surface
  /// Unit. oriented: geometric normal on the lit side; glossy: shading normal as the BSDF has it (opaque surfaces: on
  /// the lit side; rough glass: the outside, wi . n < 0 inside); directional: direction of travel; spot: axis
  std::vector<Vec3> n;
  std::vector<Vec3> ng;       ///< geometric normal on the same side as n
  std::vector<float> offset;  ///< see SurfacePoint::offset
  std::vector<Rgb> light;     ///< see LightKind; already divided by the number of walks
  std::vector<LightKind> kind;
  std::vector<std::uint8_t> bounce;  ///< 0: on the emitter
  std::vector<std::uint32_t> extra;  ///< index into `glossy` or `spots`, or 0xffffffff
  struct Glossy {
    Vec3 wi;
    BsdfParams bsdf;
  };  ///< wi: unit, towards where the power came from
  std::vector<Glossy> glossy;
  struct Spot {
    float cos_cutoff, cos_beam;
  };
  std::vector<Spot> spots;
  std::uint64_t n_walks = 0;  ///< that left these lights, those that left none included; 0: not known
  std::size_t size() const { return p.size(); }
  std::uint64_t memory_bytes() const;
  /// Scalar size of light j's output, for choosing representatives and ordering: luminance of the peak intensity
  /// (directional: of the irradiance).
  float importance(const World& world, LightId j) const;
};

struct LightParams {
  std::uint64_t n_lights = 100000;  ///< expected number: as many walks are made as a pilot of 1024 says
  bool direct = true;               ///< false: no lights of bounce 0 (direct light is sampled at receivers)
  RandomKey key;
};

struct LightResult {
  VirtualLights lights;
  std::uint64_t n_walks = 0, light_rays = 0;
};

/// What trace_lights() is about to make, judged from its pilot.
struct LightForecast {
  std::uint64_t n_walks = 0;
  std::uint64_t n_lights = 0;  ///< hardly ever more: the expected number and three standard errors of the pilot's
  std::uint64_t n_glossy = 0;  ///< of them
  std::uint64_t memory_bytes() const;
};
LightForecast forecast_lights(const World& world, const LightParams& params);

/// Photon-like walks from all emitters by power, BSDF sampling, Russian roulette; one light a vertex with wide lobes.
/// Lights are ordered by walk. Number of walks is fixed beforehand from a pilot so that the estimate stays unbiased.
/// Bounces go up to world.max_depth - 2: exact for receivers at depth 1; deeper receivers (behind mirrors or glass) see
/// paths longer than max_depth by their depth - 1.
LightResult trace_lights(const World& world, const LightParams& params, Progress& progress);

/// Drops the lights of bounce 0, which stand for direct light. The others keep their order.
void remove_direct(VirtualLights& lights);

/// PLY point cloud; layout in docs/formats.md. Binary little endian when `binary`.
void write_lights(const VirtualLights& lights, const Scene& scene, const std::string& path, bool binary);
/// Number of lights that the file's header claims; 0 if it is not readable as one.
std::uint64_t count_lights(const std::string& path);
/// Reads what write_lights wrote, or any PLY with x y z nx ny nz r g b. @throws Error (input) with file:line or byte.
VirtualLights read_lights(const std::string& path, const Scene& scene);

}  // namespace myrialux
