// Rows and columns of a slice copied side by side for the kernels: about 60 KB, once a slice.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/clusters/cut.h"
#include "myrialux/kernels/shade_diffuse.h"
#include "myrialux/kernels/shade_general.h"
#include "myrialux/shading/fixed_lobes.h"

namespace myrialux {

/// Columns of one kind that diffuse rows take by the fast kernel.
struct DiffuseColumns {
  std::vector<ColumnLight> lights;
  std::vector<std::uint32_t> column;  ///< of each light, rising
  bool bumpy = false;                 ///< n != ng somewhere
};

struct GatheredColumns {
  std::array<DiffuseColumns, 3> diffuse;  ///< by DiffuseLight
  std::vector<GeneralLight> general;      ///< all that light anything: first `n_slow` of no fast kind, then the others
  std::vector<std::uint32_t> column;      ///< of each general light, rising in both parts
  std::size_t n_slow = 0;
  std::vector<GeneralLight> fast;  ///< those of the fast kinds once more
  std::vector<std::uint32_t> fast_column;
  std::vector<SpotCone> spots;
  std::vector<LightLobes> lobes;
};

/// Sets `gathered`, keeping its memory; adds to `tables`.
void gather_columns(const World& world, const VirtualLights& lights, std::span<const Column> columns,
                    CoatTables& tables, GatheredColumns& gathered);

/// 64 rows and what they are made of. Rows of neither kind do not exist or are black.
struct GatheredRows {
  RowBlock block;
  RowLobes lobes;
  std::uint64_t diffuse = 0, others = 0;  ///< bits of rows
  std::array<Rgb, kBlockRows> albedo;     ///< reflectance / pi of diffuse rows, else 0
  bool bumpy = false;                     ///< n != ng somewhere
};

/// @param rows at most 64
void gather_rows(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows, CoatTables& tables,
                 GatheredRows& gathered);

}  // namespace myrialux
