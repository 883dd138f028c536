// Invariants: a programmer's mistake stops a checked build (dev, asan, tsan) at its place; release builds skip the
// test. Static analysis takes them as facts in every build.
#pragma once

#include <cstdio>
#include <cstdlib>

#if defined(NDEBUG) && !defined(__clang_analyzer__)
#define MYRIALUX_ASSERT(condition) ((void)sizeof(!(condition)))
#else
#define MYRIALUX_ASSERT(condition) \
  ((condition)                     \
       ? (void)0                   \
       : (std::fprintf(stderr, "%s:%d: broken invariant: %s\n", __FILE__, __LINE__, #condition), std::abort()))
#endif
