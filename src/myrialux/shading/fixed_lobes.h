// A BSDF with one direction fixed, for kernels: what does not vary from pair to pair is multiplied out once.
#pragma once

#include <span>
#include <vector>

#include "myrialux/kernels/lobes.h"
#include "myrialux/scattering/bsdf.h"

namespace myrialux {

/// Transmittances of rough coats for the roughnesses of a slice, [n * kTableFloats]; equal ones are kept once.
class CoatTables {
 public:
  void clear() { values_.clear(), known_.clear(); }
  /// Where the table starts in values(). @param row, mix as in external_transmittance()
  std::size_t add(const float* row, float mix);
  std::span<const float> values() const { return values_; }

 private:
  struct Known {
    const float* row;
    float mix;
  };
  std::vector<float> values_;
  std::vector<Known> known_;
};

/// Which direction is fixed: at a receiver the one to the viewer (values are f cos of the arriving light), at a light
/// the one to where the power came from (values are f cos of the leaving light).
enum class FixedEnd : std::uint8_t { viewer, source };

struct FixedLobes {
  bool any = false;       ///< false: nothing is reflected whatever the other direction
  bool mirrored = false;  ///< the frame's normal is -n: the fixed direction is below the surface
  LightLobes lobes;
};

/// Wide lobes of `bsdf`. @param n the BSDF's normal; @param fixed unit, world
FixedLobes fix_lobes(const Bsdf& bsdf, Vec3 n, Vec3 fixed, FixedEnd end, CoatTables& tables);

}  // namespace myrialux
