// Splits the global clusters for one slice, costliest first, and draws who stands for each. [ou11]
// Deviations: docs/methods/lightslice.md.
#include "myrialux/clusters/refined_clusters.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

#include "myrialux/base/parallel.h"

namespace myrialux {
namespace {

constexpr std::size_t kTile = 1024;  ///< columns read from a row at a time

/// Costs below this share of (sum of norms)^2 are rounding: the cluster's columns are parallel.
constexpr double kLeastCost = 1e-9;

/// What one pass over a cluster tells: its cost, and the line along which it would be split.
struct Measured {
  double norms = 0, global_norms = 0;
  std::array<double, kMostNeighbours> sum{};
  float largest = -1, second = -1;  ///< norms
  std::array<float, kMostNeighbours> x_largest{}, x_second{};

  void add(const LocalColumn& c) {
    norms += static_cast<double>(c.norm), global_norms += static_cast<double>(c.global_norm);
    for (std::size_t d = 0; d < kMostNeighbours; ++d) sum[d] += static_cast<double>(c.x[d]);
    if (c.norm > largest) {
      second = largest, x_second = x_largest;
      largest = c.norm, x_largest = c.x;
    } else if (c.norm > second) {
      second = c.norm, x_second = c.x;
    }
  }
  double cost() const {
    double square = 0;
    for (const double s : sum) square += s * s;
    const double cost = norms * norms - square;
    return cost > kLeastCost * norms * norms ? cost : 0;
  }
};

Measured measure(std::span<const LocalColumn> cluster) {
  Measured m;
  for (const LocalColumn& c : cluster) m.add(c);
  return m;
}

/// A cluster of two columns or more that may be split.
struct Part {
  std::uint32_t first, last;
  double cost, norm;                        ///< norm: sum of global norms
  std::array<float, kMostNeighbours> line;  ///< from the second largest to the largest column
  /// Less urgent to split than the other.
  bool operator<(const Part& o) const {
    return std::tuple(cost, norm, last - first, o.first) < std::tuple(o.cost, o.norm, o.last - o.first, first);
  }
};

Part make_part(std::uint32_t first, std::uint32_t last, const Measured& m) {
  Part part{first, last, m.cost(), m.global_norms, {}};
  for (std::size_t d = 0; d < kMostNeighbours; ++d) part.line[d] = m.x_largest[d] - m.x_second[d];
  return part;
}

struct SixVectors {
  Vec3 p, n;
};

SixVectors slice_place(const Receivers& receivers, std::span<const ReceiverId> rows, float normal_scale) {
  Vec3 n;
  for (const ReceiverId i : rows) n += receivers.n[index(i)];
  const float length_n = length(n);
  return {slice_centre(receivers, rows), length_n > 0 ? n * (normal_scale / length_n) : Vec3{}};
}

struct Halves {
  std::size_t n_first;  ///< 1 to n - 1
  Measured first, second;
};

/// Moves columns up to the middle of their projections to the front; two passes over the cluster.
Halves split(std::span<LocalColumn> cluster, const std::array<float, kMostNeighbours>& line) {
  float low = INFINITY, high = -INFINITY;
  for (LocalColumn& c : cluster) {
    c.key = 0;
    for (std::size_t d = 0; d < kMostNeighbours; ++d) c.key += c.x[d] * line[d];
    low = std::min(low, c.key), high = std::max(high, c.key);
  }
  const float middle = 0.5f * (low + high);
  if (!(low <= middle && middle < high)) {  // all alike: halved by count, lights near each other staying together
    std::sort(cluster.begin(), cluster.end(),
              [](const LocalColumn& a, const LocalColumn& b) { return a.column < b.column; });
    const std::size_t n = cluster.size() / 2;
    return {n, measure(cluster.first(n)), measure(cluster.subspan(n))};
  }
  Halves halves{0, {}, {}};
  for (std::size_t end = cluster.size(); halves.n_first < end;) {
    if (LocalColumn& c = cluster[halves.n_first]; c.key <= middle) {
      halves.first.add(c);
      ++halves.n_first;
    } else {
      halves.second.add(c);
      std::swap(c, cluster[--end]);
    }
  }
  return halves;
}

}  // namespace

std::vector<Neighbours> find_neighbours(const Receivers& receivers, const Slices& slices, float normal_scale,
                                        std::uint32_t n_neighbours) {
  MYRIALUX_ASSERT(n_neighbours >= 1 && n_neighbours <= kMostNeighbours);
  std::vector<SixVectors> place(slices.size());
  parallel_for(slices.size(), [&](std::size_t s) { place[s] = slice_place(receivers, slices.rows(s), normal_scale); });
  std::vector<Neighbours> neighbours(slices.size());
  parallel_for(slices.size(), [&](std::size_t s) {
    std::vector<std::pair<float, std::uint32_t>> found;
    for (std::uint32_t t = 0; t < slices.size(); ++t)
      found.emplace_back(
          t == s ? -1.0f : length_squared(place[t].p - place[s].p) + length_squared(place[t].n - place[s].n), t);
    const std::size_t n = std::min<std::size_t>(n_neighbours, found.size());
    std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(n), found.end());
    for (std::size_t k = 0; k < n; ++k) neighbours[s].push_back(found[k].second);
  });
  return neighbours;
}

