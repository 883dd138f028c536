// One frame's receivers and virtual lights, traced once, for several methods to be compared on.
#pragma once

#include <memory>
#include <vector>

#include "myrialux/pipeline/pipeline.h"

namespace myrialux {

struct SharedFrameParams {
  int width = 640, height = 360, spp = 4;
  std::uint64_t n_lights = 100000;
  std::uint32_t n_clusters = 0;  ///< at budget 1; 0: the method's default
  float clamp = 0.02f;           ///< as RenderParams
  std::uint64_t seed = 0;
  std::map<std::string, std::string> extra;  ///< -D keys, for all methods
};

/// What one method made of the frame.
struct FrameRun {
  std::vector<Rgb> pixels;  ///< light from virtual lights alone, box filter, row by row
  RenderStats stats;        ///< of the method: visibility, rays.shadow, clusters, times, slices
  double seconds = 0;       ///< wall time of the method: its own trees, cuts, rays, sums
  double cpu_seconds = 0;   ///< CPU time of all threads meanwhile; other programs disturb it less
};

/// Emission seen directly, sampled direct light and residual rays are left out: they are the same for all methods.
class SharedFrame {
 public:
  /// Traces receivers and lights. Keeps a reference to `scene`.
  /// @throws Error (input: not renderable, no light; usage: unknown key)
  SharedFrame(const Scene& scene, const SharedFrameParams& params, Progress& progress);
  ~SharedFrame();
  SharedFrame(const SharedFrame&) = delete;
  SharedFrame& operator=(const SharedFrame&) = delete;

  std::size_t n_receivers() const;
  std::size_t n_lights() const;

  /// @param budget effort as a multiple of the method's defaults: clusters are multiplied by it, error thresholds are
  /// divided (MethodInfo::knob); brute-force takes no account of it
  /// @throws Error (usage) for an unknown method or one without virtual lights
  FrameRun run(const std::string& method, double budget, Progress& progress) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The method's knob at a budget, as told to people: "clusters=500", "lightcuts.error=0.04"; brute-force: "".
std::string knob_at(const std::string& method, double budget, const SharedFrameParams& params);

}  // namespace myrialux
