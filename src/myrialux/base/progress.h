// What long work tells its caller: which stage runs and how far it is. The library never prints; apps/ draws the bar.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

namespace myrialux {

/// Receives progress. Calls of `stage` come from one thread; `advance` may come from all.
class Progress {
 public:
  virtual ~Progress() = default;
  /// A stage begins: its name ("visibility"), the number of work items (0 = unknown) and their unit ("slices").
  virtual void stage(const std::string& name, std::uint64_t n_items, const std::string& unit) {
    (void)name, (void)n_items, (void)unit;
  }
  virtual void advance(std::uint64_t n_items) { (void)n_items; }
  /// One line worth telling now ("pass 3 of 8").
  virtual void note(const std::string& line) { (void)line; }
};

}  // namespace myrialux