std::vector<LocalColumn> local_columns(const ReducedMatrix& reduced, std::span<const float> global_norms,
                                       std::span<const std::uint32_t> neighbours, const ColumnClusters& clusters) {
  MYRIALUX_ASSERT(neighbours.size() <= kMostNeighbours && global_norms.size() == reduced.n_columns());
  // Rows are read in order and written side by side; the clusters' order comes after.
  const std::size_t n = reduced.n_columns();
  std::vector<std::array<float, kMostNeighbours>> x(n);
  std::array<float, kTile> tile;
  for (std::size_t first = 0; first < n; first += kTile) {
    const std::span<float> values = std::span(tile).first(std::min(kTile, n - first));
    for (std::size_t d = 0; d < neighbours.size(); ++d) {
      reduced.get(neighbours[d], first, values);
      for (std::size_t k = 0; k < values.size(); ++k) x[first + k][d] = values[k];
    }
  }
  std::vector<LocalColumn> columns(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t j = clusters.order[k];
    float square = 0;
    for (const float v : x[j]) square += v * v;
    columns[k] = {x[j], std::sqrt(square), global_norms[j], j, 0};
  }
  return columns;
}

double local_cost(std::span<const LocalColumn> cluster) { return cluster.size() < 2 ? 0 : measure(cluster).cost(); }

std::vector<std::uint32_t> refine_clusters(std::span<LocalColumn> columns, std::span<const std::uint32_t> first,
                                           std::uint32_t n_clusters) {
  std::priority_queue<Part> parts;
  std::vector<std::uint32_t> begins;
  std::size_t n = 0;
  const auto add = [&](std::uint32_t from, std::uint32_t to, const Measured& m) {
    ++n;
    if (to - from == 1)
      begins.push_back(from);
    else
      parts.push(make_part(from, to, m));
  };
  for (std::size_t c = 0; c + 1 < first.size(); ++c)
    add(first[c], first[c + 1], measure(columns.subspan(first[c], first[c + 1] - first[c])));
  while (n < n_clusters && !parts.empty()) {
    const Part part = parts.top();
    parts.pop();
    --n;
    const Halves halves = split(columns.subspan(part.first, part.last - part.first), part.line);
    const std::uint32_t middle = part.first + static_cast<std::uint32_t>(halves.n_first);
    add(part.first, middle, halves.first);
    add(middle, part.last, halves.second);
  }
  for (; !parts.empty(); parts.pop()) begins.push_back(parts.top().first);
  std::sort(begins.begin(), begins.end());
  begins.push_back(static_cast<std::uint32_t>(columns.size()));
  return begins;
}

Drawn draw_representative(std::span<const LocalColumn> cluster, std::span<const float> importance,
                          const DrawParams& params, float u) {
  if (cluster.size() == 1) return {cluster[0].column, 1};
  double local = 0, global = 0, power = 0;
  for (const LocalColumn& c : cluster) {
    local += static_cast<double>(c.norm);
    global += static_cast<double>(c.global_norm);
    power += static_cast<double>(importance[c.column]);
  }
  // Shares of what is not zero everywhere; norms that vanish nearby leave their share to those over all rows.
  const double by_power = global > 0 ? static_cast<double>(params.power_share) : params.power_share > 0 ? 1 : 0;
  const double by_local = local > 0 ? (1 - by_power) * static_cast<double>(params.local_share) : 0;
  const double by_global = global > 0 ? 1 - by_power - by_local : 0;
  const double l = local > 0 ? by_local / local : 0, g = global > 0 ? by_global / global : 0,
               p = power > 0 ? by_power / power : 0;
  double left = static_cast<double>(u) * (by_local + by_global + by_power);
  Drawn drawn{0, 0};
  for (const LocalColumn& c : cluster) {
    const double probability = l * static_cast<double>(c.norm) + g * static_cast<double>(c.global_norm) +
                               p * static_cast<double>(importance[c.column]);
    if (probability <= 0) continue;
    drawn = {c.column, static_cast<float>(1 / probability)};
    if ((left -= probability) < 0) break;
  }
  return drawn;
}

}  // namespace myrialux
