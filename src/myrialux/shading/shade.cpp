#include "myrialux/shading/shade.h"

#include <algorithm>

#include "myrialux/base/assert.h"
#include "myrialux/shading/gather.h"
#include "myrialux/transfer/transfer.h"

namespace myrialux {
namespace {

/// Memory of one thread, kept from slice to slice.
struct Scratch {
  GatheredColumns columns;
  GatheredRows rows;
  std::vector<std::uint64_t> bits;  ///< of the block's rows in the columns of one run
};

/// Rows of the block whose clamped-away light is summed.
std::uint64_t tracked_rows(std::size_t first_row) {
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < kBlockRows; ++k) bits |= std::uint64_t{is_tracked_row(first_row + k)} << k;
  return bits;
}

/// Bits of word `word` of the given columns, without those of rows that do not take part.
std::span<const std::uint64_t> pick_bits(const BitMatrix& visible, std::span<const std::uint32_t> columns,
                                         std::size_t word, std::uint64_t rows, std::vector<std::uint64_t>& bits) {
  bits.resize(columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) bits[k] = visible.column(columns[k])[word] & rows;
  return bits;
}

}  // namespace

ShadeResult shade_slice(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                        const VirtualLights& lights, std::span<const Column> columns, const BitMatrix& visible,
                        const ShadeParams& params, std::span<Rgb> radiance) {
  MYRIALUX_ASSERT(visible.n_rows() == rows.size() && visible.n_columns() == columns.size());
  MYRIALUX_ASSERT(radiance.size() == rows.size());
  thread_local Scratch scratch;
  gather_columns(lights, columns, scratch.columns);

  ShadeResult result;
  double removed = 0, n_tracked = 0;
  for (std::size_t first = 0; first < rows.size(); first += kBlockRows) {
    const std::size_t word = first / kBlockRows, n = std::min(kBlockRows, rows.size() - first);
    gather_rows(world, receivers, rows.subspan(first, n), scratch.rows);
    const std::uint64_t tracked = params.clamp_distance > 0 ? tracked_rows(first) : 0;

    // Diffuse rows and lights, most of all pairs, need one colour a row only at the end.
    BlockSums diffuse{};
    for (std::size_t kind = 0; kind < scratch.columns.diffuse.size(); ++kind) {
      const DiffuseColumns& run = scratch.columns.diffuse[kind];
      shade_diffuse(scratch.rows.block,
                    {.kind = static_cast<DiffuseLight>(kind),
                     .lights = run.lights,
                     .visible = pick_bits(visible, run.column, word, scratch.rows.diffuse, scratch.bits),
                     .bumpy = run.bumpy || scratch.rows.bumpy,
                     .clamp_distance = params.clamp_distance,
                     .tracked = tracked},
                    diffuse);
    }
    for (std::size_t k = 0; k < n; ++k) {
      const Rgb albedo = scratch.rows.albedo[k];
      Rgb sum = albedo * Rgb{diffuse.rgb[0][k], diffuse.rgb[1][k], diffuse.rgb[2][k]};
      const auto add = [&](std::size_t c) {
        if (visible.test(first + k, c))
          sum += columns[c].weight *
                 transfer(world, receivers, rows[first + k], lights, columns[c].light, params.clamp_distance);
      };
      if (scratch.rows.others >> k & 1)
        for (std::size_t c = 0; c < columns.size(); ++c) add(c);
      else
        for (const std::uint32_t c : scratch.columns.others) add(c);
      radiance[first + k] = sum;
      result.radiance_sum += luminance(sum);
      if (tracked >> k & 1) {
        removed += luminance(albedo * Rgb{diffuse.removed[0][k], diffuse.removed[1][k], diffuse.removed[2][k]});
        n_tracked += 1;
      }
    }
  }
  if (n_tracked > 0) result.clamped_away_sum = removed * static_cast<double>(rows.size()) / n_tracked;
  return result;
}

}  // namespace myrialux
