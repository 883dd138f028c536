// Random numbers keyed by work item: (seed, pass, stage, item) names a stream, whichever thread runs it.
// Philox 4x32-10 of the Random123 library [salmon11]: counter based, so a stream starts anywhere at no cost.
#pragma once

#include <Random123/philox.h>

#include <array>
#include <cstdint>

namespace myrialux {

/// What the numbers are for. Values are part of the key: append only.
enum class Stage : std::uint8_t {
  test,
  camera,
  receiver,
  light_walk,
  light_tree,
  cut,
  visibility,
  direct,
  residual,
  path,
  film,
  gather_tree,
  point_tree,
  lens,
  shutter,
  error_meter
};

/// Names all streams of one pass of a render.
struct RandomKey {
  std::uint64_t seed = 0;
  std::uint32_t pass = 0;
};

/// A stream of uniform numbers. Cheap to make: one per work item. Not shared between threads.
class Rng {
 public:
  Rng(RandomKey key, Stage stage, std::uint64_t item)
      : key_{{static_cast<std::uint32_t>(key.seed), static_cast<std::uint32_t>(key.seed >> 32)}},
        counter_{{0, key.pass | static_cast<std::uint32_t>(stage) << 24, static_cast<std::uint32_t>(item),
                  static_cast<std::uint32_t>(item >> 32)}} {}

  std::uint32_t next_uint() {
    if (left_ == 0) {
      block_ = r123::Philox4x32()(counter_, key_);
      ++counter_[0];
      left_ = 4;
    }
    return block_[--left_];
  }

  /// Uniform in [0, 1), 24 bits.
  float next() { return static_cast<float>(next_uint() >> 8) * 0x1p-24f; }

  /// Uniform in {0, ..., n - 1}, n > 0; the bias is below n / 2^32.
  std::uint32_t below(std::uint32_t n) {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(next_uint()) * n) >> 32);
  }

 private:
  r123::Philox4x32::key_type key_;
  r123::Philox4x32::ctr_type counter_;
  r123::Philox4x32::ctr_type block_{};
  int left_ = 0;
};

}  // namespace myrialux
