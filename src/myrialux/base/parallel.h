// Parallel loops over work items. Results must not depend on which thread runs an item, nor in which order.
#pragma once

#include <cstddef>
#include <memory>
#include <tuple>

#include "myrialux/base/cancel.h"
#include "myrialux/base/handover.h"

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

namespace parallel {  // what the templates below hand to TBB; loops.cpp

/// Calls run(work, first, last) for ranges that cover [0, n), on all threads.
void split_range(std::size_t n, std::size_t grain, void (*run)(void* work, std::size_t first, std::size_t last),
                 void* work);
/// Calls run_a(work) and run_b(work).
void run_both(void (*run_a)(void* work), void (*run_b)(void* work), void* work);

/// Work that one thread gives to all and that is whole again when Work ends.
template <class... Bodies>
struct Work {
  explicit Work(const Bodies&... b) : bodies(b...) { given.give(); }
  ~Work() { done.take(); }
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;

  /// Lives in a thread while it runs its part.
  struct Part {
    explicit Part(void* work) : of(*static_cast<Work*>(work)) { of.given.take(); }
    ~Part() { of.done.give(); }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;
    Work& of;
  };

  std::tuple<const Bodies&...> bodies;
  Handover given, done;
};

}  // namespace parallel

/// Calls body(i) for i in [0, n), items in groups of `grain`. Throws Error (interrupted) once cancelled.
template <class Body>
void parallel_for(std::size_t n, const Body& body, std::size_t grain = 1) {
  using Work = parallel::Work<Body>;
  Work work(body);
  const auto run = [](void* w, std::size_t first, std::size_t last) {
    const typename Work::Part part(w);
    throw_if_cancelled();
    const Body& call = std::get<0>(part.of.bodies);
    for (std::size_t i = first; i != last; ++i) call(i);
  };
  parallel::split_range(n, grain, run, &work);
}

/// Runs a() and b(), on two threads if one is free: the two halves of a recursion.
template <class A, class B>
void parallel_invoke(const A& a, const B& b) {
  using Work = parallel::Work<A, B>;
  Work work(a, b);
  const auto run_a = [](void* w) { std::get<0>(typename Work::Part(w).of.bodies)(); };
  const auto run_b = [](void* w) { std::get<1>(typename Work::Part(w).of.bodies)(); };
  parallel::run_both(run_a, run_b, &work);
}

}  // namespace myrialux
