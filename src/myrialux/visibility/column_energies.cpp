// Few rows stand for the slice, as in the light cut: energies are compared with each other only.
#include "myrialux/visibility/column_energies.h"

#include <algorithm>

#include "myrialux/transfer/transfer.h"

namespace myrialux {

std::vector<float> column_energies(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                                   const VirtualLights& lights, std::span<const Column> columns, float clamp_distance) {
  std::vector<float> energies(columns.size());
  const std::size_t n = std::min<std::size_t>(rows.size(), 16);
  for (std::size_t j = 0; j < columns.size(); ++j) {
    double sum = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const ReceiverId i = rows[k * rows.size() / n];
      const Rgb t = transfer(world, receivers, i, lights, columns[j].light, clamp_distance);
      sum += columns[j].weight * luminance(receivers.beta[index(i)] * t);
    }
    energies[j] = n > 0 ? static_cast<float>(sum / static_cast<double>(n)) : 0.0f;
  }
  return energies;
}

}  // namespace myrialux
