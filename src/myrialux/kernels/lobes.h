// Wide lobes of a surface with one direction fixed, as flat numbers for kernels: a receiver's fixed direction leads to
// the viewer, a glossy light's to where its power came from. The other direction varies from pair to pair.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "myrialux/kernels/shade_block.h"

namespace myrialux {

/// What is evaluated; o is the fixed direction, v the other one, z the normal on o's side. Lobes have no direction
/// along the surface, so that no tangents are needed. All values are f * |cos v|. D, G1, F: distribution of
/// microfacets, its shadowing, Fresnel reflectance.
enum class LobeKind : std::uint8_t {
  diffuse,      ///< base * cos v
  coated,       ///< base * cos v * (1 - F(v)): diffuse under a smooth coat
  plastic,      ///< base * cos v * transmittance(v) + gloss * D G1(v) F
  conductor,    ///< gloss * D G1(v) * (metal's F)
  blinn_phong,  ///< (base + gloss cos^n(h)) cos v
  dielectric,   ///< gloss * D G1(v) F above, pass * D G1(v) (1 - F) |o.h v.h| / |o + eta v|^2 below
};
inline constexpr std::size_t kLobeKinds = 6;

enum LobeField : std::size_t {
  kFieldN = 0,          ///< 3: normal z, world
  kFieldO = 3,          ///< 3: fixed direction, world
  kFieldCosO = 6,       ///< its cosine to the normal, > 0
  kFieldBase = 7,       ///< 3: diffuse colour, with all factors that do not vary
  kFieldGloss = 10,     ///< 3: specular colour * G1(o) / (4 cos o), times what does not vary of D; Blinn-Phong: * peak
  kFieldPass = 13,      ///< 3: transmitted colour * G1(o) / cos o, times the same (times eta^2 for a light)
  kFieldEtaMetal = 16,  ///< 3
  kFieldKMetal = 19,    ///< 3
  kFieldAlpha2 = 22,    ///< roughness, squared
  kFieldOneLessAlpha2 = 23,
  kFieldEta = 24,           ///< index of the far side over that of o's side
  kFieldFresnel = 25,       ///< 3: (eta^2 - 3) / 4, 4 (eta^2 - 1), (eta^2 + 1) / (4 (eta^2 - 1))
  kFieldTable = 28,         ///< plastic: where its transmittances start in the array of tables, a whole number
  kFieldHalfExponent = 29,  ///< Blinn-Phong: n / 2
  kLobeFields = 30
};
/// Transmittances at cosines k / 63, linear between. A table is twice as long: first the transmittances in the middle
/// of each interval, then what they gain from its beginning to its end.
inline constexpr std::size_t kTableNodes = 64, kTableFloats = 2 * kTableNodes;

/// Index of a set of lobes that one loop serves: kind and distribution.
struct LobeClass {
  LobeKind kind = LobeKind::diffuse;
  bool ggx = false;  ///< else Beckmann; no difference for diffuse, coated and Blinn-Phong
  bool operator==(const LobeClass&) const = default;
};
inline constexpr std::size_t kLobeClasses = 2 * kLobeKinds;
constexpr std::size_t lobe_class_index(LobeClass c) { return 2 * static_cast<std::size_t>(c.kind) + c.ggx; }
constexpr LobeClass lobe_class(std::size_t index) { return {static_cast<LobeKind>(index / 2), index % 2 == 1}; }

/// Lobes of one glossy light: colours times the light's own, n and o turned round, so that v may lead to the light.
struct LightLobes {
  LobeClass lobe_class;
  std::array<float, kLobeFields> field{};
};

/// Lobes of the rows of a block.
struct alignas(64) RowLobes {
  BlockFloats field[kLobeFields];                  ///< first, so that all are aligned
  std::array<std::uint64_t, kLobeClasses> rows{};  ///< bits, by lobe_class_index()
};

}  // namespace myrialux
