// Asks Highway which instruction sets this machine runs, and pins one for tests.
#include "myrialux/kernels/isa.h"

#include "myrialux/base/assert.h"
#include "myrialux/kernels/targets.h"
// Highway's headers read the macros of targets.h.
#include "hwy/highway.h"

namespace myrialux {

std::vector<std::int64_t> available_isas() {
  std::vector<std::int64_t> found;
  const std::int64_t supported = hwy::SupportedTargets() & HWY_TARGETS;
  for (std::int64_t bit = 1; bit > 0 && bit <= supported; bit <<= 1)  // lower bits are better
    if (supported & bit) found.push_back(bit);
  return found;
}

std::string isa_name(std::int64_t isa) { return hwy::TargetName(isa); }

std::string isa_name() { return isa_name(available_isas().front()); }

void force_isa(std::int64_t isa) {
  hwy::SetSupportedTargetsForTest(0);
  if (isa != 0) {
    MYRIALUX_ASSERT(hwy::SupportedTargets() & HWY_TARGETS & isa);
    hwy::SetSupportedTargetsForTest(isa);
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace myrialux
