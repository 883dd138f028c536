// Eigen, with the block sizes of its products fixed: the same bits on machines with other caches.
#pragma once

#define EIGEN_MPL2_ONLY
#include <Eigen/Dense>

namespace myrialux {

/// To be called before any product: Eigen splits sums by the sizes of the machine's caches unless told otherwise.
inline void fix_eigen_blocks() {
  static const bool done = (Eigen::setCpuCacheSizes(32 << 10, 512 << 10, 4 << 20), true);
  (void)done;
}

}  // namespace myrialux
