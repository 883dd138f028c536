// Between two placements of a rigid body: translation linear, rotation by slerp of unit quaternions [shoemake85].
#pragma once

#include "myrialux/math/transform.h"

namespace myrialux {

/// Placement at `share` (0 to 1) of the way from a to b, by the shorter way round. Both are rotations and translations,
/// or both mirrored as well (determinant -1); what a or b is off by rounding is lost. Result: rigid up to rounding.
Transform rigid_between(const Transform& a, const Transform& b, double share);

/// Largest difference of the linear part's Gram matrix from the identity; 0 for rotations and mirrors.
double rigidity_error(const Transform& m);

}  // namespace myrialux
