// Which lobes of a BSDF a request names, once its kind and roughness are known.
#pragma once

#include "myrialux/scattering/bsdf.h"

namespace myrialux {

/// The parts that take part: the diffuse base, and the coat, lobe, mirror, metal or glass ("gloss").
struct ChosenLobes {
  bool diffuse = false, gloss = false;
  bool any() const { return diffuse || gloss; }
};

inline bool asks_for(Lobes asked, Lobes part) {
  return (static_cast<unsigned>(asked) & static_cast<unsigned>(part)) != 0;
}

inline bool has_diffuse(BsdfKind kind) {
  return kind == BsdfKind::diffuse || kind == BsdfKind::plastic || kind == BsdfKind::rough_plastic ||
         kind == BsdfKind::blinn_phong;
}

/// The glossy part, if any, scatters into single directions.
inline bool is_delta_kind(BsdfKind kind) {
  return kind == BsdfKind::conductor || kind == BsdfKind::plastic || kind == BsdfKind::dielectric ||
         kind == BsdfKind::thin_dielectric || kind == BsdfKind::null;
}

inline ChosenLobes choose_lobes(const Bsdf& bsdf, Lobes asked) {
  return {has_diffuse(bsdf.kind) && asks_for(asked, Lobes::wide),
          bsdf.kind != BsdfKind::diffuse && asks_for(asked, bsdf.sharp_gloss ? Lobes::sharp : Lobes::wide)};
}

/// The wide lobes are a diffuse base and nothing else, alike in all directions.
inline bool is_wide_part_lambertian(const Bsdf& bsdf) {
  return bsdf.kind == BsdfKind::diffuse || (bsdf.kind == BsdfKind::blinn_phong && bsdf.sharp_gloss);
}

inline Vec3 reflect(Vec3 w) { return {-w.x, -w.y, w.z}; }
inline Vec3 reflect(Vec3 w, Vec3 m) { return 2 * dot(w, m) * m - w; }

}  // namespace myrialux
