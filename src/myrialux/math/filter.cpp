// Weights of the reconstruction filters.
#include "myrialux/math/filter.h"

#include <cmath>

#include "myrialux/math/vec.h"

namespace myrialux {
namespace {

/// Cubic of Mitchell and Netravali with support [-2, 2]. [mitchell88]
float cubic(float x, float b, float c) {
  x = std::fabs(x);
  if (x < 1) return ((12 - 9 * b - 6 * c) * x * x * x + (-18 + 12 * b + 6 * c) * x * x + (6 - 2 * b)) / 6;
  if (x < 2)
    return ((-b - 6 * c) * x * x * x + (6 * b + 30 * c) * x * x + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6;
  return 0;
}

float sinc(float x) { return std::fabs(x) < 1e-5f ? 1 : std::sin(kPi * x) / (kPi * x); }

}  // namespace

float Filter::evaluate(float x) const {
  if (kind == Kind::box) return x >= -radius && x < radius ? 1 : 0;
  if (std::fabs(x) >= radius) return 0;
  switch (kind) {
    case Kind::box:
      break;
    case Kind::tent:
      return 1 - std::fabs(x) / radius;
    case Kind::gaussian: {
      const float k = -1 / (2 * sigma * sigma);
      return std::max(0.0f, std::exp(k * x * x) - std::exp(k * radius * radius));
    }
    case Kind::mitchell:
      return cubic(x * 2 / radius, b, c);
    case Kind::catmullrom:
      return cubic(x * 2 / radius, 0, 0.5f);
    case Kind::lanczos:
      return sinc(x) * sinc(x / radius);
  }
  return 0;
}

}  // namespace myrialux
