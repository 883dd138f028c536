// Gives the kernels one column at a time, so that their sums are single entries.
#include "myrialux/shading/shade_entries.h"

#include <algorithm>

#include "myrialux/base/assert.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/shading/gather.h"

namespace myrialux {
namespace {

struct Scratch {
  GatheredColumns columns;
  GatheredRows rows;
  CoatTables tables;
};

/// Rows of `bits` from the sums; `albedo` is null where the kernel has applied the colour.
void write_entries(const BlockSums& sums, std::uint64_t bits, const Rgb* albedo, std::span<float> entries) {
  for_each_bit(Words(&bits, 1), [&](std::size_t k) {
    const Rgb sum{sums.rgb[0][k], sums.rgb[1][k], sums.rgb[2][k]};
    entries[k] = luminance(albedo ? albedo[k] * sum : sum);
  });
}

}  // namespace

void shade_entries(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                   const VirtualLights& lights, std::span<const Column> columns, const BitMatrix& visible,
                   const ShadeParams& params, std::span<float> entries) {
  MYRIALUX_ASSERT(rows.size() <= kBlockRows && entries.size() == columns.size() * kBlockRows);
  MYRIALUX_ASSERT(visible.n_rows() == rows.size() && visible.n_columns() == columns.size());
  thread_local Scratch scratch;
  std::vector<Column> unweighted(columns.begin(), columns.end());
  for (Column& c : unweighted) c.weight = 1;
  scratch.tables.clear();
  gather_columns(world, lights, unweighted, scratch.tables, scratch.columns);
  gather_rows(world, receivers, rows, scratch.tables, scratch.rows);
  std::fill(entries.begin(), entries.end(), 0.0f);
  const auto entries_of = [&](std::uint32_t c) { return entries.subspan(c * kBlockRows, kBlockRows); };
  BlockSums sums;

  for (std::size_t kind = 0; kind < scratch.columns.diffuse.size(); ++kind) {
    const DiffuseColumns& run = scratch.columns.diffuse[kind];
    for (std::size_t k = 0; k < run.column.size(); ++k) {
      const std::uint64_t bits = visible.column(run.column[k])[0] & scratch.rows.diffuse;
      if (bits == 0) continue;
      sums = {};
      shade_diffuse(scratch.rows.block,
                    {.kind = static_cast<DiffuseLight>(kind),
                     .lights = std::span(run.lights).subspan(k, 1),
                     .visible = Words(&bits, 1),
                     .bumpy = run.bumpy || scratch.rows.bumpy,
                     .clamp_distance = params.clamp_distance,
                     .tracked = 0},
                    sums);
      write_entries(sums, bits, scratch.rows.albedo.data(), entries_of(run.column[k]));
    }
  }
  const GatheredColumns& all = scratch.columns;
  for (std::size_t k = 0; k < all.general.size(); ++k) {
    const std::uint64_t rows_here = scratch.rows.others | (k < all.n_slow ? scratch.rows.diffuse : 0);
    const std::uint64_t bits = visible.column(all.column[k])[0] & rows_here;
    if (bits == 0) continue;
    sums = {};
    shade_general(scratch.rows.block, scratch.rows.lobes,
                  {.lights = std::span(all.general).subspan(k, 1),
                   .visible = Words(&bits, 1),
                   .spots = all.spots,
                   .lobes = all.lobes,
                   .tables = scratch.tables.values(),
                   .clamp_distance = params.clamp_distance,
                   .tracked = 0},
                  sums);
    write_entries(sums, bits, nullptr, entries_of(all.column[k]));
  }
}

}  // namespace myrialux
