// BSDFs with resolved parameters, in the local frame of the shading normal (z up, wi and wo leave the surface).
// Formulas follow Mitsuba 3's plugins of the same names, so that pictures can be compared; tests compare with it.
// Blinn-Phong is that of MTL files.
#pragma once

#include <cstdint>

#include "myrialux/base/ids.h"
#include "myrialux/math/vec.h"
#include "myrialux/scene/scene.h"

namespace myrialux {

/// Which parts of a BSDF take part. Sharp: delta, or of a roughness below `sharp_alpha`: followed by
/// rays, never joined to virtual lights. Wide: everything else, which virtual lights and receivers use.
enum class Lobes : std::uint8_t { wide = 1, sharp = 2, all = 3 };

/// Roughness below which a glossy lobe counts as sharp. Part of the method's parameters; same for lights and receivers.
inline constexpr float kDefaultSharpAlpha = 0.1f;

/// What a virtual light or receiver keeps of its BSDF: textures are looked up, the rest stays in the material.
struct BsdfParams {
  MaterialId material = kNone<MaterialId>;  ///< after choosing front or back
  float alpha = 0;
  Rgb reflectance;  ///< of the diffuse part; dielectric kinds, which have none, keep their transmittance here
  Rgb specular;
};

/// Ready to evaluate. Isotropic roughness (anisotropic input is averaged by the loader with a warning).
struct Bsdf {
  BsdfKind kind = BsdfKind::diffuse;
  Microfacets distribution = Microfacets::ggx;
  bool nonlinear = false, two_sided = false;
  bool sharp_gloss = false;                         ///< the glossy lobe is delta or alpha < sharp_alpha
  float alpha = 0, eta = 1;                         ///< eta: interior / exterior
  float inverse_eta_squared = 1, fdr_internal = 0;  ///< plastic: diffuse Fresnel reflectance from inside
  float exponent = 0;                               ///< Blinn-Phong; from alpha
  float specular_weight = 0;                 ///< probability of sampling the glossy lobe (plastic: before Fresnel)
  const float* transmittance_row = nullptr;  ///< rough plastic: see rough_transmittance.h; lives with the program
  float transmittance_mix = 0;
  Rgb reflectance, specular, transmittance, eta_metal, k_metal;
};

/// @param params from resolve(); @param sharp_alpha roughness below which gloss counts as sharp
Bsdf make_bsdf(const Material& material, const BsdfParams& params, float sharp_alpha);

/// Looks up all textures at uv. `front`: wo is on the side of the geometric normal.
BsdfParams resolve(const Scene& scene, MaterialId material, Vec2 uv, bool front);

bool has_lobes(const Bsdf& bsdf, Lobes lobes);

/// f(wi, wo) * |cos wi| for the chosen lobes; delta lobes give 0. wo.z > 0 for two-sided materials (caller flips).
/// Radiance transport: refraction includes the factor 1 / eta^2 (light arriving along wi, seen along wo).
Rgb evaluate(const Bsdf& bsdf, Vec3 wi, Vec3 wo, Lobes lobes);

/// Density of sample(bsdf, wo, lobes) per solid angle of wi; delta lobes give 0.
float pdf_omega(const Bsdf& bsdf, Vec3 wi, Vec3 wo, Lobes lobes);

struct BsdfSample {
  Vec3 wi;
  Rgb weight;           ///< f |cos wi| / pdf of the chosen lobes together; 0 = no sample
  float pdf_omega = 0;  ///< 0 for delta
  float eta = 1;        ///< relative index crossed (refraction): >1 into the denser side
  bool is_delta = false, is_sharp = false, is_transmission = false;
};
/// Which transport the weight is for: radiance (camera paths) or importance-adjoint power (light walks), which differ
/// by eta^2 on refraction.
enum class TransportMode : std::uint8_t { radiance, power };
BsdfSample sample(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, Lobes lobes, TransportMode mode);

/// Probability with which a path that reaches this surface goes on through the sharp lobes rather than stopping at the
/// wide ones: the split that receivers and residual paths use. 0 or 1 where only one kind exists.
float sharp_probability(const Bsdf& bsdf, Vec3 wo);

/// Diffuse albedo for the AOV (reflectance, or specular colour at normal incidence), in [0, 1].
Rgb albedo(const Bsdf& bsdf);

}  // namespace myrialux
