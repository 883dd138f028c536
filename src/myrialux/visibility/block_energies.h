// What the entries of a block of 16 rows may bring at most: where a completion should look.
#pragma once

#include "myrialux/clusters/cut.h"
#include "myrialux/kernels/block_bounds.h"

namespace myrialux {

/// Of one slice. Keeps references to lights and tree.
class BlockEnergies {
 public:
  /// @param clamp_distance as CutParams
  /// @param unit radiance that counts as energy 1; > 0
  BlockEnergies(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                const VirtualLights& lights, const LightTree& tree, std::span<const Column> columns,
                float clamp_distance, float unit);

  /// Upper bound of W T beta (luminance, no occlusion) over the rows of each block; 0 for blocks beyond the rows.
  /// Cost: 4 evaluations of 16 bounds for 1024 rows. @param energies [blocks, in whole words of rows]
  void of(std::size_t j, std::span<float> energies) const;
  std::size_t memory_bytes() const;

 private:
  World world_;
  const VirtualLights& lights_;
  const LightTree& tree_;
  std::vector<Column> columns_;
  BlockCones blocks_;
};

}  // namespace myrialux
