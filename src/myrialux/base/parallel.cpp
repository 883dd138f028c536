// Counts the threads this process may use, limits TBB to them and sets how they treat denormals.
#include "myrialux/base/parallel.h"

#include <pmmintrin.h>
#include <sched.h>
#include <tbb/global_control.h>
#include <tbb/task_scheduler_observer.h>
#include <xmmintrin.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>

#include "myrialux/base/error.h"

namespace myrialux {
namespace {

std::atomic<bool> g_cancel{false};

/// Denormals would make the same loop a hundred times slower on some data; all threads treat them as zero alike.
void flush_denormals() {
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
}

class FlushObserver : public tbb::task_scheduler_observer {
 public:
  FlushObserver() { observe(true); }
  void on_scheduler_entry(bool) override { flush_denormals(); }
};

/// Never destroyed: workers may outlive statics, and TBB keeps what it allocates for an observer that comes and goes.
union ImmortalObserver {
  ImmortalObserver() : observer() {}
  ~ImmortalObserver() {}
  FlushObserver observer;
};

}  // namespace

int available_threads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  int n = 1;
  if (sched_getaffinity(0, sizeof set, &set) == 0) n = std::max(1, CPU_COUNT(&set));
  std::ifstream quota_file("/sys/fs/cgroup/cpu.max");
  std::string quota;
  double period = 0;
  if (quota_file >> quota >> period && quota != "max" && period > 0)
    n = std::min(n, std::max(1, static_cast<int>(std::ceil(std::stod(quota) / period))));
  return n;
}

struct ThreadScope::State {
  explicit State(int n_threads)
      : limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(n_threads)) {}
  tbb::global_control limit;
};

ThreadScope::ThreadScope(int n_threads) : state_(std::make_unique<State>(n_threads)) {
  [[maybe_unused]] static ImmortalObserver observer;
  flush_denormals();
}
ThreadScope::~ThreadScope() = default;

void request_cancel() noexcept { g_cancel.store(true, std::memory_order_relaxed); }
void clear_cancel() noexcept { g_cancel.store(false, std::memory_order_relaxed); }
bool cancel_requested() noexcept { return g_cancel.load(std::memory_order_relaxed); }
void throw_if_cancelled() {
  if (cancel_requested()) throw Error(ErrorKind::interrupted, "interrupted");
}

}  // namespace myrialux
