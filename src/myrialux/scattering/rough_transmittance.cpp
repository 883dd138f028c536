// Integrates transmittance and internal reflectance of rough dielectric boundaries over visible microfacet normals.
// Single scattering between facets, as Mitsuba's roughplastic has it; rows are computed on first use and kept.
#include "myrialux/scattering/rough_transmittance.h"

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "myrialux/scattering/fresnel.h"
#include "myrialux/scattering/microfacet.h"

namespace myrialux {
namespace {

constexpr std::size_t kAlphaNodes = 91;  // alpha = (k / 64)^2, k = 0 ... 90: finer where alpha is small
constexpr float kAlphaNodesPerRoot = 64;
constexpr int kExternalSteps = 16, kInternalSteps = 64;  // of the quadrature, along each side of the unit square

struct Table {
  Microfacets distribution;
  float eta;
  std::array<float, kAlphaNodes * kTransmittanceNodes> transmittance{};  // [alpha][cosine]
  std::array<float, kAlphaNodes> internal{};                             // [alpha]
  std::array<std::atomic<bool>, kAlphaNodes> ready{};
  Table* next = nullptr;
};

/// Tables are only ever added, in front of a list that readers walk without a lock.
struct Registry {
  std::atomic<Table*> first{nullptr};
  std::mutex adding;
  std::vector<std::unique_ptr<Table>> owned;
};

Registry& registry();
Table& find_table(Microfacets distribution, float eta);
void fill_row(Table& table, std::size_t k);

struct QuadratureNode {
  double x, share;
};
struct SquareNode {
  Vec2 u;
  double weight_uv;  ///< area of the unit square that the node stands for
};
using Quadrature = std::vector<SquareNode>;
Quadrature make_quadrature(Microfacets distribution, int steps);
std::vector<QuadratureNode> gauss_legendre(int n);
template <class Share>
double mean_over_normals(const Quadrature& quadrature, Microfacets distribution, float alpha, Vec3 w,
                         const Share& share);

}  // namespace

RoughTransmittance rough_transmittance(Microfacets distribution, float alpha, float eta) {
  Table& table = find_table(distribution, eta);
  const float x = std::min(std::sqrt(std::max(0.0f, alpha)) * kAlphaNodesPerRoot, static_cast<float>(kAlphaNodes - 1));
  const std::size_t k = std::min(static_cast<std::size_t>(x), kAlphaNodes - 2);
  for (const std::size_t row : {k, k + 1})
    if (!table.ready[row].load(std::memory_order_acquire)) fill_row(table, row);
  const float mix = x - static_cast<float>(k);  // linear in the root of alpha
  return {table.transmittance.data() + k * kTransmittanceNodes, mix,
          (1 - mix) * table.internal[k] + mix * table.internal[k + 1]};
}

namespace {

Registry& registry() {
  static Registry tables;
  return tables;
}

Table& find_table(Microfacets distribution, float eta) {
  Registry& tables = registry();
  const auto search = [&](Table* t) {
    while (t && !(t->distribution == distribution && t->eta == eta)) t = t->next;
    return t;
  };
  if (Table* found = search(tables.first.load(std::memory_order_acquire))) return *found;
  const std::lock_guard lock(tables.adding);
  if (Table* found = search(tables.first.load(std::memory_order_acquire))) return *found;
  Table& added = *tables.owned.emplace_back(std::make_unique<Table>());
  added.distribution = distribution;
  added.eta = eta;
  added.next = tables.first.load(std::memory_order_relaxed);
  tables.first.store(&added, std::memory_order_release);
  return added;
}

/// Two threads may compute the same row; both get the same numbers, and only the first writes them.
void fill_row(Table& table, std::size_t k) {
  const float root = static_cast<float>(k) / kAlphaNodesPerRoot, alpha = std::max(kMinAlpha, root * root);
  const Microfacets kind = table.distribution;
  const Quadrature external = make_quadrature(kind, kExternalSteps),
                   internal_nodes = make_quadrature(kind, kInternalSteps);
  std::array<float, kTransmittanceNodes> transmittance;
  double internal = 0;
  for (std::size_t i = 0; i < kTransmittanceNodes; ++i) {
    const float cos_theta = std::max(1e-6f, static_cast<float>(i) / static_cast<float>(kTransmittanceNodes - 1));
    const Vec3 w{std::sqrt(std::max(0.0f, 1 - cos_theta * cos_theta)), 0, cos_theta};
    transmittance[i] = static_cast<float>(mean_over_normals(external, kind, alpha, w, [&](Vec3 m) {
      const DielectricFresnel f = fresnel_dielectric(dot(w, m), table.eta);
      const Vec3 refracted = m * (dot(w, m) / f.eta_it + f.cos_transmitted) - w / f.eta_it;
      return refracted.z < 0 ? smith_g1(kind, alpha, refracted, m) * (1 - f.reflectance) : 0.0f;
    }));
    internal += cos_theta * mean_over_normals(internal_nodes, kind, alpha, w, [&](Vec3 m) {
                  const Vec3 reflected = 2 * dot(w, m) * m - w;
                  const float f = fresnel_dielectric(dot(w, m), 1 / table.eta).reflectance;
                  return reflected.z > 0 ? smith_g1(kind, alpha, reflected, m) * f : 0.0f;
                });
  }
  const std::lock_guard lock(registry().adding);
  if (table.ready[k].load(std::memory_order_relaxed)) return;
  std::copy(transmittance.begin(), transmittance.end(), table.transmittance.begin() + k * kTransmittanceNodes);
  table.internal[k] = static_cast<float>(2 * internal / kTransmittanceNodes);
  table.ready[k].store(true, std::memory_order_release);
}

/// Half of the square is enough: facets left and right of the plane of incidence (w.y = 0) pass the same light.
/// Nodes gather towards the facets that stand upright, where the square's map bends.
Quadrature make_quadrature(Microfacets distribution, int steps) {
  const std::vector<QuadratureNode> gauss = gauss_legendre(steps);
  Quadrature q;
  for (const QuadratureNode& a : gauss)
    for (std::size_t b = 0; b < gauss.size(); ++b) {
      if (distribution == Microfacets::ggx) {  // u.x: squared radius on the disc; u.y: angle, a half turn is smooth
        const double rest = 1 - a.x, angle = 0.25 + 0.5 * (static_cast<double>(b) + 0.5) / steps;
        q.push_back({{static_cast<float>(1 - rest * rest), static_cast<float>(angle)}, a.share * 2 * rest / steps});
      } else {  // both are cumulative probabilities of a slope
        const double rest = 1 - gauss[b].x;
        q.push_back({{static_cast<float>(a.x * a.x * (3 - 2 * a.x)), static_cast<float>(1 - 0.5 * rest * rest)},
                     a.share * 6 * a.x * (1 - a.x) * gauss[b].share * 2 * rest});
      }
    }
  return q;
}

/// Nodes and weights on [0, 1]; the weights add up to 1. Newton's method on the Legendre polynomial. [press07, 4.6]
std::vector<QuadratureNode> gauss_legendre(int n) {
  std::vector<QuadratureNode> nodes;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(3.14159265358979323846 * (i + 0.75) / (n + 0.5)), slope = 0;
    for (int iteration = 0; iteration < 20; ++iteration) {
      double p = 1, previous = 0;
      for (int k = 0; k < n; ++k) {
        const double next = ((2 * k + 1) * x * p - k * previous) / (k + 1);
        previous = p;
        p = next;
      }
      slope = n * (x * p - previous) / (x * x - 1);
      x -= p / slope;
    }
    nodes.push_back({0.5 * (1 - x), 1 / ((1 - x * x) * slope * slope)});
  }
  return nodes;
}

template <class Share>
double mean_over_normals(const Quadrature& quadrature, Microfacets distribution, float alpha, Vec3 w,
                         const Share& share) {
  double sum = 0;
  for (const auto& [u, weight_uv] : quadrature)
    sum += weight_uv * share(sample_visible_normal(distribution, alpha, w, u));
  return sum;
}

}  // namespace
}  // namespace myrialux
