// Light cuts of single receivers: from the roots down, each receiver's own, until no node's error bound passes a share
// of the receiver's total. [walter05, 4] Sixteen neighbours walk the tree together: one cluster is bounded, shaded and
// traced for all that still hold it.
#pragma once

#include <array>
#include <cstdint>

#include "myrialux/clusters/bounds.h"

namespace myrialux {

struct ReceiverCutParams {
  float error = 0.02f;            ///< largest bound of a node over the receiver's total estimate; 0: down to the leaves
  std::uint32_t max_size = 1000;  ///< nodes of a cut at most (at least one a kind of light)
};

/// Radiance at 16 receivers, W m^-2 sr^-1.
struct alignas(64) PacketLight {
  float rgb[3][kCutLanes];
};

/// What one light sends to the receivers of a packet, shadows included.
class LightAtPacket {
 public:
  virtual ~LightAtPacket() = default;
  /// Sets the receivers in `rows` (bits); others are not looked at.
  virtual void evaluate(LightId light, std::uint32_t rows, PacketLight& arriving) = 0;
};

/// Cuts of one packet, and what they add up to.
struct PacketCut {
  std::array<Rgb, kCutLanes> radiance{};        ///< beta not applied
  std::array<std::uint32_t, kCutLanes> size{};  ///< nodes of the receiver's cut; 0: not in the packet
  std::uint32_t n_bounds = 0;                   ///< clusters bounded, each at all receivers of the packet at once
  std::uint32_t n_evaluated = 0;                ///< lights evaluated, likewise
};

/// Memory of one thread a node of the largest cut: every receiver of a packet may hold nodes of its own.
inline constexpr std::size_t kPacketCutBytes = 16 * 420;

/// Refines the node with the largest bound first, for every receiver to which its bound is too large. A child that has
/// its parent's representative inherits the parent's light, shadow included.
/// Receivers of total 0 are refined down to the leaves or to max_size.
/// @param group of points; @param rows which of its 16 receivers take part
PacketCut cut_packet(const LightTree& tree, const CutPoints& points, std::size_t group, std::uint32_t rows,
                     const ReceiverCutParams& params, LightAtPacket& lights);

}  // namespace myrialux
