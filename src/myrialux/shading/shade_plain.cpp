// The sum of a slice entry by entry: what the kernels must agree with.
#include "myrialux/base/assert.h"
#include "myrialux/shading/shade.h"
#include "myrialux/transfer/transfer.h"

namespace myrialux {

void shade_slice_plain(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                       const VirtualLights& lights, std::span<const Column> columns, const BitMatrix& visible,
                       const ShadeParams& params, std::span<Rgb> radiance) {
  MYRIALUX_ASSERT(visible.n_rows() == rows.size() && visible.n_columns() == columns.size());
  MYRIALUX_ASSERT(radiance.size() == rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Rgb sum;
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (visible.test(i, c))
        sum += columns[c].weight * transfer(world, receivers, rows[i], lights, columns[c].light, params.clamp_distance);
    radiance[i] = sum;
  }
}

}  // namespace myrialux
