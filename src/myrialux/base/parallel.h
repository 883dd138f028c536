// Parallel loops over work items. Results must not depend on which thread runs an item, nor in which order.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <cstddef>
#include <memory>

#include "myrialux/base/cancel.h"

namespace myrialux {

/// Threads this process may use: the smaller of the CPU affinity and the control group's quota, at least 1.
int available_threads();

/// Limits all parallel loops to n_threads (>= 1) while it lives, and sets flush-to-zero in every worker thread.
class ThreadScope {
 public:
  explicit ThreadScope(int n_threads);
  ~ThreadScope();
  ThreadScope(const ThreadScope&) = delete;
  ThreadScope& operator=(const ThreadScope&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Calls body(i) for i in [0, n), items in groups of `grain`. Throws Error (interrupted) once cancelled.
template <class Body>
void parallel_for(std::size_t n, const Body& body, std::size_t grain = 1) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const tbb::blocked_range<std::size_t>& r) {
    throw_if_cancelled();
    for (std::size_t i = r.begin(); i != r.end(); ++i) body(i);
  });
}

/// Runs a() and b(), on two threads if one is free: the two halves of a recursion.
template <class A, class B>
void parallel_invoke(const A& a, const B& b) {
  tbb::parallel_invoke(a, b);
}

}  // namespace myrialux
