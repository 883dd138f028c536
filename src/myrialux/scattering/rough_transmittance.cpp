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

constexpr std::size_t kAlphaNodes = 46;  // alpha = (k / 32)^2, k = 0 ... 45: finer where alpha is small
constexpr float kAlphaNodesPerRoot = 32;
constexpr int kExternalSteps = 24, kInternalSteps = 40;  // of the quadrature, along each side of the unit square

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
template <class Share>
double mean_over_normals(Microfacets distribution, float alpha, Vec3 w, int steps, const Share& share);

}  // namespace

RoughTransmittance rough_transmittance(Microfacets distribution, float alpha, float eta) {
  Table& table = find_table(distribution, eta);
  const float x = std::min(std::sqrt(std::max(0.0f, alpha)) * kAlphaNodesPerRoot, static_cast<float>(kAlphaNodes - 1));
  const std::size_t k = std::min(static_cast<std::size_t>(x), kAlphaNodes - 2);
  for (const std::size_t row : {k, k + 1})
    if (!table.ready[row].load(std::memory_order_acquire)) fill_row(table, row);
  // Linear in alpha, not in its root
  const auto node = [](std::size_t i) {
    const float root = static_cast<float>(i) / kAlphaNodesPerRoot;
    return root * root;
  };
  const float mix = std::clamp((alpha - node(k)) / (node(k + 1) - node(k)), 0.0f, 1.0f);
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
  std::array<float, kTransmittanceNodes> transmittance;
  double internal = 0;
  for (std::size_t i = 0; i < kTransmittanceNodes; ++i) {
    const float cos_theta = std::max(1e-6f, static_cast<float>(i) / static_cast<float>(kTransmittanceNodes - 1));
    const Vec3 w{std::sqrt(std::max(0.0f, 1 - cos_theta * cos_theta)), 0, cos_theta};
    transmittance[i] = static_cast<float>(mean_over_normals(kind, alpha, w, kExternalSteps, [&](Vec3 m) {
      const DielectricFresnel f = fresnel_dielectric(dot(w, m), table.eta);
      const Vec3 refracted = m * (dot(w, m) / f.eta_it + f.cos_transmitted) - w / f.eta_it;
      return refracted.z < 0 ? smith_g1(kind, alpha, refracted, m) * (1 - f.reflectance) : 0.0f;
    }));
    internal += cos_theta * mean_over_normals(kind, alpha, w, kInternalSteps, [&](Vec3 m) {
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

/// Midpoint rule over the square that visible normals are drawn from.
template <class Share>
double mean_over_normals(Microfacets distribution, float alpha, Vec3 w, int steps, const Share& share) {
  double sum = 0;
  for (int a = 0; a < steps; ++a)
    for (int b = 0; b < steps; ++b) {
      const float n = static_cast<float>(steps);
      const Vec2 u{(static_cast<float>(a) + 0.5f) / n, (static_cast<float>(b) + 0.5f) / n};
      sum += share(sample_visible_normal(distribution, alpha, w, u));
    }
  return sum / (steps * steps);
}

}  // namespace
}  // namespace myrialux
