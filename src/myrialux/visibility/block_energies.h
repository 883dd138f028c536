// What the entries of a block of 16 rows may bring, from one row that stands for it: where a completion should look.
#pragma once

#include "myrialux/clusters/cut.h"
#include "myrialux/kernels/cut_bounds.h"

namespace myrialux {

/// Of one slice. Keeps references to lights and tree.
class BlockEnergies {
 public:
  /// @param clamp_distance as CutParams
  /// @param unit radiance that counts as energy 1; > 0
  BlockEnergies(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                const VirtualLights& lights, const LightTree& tree, std::span<const Column> columns,
                float clamp_distance, float unit);

  /// Upper bound of W T beta (luminance, no occlusion) at the middle row of each block; 0 for blocks beyond the rows.
  /// Cost: 4 evaluations of 16 bounds for 1024 rows. @param energies [blocks, rounded up as you like]
  void of(std::size_t j, std::span<float> energies) const;
  std::size_t memory_bytes() const;

 private:
  World world_;
  const VirtualLights& lights_;
  const LightTree& tree_;
  std::vector<Column> columns_;
  CutPoints points_;         ///< a row each block
  std::vector<float> beta_;  ///< of these rows, over the unit
};

}  // namespace myrialux
