// Fresnel reflectances of dielectrics and metals. Sources: [born99], [egan73], [deon11]; tests compare with Mitsuba 3.
#pragma once

#include "myrialux/math/vec.h"

namespace myrialux {

struct DielectricFresnel {
  float reflectance;
  float cos_transmitted;  ///< signed: opposite sign to cos_i; 0 under total reflection
  float eta_it;           ///< index ratio in the direction of travel: transmitted side / incident side
};
/// @param cos_i cosine of the incident direction, > 0 outside; @param eta interior / exterior
DielectricFresnel fresnel_dielectric(float cos_i, float eta);

/// Unpolarised reflectance of a conductor for each channel; cos_i in [0, 1].
Rgb fresnel_conductor(float cos_i, Rgb eta, Rgb k);

/// Cosine-weighted mean reflectance over the hemisphere, for light on the outside of a boundary of index eta
/// (eta < 1: from the inside). Fits of [deon11] and, from the inside, [egan73].
float fresnel_diffuse_reflectance(float eta);

}  // namespace myrialux
