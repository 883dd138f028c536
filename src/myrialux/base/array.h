// Arrays of plain values whose memory is first touched by whoever fills it, and their parallel filling.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "myrialux/base/parallel.h"

namespace myrialux {

/// Leaves elements made without a value as the memory was found.
template <class T>
struct UnsetAllocator : std::allocator<T> {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
  template <class U>
  struct rebind {
    using other = UnsetAllocator<U>;
  };
  template <class U>
  void construct(U*) noexcept {}
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    std::construct_at(at, std::forward<Args>(args)...);
  }
};

/// A vector but for resize(n), which sets nothing: to zero gigabytes first is one thread's work.
template <class T>
using Array = std::vector<T, UnsetAllocator<T>>;

/// make(i) for those i of [0, n) for which keep(i) holds, in order. Parallel, two calls of keep() each.
template <class T, class Keep, class Make>
Array<T> select(std::size_t n, const Keep& keep, const Make& make) {
  constexpr std::size_t kBlock = 1 << 14;
  std::vector<std::size_t> begin((n + kBlock - 1) / kBlock + 1);
  const auto for_each_block = [&](const auto& body) {
    parallel_for(begin.size() - 1,
                 [&](std::size_t b) { body(b, b * kBlock, n - b * kBlock < kBlock ? n : (b + 1) * kBlock); });
  };
  for_each_block([&](std::size_t b, std::size_t first, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t i = first; i < end; ++i) count += keep(i) ? 1 : 0;
    begin[b + 1] = count;
  });
  for (std::size_t b = 1; b < begin.size(); ++b) begin[b] += begin[b - 1];
  Array<T> kept;
  kept.resize(begin.back());
  for_each_block([&](std::size_t b, std::size_t first, std::size_t end) {
    T* to = kept.data() + begin[b];
    for (std::size_t i = first; i < end; ++i)
      if (keep(i)) *to++ = make(i);
  });
  return kept;
}

}  // namespace myrialux
