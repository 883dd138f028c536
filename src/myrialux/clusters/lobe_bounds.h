// Upper bounds of a BSDF's wide lobes when one direction is fixed: three coefficients and the shape of a gloss lobe.
#pragma once

#include "myrialux/scattering/bsdf.h"

namespace myrialux {

/// For every direction w (local frame, other than the fixed one v), per channel,
///   f(w, v) |cos w| <= diffuse * max(cos w, 0) + gloss * shape(t) * [cos w > 0] + any,
///   t = tan^2(psi / 2), psi the angle between w and the mirror direction of v: the half vector leans from the normal
///   by at least psi / 2, and the distribution falls with that angle.
///   shape(t) = (1 + t)^2 / (1 + x (c1 + x (c2 + x c3))), x = t / alpha^2, t not below t_least
/// Microfacet shadowing of the fixed side is part of `gloss`; that of the other side is 1. So is Blinn-Phong's cosine.
struct LobeBounds {
  Rgb diffuse, gloss, any;
  float alpha = 1, c1 = 1, c2 = 0.5f, c3 = 0, t_least = 0;
  bool microfacets = true;  ///< gloss with shadowing, in which |cos w| is cancelled
};

LobeBounds lobe_bounds(const Bsdf& bsdf, Vec3 fixed);

/// Largest ratio of `gloss` and `any` with the geometric cosine |w . ng| in place of |cos w|, which a light's intensity
/// has: shadowing of w makes up for 1 / |cos w| but for the roughness. 1 where the normals agree.
/// @param sine between shading and geometric normal
float geometric_cosine_factor(const LobeBounds& bounds, float sine);

/// Larger than every shape() of alpha up to the argument, for glossy lights of several BSDFs: coefficients c1 = 1,
/// c2 = 1 / 2, c3 = 0. Above this roughness lobes are bounded by their peak alone.
inline constexpr float kLargestShapedAlpha = 0.7f;

/// Largest value of gloss * shape(t) over all t.
Rgb peak_gloss(const LobeBounds& bounds);

}  // namespace myrialux
