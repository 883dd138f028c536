// Sums a slice block by block: diffuse pairs by the fast kernel, all others by the general one.
#include "myrialux/shading/shade.h"

#include <algorithm>

#include "myrialux/base/assert.h"
#include "myrialux/shading/gather.h"

namespace myrialux {
namespace {

/// Memory of one thread, kept from slice to slice.
struct Scratch {
  GatheredColumns columns;
  GatheredRows rows;
  CoatTables tables;
  std::vector<std::uint64_t> bits;  ///< of the block's rows in the columns of one run
};

std::uint64_t tracked_rows(std::size_t first_row);
void shade_diffuse_rows(const BitMatrix& visible, std::size_t word, float clamp_distance, std::uint64_t tracked,
                        Scratch& scratch, BlockSums& sums);
void shade_other_rows(const BitMatrix& visible, std::size_t word, float clamp_distance, std::uint64_t tracked,
                      Scratch& scratch, BlockSums& sums);
Rgb row_of(const BlockFloats* rgb, std::size_t k) { return {rgb[0][k], rgb[1][k], rgb[2][k]}; }

}  // namespace

ShadeResult shade_slice(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                        const VirtualLights& lights, std::span<const Column> columns, const BitMatrix& visible,
                        const ShadeParams& params, std::span<Rgb> radiance) {
  MYRIALUX_ASSERT(visible.n_rows() == rows.size() && visible.n_columns() == columns.size());
  MYRIALUX_ASSERT(radiance.size() == rows.size());
  thread_local Scratch scratch;
  scratch.tables.clear();
  gather_columns(world, lights, columns, scratch.tables, scratch.columns);

  ShadeResult result;
  double removed = 0, n_tracked = 0;
  for (std::size_t first = 0; first < rows.size(); first += kBlockRows) {
    const std::size_t word = first / kBlockRows, n = std::min(kBlockRows, rows.size() - first);
    gather_rows(world, receivers, rows.subspan(first, n), scratch.tables, scratch.rows);
    const std::uint64_t tracked = params.clamp_distance > 0 ? tracked_rows(first) : 0;

    // Diffuse rows under diffuse lights, most of all pairs, need their colour only at the end.
    BlockSums diffuse{}, others{};
    shade_diffuse_rows(visible, word, params.clamp_distance, tracked, scratch, diffuse);
    shade_other_rows(visible, word, params.clamp_distance, tracked, scratch, others);
    for (std::size_t k = 0; k < n; ++k) {
      const Rgb albedo = scratch.rows.albedo[k];
      radiance[first + k] = albedo * row_of(diffuse.rgb, k) + row_of(others.rgb, k);
      result.radiance_sum += luminance(radiance[first + k]);
      if (tracked >> k & 1) {
        removed += luminance(albedo * row_of(diffuse.removed, k) + row_of(others.removed, k));
        n_tracked += 1;
      }
    }
  }
  if (n_tracked > 0) result.clamped_away_sum = removed * static_cast<double>(rows.size()) / n_tracked;
  return result;
}

namespace {

/// Rows of the block whose clamped-away light is summed.
std::uint64_t tracked_rows(std::size_t first_row) {
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < kBlockRows; ++k) bits |= std::uint64_t{is_tracked_row(first_row + k)} << k;
  return bits;
}

void shade_diffuse_rows(const BitMatrix& visible, std::size_t word, float clamp_distance, std::uint64_t tracked,
                        Scratch& scratch, BlockSums& sums) {
  if (scratch.rows.diffuse == 0) return;
  for (std::size_t kind = 0; kind < scratch.columns.diffuse.size(); ++kind) {
    const DiffuseColumns& run = scratch.columns.diffuse[kind];
    scratch.bits.resize(run.column.size());
    for (std::size_t k = 0; k < run.column.size(); ++k)
      scratch.bits[k] = visible.column(run.column[k])[word] & scratch.rows.diffuse;
    shade_diffuse(scratch.rows.block,
                  {.kind = static_cast<DiffuseLight>(kind),
                   .lights = run.lights,
                   .visible = scratch.bits,
                   .bumpy = run.bumpy || scratch.rows.bumpy,
                   .clamp_distance = clamp_distance,
                   .tracked = tracked},
                  sums);
  }
}

/// Glossy rows under all lights; diffuse rows under spots and glossy lights.
void shade_other_rows(const BitMatrix& visible, std::size_t word, float clamp_distance, std::uint64_t tracked,
                      Scratch& scratch, BlockSums& sums) {
  const GatheredColumns& columns = scratch.columns;
  const std::uint64_t diffuse = scratch.rows.diffuse, others = scratch.rows.others;
  const std::size_t n = others != 0 ? columns.general.size() : columns.n_slow;
  if (n == 0) return;
  scratch.bits.resize(n);
  for (std::size_t k = 0; k < n; ++k)
    scratch.bits[k] = visible.column(columns.column[k])[word] & (k < columns.n_slow ? diffuse | others : others);
  shade_general(scratch.rows.block, scratch.rows.lobes,
                {.lights = std::span(columns.general).first(n),
                 .visible = scratch.bits,
                 .spots = columns.spots,
                 .lobes = columns.lobes,
                 .tables = scratch.tables.values(),
                 .clamp_distance = clamp_distance,
                 .tracked = tracked},
                sums);
}

}  // namespace
}  // namespace myrialux
