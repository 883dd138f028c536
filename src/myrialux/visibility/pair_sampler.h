// Which receivers of a cluster see one light, from few rays where all samples agree. [bus15, 3, algorithm 2]
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/lights/virtual_lights.h"
#include "myrialux/receivers/receivers.h"
#include "myrialux/trace/tracer.h"

namespace myrialux {

struct SamplingParams {
  std::uint32_t samples = 16, few_samples = 8;  ///< of clusters above `large` receivers, and of the others; at least 2
  std::uint32_t large = 32;
  std::uint32_t least = 8;  ///< clusters of fewer receivers are traced whole; at least 2
};
inline constexpr std::uint32_t kMaxPairSamples = 16, kMaxLeastPoints = 64;  ///< upper ends of these ranges

/// Consecutive places [first, end) of an order of receivers.
struct VisibleRun {
  std::uint32_t first, end;
};

/// One thread's sampler. Rows in z-order.
class PairSampler {
 public:
  PairSampler(const World& world, const Receivers& receivers, const VirtualLights& lights,
              std::span<const ReceiverId> order, const SamplingParams& params)
      : world_(world), receivers_(receivers), lights_(lights), order_(order), params_(params) {}

  /// Appends the runs of [first, first + count) that see the light, in order. The range is divided into equal parts,
  /// the middle one of each is traced: where all agree so do all others, else the parts are sampled in turn. Inactive
  /// entries are not traced and agree with either; what the runs say of them means nothing.
  void sample(std::uint32_t first, std::uint32_t count, LightId light, std::vector<VisibleRun>& runs);
  std::uint64_t rays() const { return rays_; }

 private:
  struct Samples;
  void trace(LightId light, Samples& samples);
  void trace_all(std::uint32_t first, std::uint32_t count, LightId light, const Samples& known,
                 std::vector<VisibleRun>& runs);

  const World& world_;
  const Receivers& receivers_;
  const VirtualLights& lights_;
  std::span<const ReceiverId> order_;
  SamplingParams params_;
  std::uint64_t rays_ = 0;
};

}  // namespace myrialux
