// Asks TBB, the kernel (/proc/self/statm, proc(5)) and the allocator what this process uses.
#include "myrialux/base/process.h"

#include <malloc.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace myrialux {

int allowed_threads() {
  const std::size_t n_allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::min(static_cast<int>(n_allowed), tbb::this_task_arena::max_concurrency());
}

std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t all_pages = 0, resident_pages = 0;
  if (!(statm >> all_pages >> resident_pages)) return 0;
  return resident_pages * static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PAGESIZE)));
}

void release_freed_memory() { malloc_trim(0); }

}  // namespace myrialux
