// Rows and columns of a slice copied side by side for the kernels: about 60 KB, once a slice.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "myrialux/clusters/cut.h"
#include "myrialux/kernels/shade_block.h"
#include "myrialux/kernels/shade_diffuse.h"

namespace myrialux {

/// Columns that diffuse rows take by one kind of the fast kernel.
struct DiffuseColumns {
  std::vector<ColumnLight> lights;
  std::vector<std::uint32_t> column;  ///< of each light, rising
  bool bumpy = false;                 ///< n != ng somewhere
};

struct GatheredColumns {
  std::array<DiffuseColumns, 3> diffuse;  ///< by DiffuseLight
  std::vector<std::uint32_t> others;      ///< columns of no fast kind, rising
};

/// Sets `gathered`, keeping its memory.
void gather_columns(const VirtualLights& lights, std::span<const Column> columns, GatheredColumns& gathered);

/// 64 rows and what they are made of.
struct GatheredRows {
  RowBlock block;
  std::uint64_t diffuse = 0, others = 0;  ///< rows of either kind; neither: rows that do not exist
  std::array<Rgb, kBlockRows> albedo;     ///< reflectance / pi of diffuse rows
  bool bumpy = false;
};

/// @param rows at most 64
void gather_rows(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                 GatheredRows& gathered);

}  // namespace myrialux
