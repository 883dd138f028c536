// What a completion cost: counts that sum over slices.
#pragma once

#include <cstdint>

namespace myrialux {

struct CompletionStats {
  std::uint64_t entries = 0;           ///< active entries
  std::uint64_t traced = 0;            ///< entries asked of the source
  std::uint64_t full_columns = 0;      ///< columns traced whole
  std::uint64_t verified_columns = 0;  ///< columns predicted and found right by verification
  CompletionStats& operator+=(const CompletionStats& o) {
    entries += o.entries, traced += o.traced, full_columns += o.full_columns, verified_columns += o.verified_columns;
    return *this;
  }
};

}  // namespace myrialux
