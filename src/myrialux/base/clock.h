// Wall time of stages, CPU time of the calling thread and of the whole process, in seconds.
#pragma once

#include <ctime>

namespace myrialux {

inline double read_clock(clockid_t id) {
  timespec t{};
  clock_gettime(id, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Seconds since it was made or last restarted.
template <clockid_t Id>
class BasicStopwatch {
 public:
  /// Seconds since the start; starts anew.
  double lap() {
    const double now = read_clock(Id), elapsed = now - start_;
    start_ = now;
    return elapsed;
  }
  double elapsed() const { return read_clock(Id) - start_; }

 private:
  double start_ = read_clock(Id);
};
using Stopwatch = BasicStopwatch<CLOCK_MONOTONIC>;
using ThreadStopwatch = BasicStopwatch<CLOCK_THREAD_CPUTIME_ID>;    ///< CPU time of this thread
using ProcessStopwatch = BasicStopwatch<CLOCK_PROCESS_CPUTIME_ID>;  ///< CPU time of all threads together

}  // namespace myrialux
