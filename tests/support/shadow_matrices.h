// Boolean matrices with known structure: planted low rank, and true shadows of discs and half-planes over a patch.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "myrialux/base/rng.h"
#include "myrialux/math/vec.h"
#include "myrialux/matrix/bit_ops.h"
#include "myrialux/matrix/known_entries.h"

namespace myrialux::test {

inline BitMatrix all_ones(std::size_t n_rows, std::size_t n_columns) {
  BitMatrix m(n_rows, n_columns);
  for (std::size_t j = 0; j < n_columns; ++j) fill_rows(m.column(j), n_rows);
  return m;
}

inline BitMatrix random_bits(std::size_t n_rows, std::size_t n_columns, Rng& rng, float density = 0.5f) {
  BitMatrix m(n_rows, n_columns);
  for (std::size_t j = 0; j < n_columns; ++j)
    for (std::size_t i = 0; i < n_rows; ++i)
      if (rng.next() < density) m.set(i, j);
  return m;
}

/// Each column is one of n_distinct random columns or its complement.
inline BitMatrix planted(std::size_t n_rows, std::size_t n_columns, std::size_t n_distinct, Rng& rng) {
  const BitMatrix basis = random_bits(n_rows, n_distinct, rng);
  BitMatrix ones = all_ones(n_rows, 1), m(n_rows, n_columns);
  for (std::size_t j = 0; j < n_columns; ++j) {
    const Words from = basis.column(rng.below(static_cast<std::uint32_t>(n_distinct)));
    const bool complement = rng.below(2) == 1;
    for (std::size_t w = 0; w < from.size(); ++w) m.column(j)[w] = complement ? ~from[w] & ones.column(0)[w] : from[w];
  }
  return m;
}

/// Shadows on a patch of 32 x 32 rows in Z-order. Lights stand in a cone of directions and are sorted along a Z-curve,
/// so neighbouring columns have nearby shadow boundaries.
struct ShadowScene {
  struct Disc {
    Vec3 centre, normal;
    float radius;
  };
  struct HalfPlane {
    float z, x;  ///< blocks at height z everywhere beyond x
  };
  std::vector<Disc> discs;
  std::vector<HalfPlane> half_planes;
  float bumps = 0;  ///< height of the patch's waves: 0 makes every entry active
  std::size_t n_columns = 256;
  float light_spread = 4;  ///< half extent of the square of lights around (1.2, 1.2)

  static constexpr std::size_t kRows = 1024;

  bool occluded(Vec3 a, Vec3 b) const {
    for (const Disc& d : discs) {
      const float na = dot(d.normal, a - d.centre), nb = dot(d.normal, b - d.centre);
      if ((na > 0) != (nb > 0) && length(a + (b - a) * (na / (na - nb)) - d.centre) < d.radius) return true;
    }
    for (const HalfPlane& h : half_planes)
      if ((a.z > h.z) != (b.z > h.z) && (a + (b - a) * ((h.z - a.z) / (b.z - a.z))).x > h.x) return true;
    return false;
  }

  KnownEntries entries(Rng& rng) const {
    const auto even_bits = [](std::size_t k) {  // one coordinate of place k on the Z-curve
      std::size_t r = 0;
      for (int bit = 0; bit < 16; ++bit) r |= (k >> (2 * bit) & 1) << bit;
      return static_cast<float>(r);
    };
    std::vector<Vec3> p(kRows), n(kRows);
    for (std::size_t i = 0; i < kRows; ++i) {
      const float x = (even_bits(i) + 0.5f) / 16 - 1, y = (even_bits(i >> 1) + 0.5f) / 16 - 1;
      p[i] = {x, y, bumps * std::sin(4 * x) * std::cos(3 * y)};
      n[i] =
          normalize({-4 * bumps * std::cos(4 * x) * std::cos(3 * y), 3 * bumps * std::sin(4 * x) * std::sin(3 * y), 1});
    }
    BitMatrix truth(kRows, n_columns), active(kRows, n_columns);
    const float side = std::ceil(std::sqrt(static_cast<float>(n_columns)));
    for (std::size_t j = 0; j < n_columns; ++j) {
      const Vec3 light{((even_bits(j) + rng.next()) / side * 2 - 1) * light_spread + 1.2f,
                       ((even_bits(j >> 1) + rng.next()) / side * 2 - 1) * light_spread + 1.2f,
                       bumps > 0 ? 0.4f + 2 * rng.next() : 2.5f};
      const Vec3 light_normal = normalize(Vec3{rng.next() - 0.5f, rng.next() - 0.5f, -0.7f});
      for (std::size_t i = 0; i < kRows; ++i) {
        const Vec3 d = light - p[i];
        if (bumps > 0 && !(dot(n[i], d) > 0 && dot(light_normal, d) < 0)) continue;
        active.set(i, j);
        if (!occluded(p[i], light)) truth.set(i, j);
      }
    }
    return {truth, active};
  }
};

inline ShadowScene two_discs() {
  return {.discs = {{{0.3f, 0.2f, 0.8f}, {0, 0, 1}, 0.35f}, {{0.9f, 0.7f, 1.2f}, {0.6f, 0, 0.8f}, 0.25f}},
          .half_planes = {}};
}
inline ShadowScene half_plane() { return {.discs = {}, .half_planes = {{1.0f, 0.4f}}}; }
inline ShadowScene bumpy(ShadowScene scene, float height = 0.35f) {
  scene.bumps = height;
  return scene;
}

/// Wrong bits among the active entries, by the kind of harm: light leaks and dark patches.
struct WrongBits {
  std::size_t active = 0, false_visible = 0, false_occluded = 0;
  double visible_rate() const { return static_cast<double>(false_visible) / static_cast<double>(active); }
  double occluded_rate() const { return static_cast<double>(false_occluded) / static_cast<double>(active); }
  double rate() const { return visible_rate() + occluded_rate(); }
};
inline WrongBits count_wrong(const KnownEntries& known, const BitMatrix& visible) {
  WrongBits n;
  for (std::size_t j = 0; j < known.n_columns(); ++j)
    for (std::size_t w = 0; w < visible.words_per_column(); ++w) {
      const std::uint64_t active = known.active(j)[w], truth = known.truth().column(j)[w], got = visible.column(j)[w];
      n.active += static_cast<std::size_t>(std::popcount(active));
      n.false_visible += static_cast<std::size_t>(std::popcount(got & ~truth & active));
      n.false_occluded += static_cast<std::size_t>(std::popcount(~got & truth & active));
    }
  return n;
}

}  // namespace myrialux::test
