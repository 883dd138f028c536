// The true bits of one slice: active entries from geometry, traced bits from Embree in packets of 16 adjacent rows.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "myrialux/clusters/cut.h"
#include "myrialux/matrix/entry_source.h"
#include "myrialux/trace/tracer.h"
#include "myrialux/visibility/block_energies.h"

namespace myrialux {

/// Entry source over a slice; rows in slice order, columns as the cut gave them, groups = octants. Keeps no reference
/// to receivers, lights and columns, only to the tracer. Not shared between threads.
class SliceVisibility final : public EntrySource {
 public:
  /// @param cull false: all rows of all columns count as active (the published form)
  SliceVisibility(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                  const VirtualLights& lights, std::span<const Column> columns, bool cull);
  ~SliceVisibility() override;
  std::size_t n_rows() const override;
  std::size_t n_columns() const override;
  Words active(std::size_t j) const override;
  Words required(std::size_t j) const override;
  float energy(std::size_t j) const override;
  void block_energies(std::size_t j, std::span<float> energies) const override;
  std::span<const RowPoint> row_points() const override;
  std::size_t n_groups() const override;
  std::size_t group_end(std::size_t g) const override;
  void trace(std::size_t j, Words wanted, MutableWords visible) override;
  const BitMatrix& active_matrix() const;
  /// Traces each ray from here on, also where a triangle that blocked others is known to block it: for benchmarks
  /// against raw Embree. Bits are the same.
  void forget_occluders();
  /// Entries that completion must trace, [n_rows x n_columns], among the active ones; none before this call.
  void require(BitMatrix required);
  /// What columns may bring, [n_columns]; all 1 before this call.
  void set_energies(std::vector<float> energies);
  /// What blocks may bring; nothing is known before this call.
  void set_block_energies(BlockEnergies energies);
  /// Null before they are set.
  const BlockEnergies* known_block_energies() const;
  std::uint64_t rays() const;     ///< shadow rays so far, those that remembered triangles block included
  std::uint64_t packets() const;  ///< packets that were traced
  double trace_seconds() const;   ///< CPU seconds this thread spent in trace()
  std::size_t memory_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace myrialux
