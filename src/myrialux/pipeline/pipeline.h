// Drives one method over a frame: scene in, picture and numbers out.
#pragma once

#include <map>
#include <string>

#include "myrialux/film/film.h"
#include "myrialux/methods/render.h"

namespace myrialux {

struct RenderParams {
  std::string method = "lbamc";
  int width = 0, height = 0;  ///< 0: as the scene says
  int spp = 0;                ///< 0: 4 (many-light methods) or the scene's (path)
  std::uint64_t n_lights = 100000;
  std::uint32_t n_clusters = 0;  ///< 0: MethodInfo::n_clusters
  bool auto_clusters = false;    ///< chosen in the first pass instead, see methods/auto_clusters.h
  float visibility_error = -1;   ///< 0 to 1, see MethodParams; negative: not given
  int max_depth = 0;             ///< 0: as the scene says; -1: no limit
  enum class Direct { vpl, sampled } direct = Direct::vpl;
  float clamp = 0.02f;        ///< fraction of the robust scene radius; 0 = off
  float clamp_distance = -1;  ///< the same in scene units, in place of `clamp`; negative: not given
  bool residual = true;       ///< add what virtual lights cannot carry (see transport/paths.h)
  int passes = 1;
  std::uint64_t seed = 0;
  int threads = 0;                           ///< 0: all available
  std::uint64_t memory_limit = 0;            ///< bytes the process never exceeds; 0: none
  int rows_at_once = 0;                      ///< of pixels, by methods that can (MethodInfo::prepare); 0: as fits
  std::string lights_file;                   ///< read instead of traced
  std::map<std::string, std::string> extra;  ///< -D key=value
  Filter filter;                             ///< used if has_filter, else the scene's
  bool has_filter = false;
  std::vector<std::string> aovs;  ///< empty: all of albedo normal depth slice cut visibility error
};

struct RenderOutput {
  Picture picture;
  RenderStats stats;
  Metadata metadata;
};

/// @throws Error (usage: unknown method or key; input; limit: the process would take more than memory_limit, naming
/// settings that fit; thrown before the frame, or after a pass's lights are known should they be more than foreseen)
RenderOutput render(const Scene& scene, const RenderParams& params, Progress& progress);

/// Name, default and meaning of every -D key, for --help and docs.
struct ParameterInfo {
  std::string key, value, meaning;
};
std::vector<ParameterInfo> parameter_table();

}  // namespace myrialux
