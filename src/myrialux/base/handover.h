// Tells the thread sanitizer which work one thread hands to another inside code that it cannot see. Costs nothing else.
#pragma once

#if defined(__SANITIZE_THREAD__)
#define MYRIALUX_SANITIZE_THREAD 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define MYRIALUX_SANITIZE_THREAD 1
#endif
#endif
#ifdef MYRIALUX_SANITIZE_THREAD
#include <sanitizer/tsan_interface.h>
#endif

namespace myrialux {

/// All that happened before give() in any thread happened before what follows a later take() of the same object. Only
/// for places where a library without instrumentation sees to that; it orders nothing itself.
class Handover {
 public:
#ifdef MYRIALUX_SANITIZE_THREAD
  void give() noexcept { __tsan_release(this); }
  void take() noexcept { __tsan_acquire(this); }
#else
  void give() noexcept {}
  void take() noexcept {}
#endif
};

}  // namespace myrialux
