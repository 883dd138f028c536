// Spreads loops and pairs of calls over TBB's threads.
// Never instrumented by the thread sanitizer (cmake/dependencies.cmake): it would see half of TBB, the headers, and
// take each task that another thread runs for a race. parallel.h tells it what is handed over.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include "myrialux/base/parallel.h"

namespace myrialux::parallel {

void split_range(std::size_t n, std::size_t grain, void (*run)(void* work, std::size_t first, std::size_t last),
                 void* work) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain),
                    [=](const tbb::blocked_range<std::size_t>& r) { run(work, r.begin(), r.end()); });
}

void run_both(void (*run_a)(void* work), void (*run_b)(void* work), void* work) {
  tbb::parallel_invoke([=] { run_a(work); }, [=] { run_b(work); });
}

}  // namespace myrialux::parallel
