// What a render did, counted; written as stats.json (contract: keys grow, never change their meaning).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "myrialux/base/clock.h"
#include "myrialux/math/intervals.h"

namespace myrialux {

struct RenderStats {
  std::string scene, method;
  std::map<std::string, std::string> parameters;
  std::uint64_t seed = 0;
  int threads = 1;
  std::string isa, device = "cpu";
  std::uint64_t receivers = 0, virtual_lights = 0, slices = 0, passes = 0;
  double clusters_mean = 0;
  struct Visibility {
    std::uint64_t entries = 0, traced = 0, fully_sampled_columns = 0, verified_columns = 0;
    /// Entries whose completed bit was held against its ray, and those found wrong; none: estimates are null in the
    /// file
    std::uint64_t checked = 0, false_visible = 0, false_occluded = 0;
    /// What the method chose and measured to keep to --visibility-error; sums over passes.
    struct Meter {
      std::uint64_t rays = 0, wrong = 0;  ///< random true rays, and those that contradict the completed bit
      std::uint64_t more_rays =
          0;  ///< by energy, following wrong ones, of slices completed again, for the frame's mean
      std::uint64_t slices = 0, redone_slices = 0;
      double error_square = 0;           ///< mean square over pixels, over the mean radiance
      double error_square_variance = 0;  ///< of that estimate
      double error_square_third = 0;     ///< its third central moment
      double bias = 0, bias_variance = 0;
      double mean_radiance = 0;  ///< of pixels, from virtual lights; luminance
      double slack = 0;          ///< see with_slack()
      double pilot_error = 0;    ///< true error of the pilot's slices at that slack
      Meter& operator+=(const Meter& o) {
        rays += o.rays, wrong += o.wrong, more_rays += o.more_rays, slices += o.slices,
            redone_slices += o.redone_slices;
        error_square += o.error_square, error_square_variance += o.error_square_variance;
        error_square_third += o.error_square_third;
        bias += o.bias, bias_variance += o.bias_variance, slack += o.slack, mean_radiance += o.mean_radiance,
            pilot_error += o.pilot_error;
        return *this;
      }
      /// From sums over n passes to means.
      void divide(double n) {
        error_square /= n, error_square_variance /= n * n, error_square_third /= n * n * n, bias /= n,
            bias_variance /= n * n;
        slack /= n, mean_radiance /= n, pilot_error /= n;
      }
    } meter;
  } visibility;
  /// Of methods that refine clusters to an error bound.
  struct Refinement {
    std::uint64_t bounds = 0;            ///< upper bounds taken; 0: not counted
    std::uint64_t approximate_rays = 0;  ///< of rays.shadow, those that only told how bright the picture is
  } refinement;
  struct Rays {
    std::uint64_t camera = 0, light = 0, shadow = 0, compensation = 0;
  } rays;
  /// Wall seconds by stage: load build receivers lights cluster visibility complete shade film total. Stages that run
  /// side by side in slices share the wall time of their loop in proportion to their CPU time.
  std::map<std::string, double> time_s;
  /// CPU seconds of all threads, stage by stage: of all that the frame does, of the grouping of rows and columns
  /// ("group"), and of what slices do. Other work on the machine disturbs them less than wall time.
  std::map<std::string, double> cpu_s;
  struct Memory {
    std::uint64_t peak_rss = 0, scene = 0, slices_peak = 0;
    std::uint64_t trees = 0;      ///< hierarchies of lights and of all receivers; 0: not measured
    std::uint64_t predicted = 0;  ///< what the process was to take at most; 0: not predicted
  } memory;
  /// Of --clusters auto, from the first pass: errors of one pass, see ClusterChoice
  struct ClustersAuto {
    std::uint64_t chosen = 0;  ///< 0: the number was given
    double light_set_error = 0, cluster_error = 0, visibility_error = 0;
  } clusters_auto;
  double error_estimate = -1, error_confidence = -1;  ///< -1: not measured
  double clamped_energy_fraction = -1;
  std::vector<std::string> warnings;
};

/// Times one stage after another.
class StageClock {
 public:
  /// Adds the time since the last call, or since it was made, to a stage.
  void lap(const char* stage, RenderStats& stats) {
    stats.time_s[stage] += wall_.lap();
    stats.cpu_s[stage] += cpu_.lap();
  }
  /// Forgets that time.
  void skip() { wall_.lap(), cpu_.lap(); }

 private:
  Stopwatch wall_;
  ProcessStopwatch cpu_;
};

/// The meter's numbers with their 95 % intervals; zeros without rays.
struct MeterErrors {
  double wrong = 0;  ///< share of completed bits that are wrong, mean over receivers
  double error = 0;  ///< root mean square over pixels, over the mean radiance
  double bias = 0;   ///< mean of completed less true radiance, over the mean radiance
  Interval wrong_interval = {}, error_interval = {}, bias_interval = {};
};
MeterErrors meter_errors(const RenderStats::Visibility::Meter& meter);
/// "0.53 % (95 %: 0.37 to 0.66)"; "at most 0.33 % (95 %)" where the estimate, which scatters about the truth, is not
/// above 0.
std::string error_words(const MeterErrors& errors);

/// The JSON text, keys as in docs/formats.md.
std::string to_json(const RenderStats& stats);
/// Bytes of memory this process used at most so far.
std::uint64_t peak_rss_bytes();
/// Writes text beside the target and renames. @throws Error (output)
void write_text_file(const std::string& path, const std::string& text);

}  // namespace myrialux
