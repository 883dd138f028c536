// What arrives at the rows of a block from one light, unoccluded: direction and irradiance on a facing surface.
// Included once for each instruction set.
#include "myrialux/kernels/shade_general.h"
#include "myrialux/kernels/targets.h"
// Order matters: targets.h before Highway.
#include "myrialux/kernels/lobes-inl.h"

#if defined(MYRIALUX_KERNELS_INCIDENT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MYRIALUX_KERNELS_INCIDENT_INL
#undef MYRIALUX_KERNELS_INCIDENT_INL
#else
#define MYRIALUX_KERNELS_INCIDENT_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {

struct alignas(64) Incident {
  BlockFloats w[3];    ///< unit, towards the light
  BlockFloats rgb[3];  ///< W m^-2, clamped; 0 where the light does not send to the row
  BlockFloats side;    ///< of its sign: w . ng of the row
  BlockFloats excess;  ///< unclamped over clamped, less 1; only of tracked rows where there is clamping
};

/// Whether what clamping takes from the vector that starts at `row` is summed.
HWY_INLINE bool is_tracked(const GeneralRun& run, std::size_t row) {
  return run.clamp_distance > 0 && (run.tracked >> row & 1);
}

/// Calls visitor.visit<kind, ggx>() for the class.
template <class Visitor>
HWY_INLINE void visit_class(LobeClass c, const Visitor& visitor) {
  switch (c.kind) {
    case LobeKind::diffuse:
      return visitor.template visit<LobeKind::diffuse, false>();
    case LobeKind::coated:
      return visitor.template visit<LobeKind::coated, false>();
    case LobeKind::plastic:
      return c.ggx ? visitor.template visit<LobeKind::plastic, true>()
                   : visitor.template visit<LobeKind::plastic, false>();
    case LobeKind::blinn_phong:
      return visitor.template visit<LobeKind::blinn_phong, false>();
    case LobeKind::conductor:
      return c.ggx ? visitor.template visit<LobeKind::conductor, true>()
                   : visitor.template visit<LobeKind::conductor, false>();
    case LobeKind::dielectric:
      return c.ggx ? visitor.template visit<LobeKind::dielectric, true>()
                   : visitor.template visit<LobeKind::dielectric, false>();
  }
}

/// Linear in the angle between beam and cutoff.
HWY_INLINE V spot_falloff(D d, const SpotCone& spot, V cos_axis) {
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const V inside = hn::Max(hn::Min(cos_axis, one), hn::Set(d, spot.cos_cutoff));
  const V fall = hn::Mul(hn::Sub(hn::Set(d, spot.cutoff), hn::Acos(d, inside)), hn::Set(d, spot.inverse_width));
  const V held = hn::Max(hn::Min(fall, one), zero);
  return hn::IfThenElse(hn::Ge(cos_axis, hn::Set(d, spot.cos_beam)), one,
                        hn::IfThenZeroElse(hn::Le(cos_axis, hn::Set(d, spot.cos_cutoff)), held));
}

/// Irradiance of each row on a facing surface. @param w towards the light, d / |d|; @param side -d . ng of the light,
/// exact in its sign; @param scale of the intensity: 1 / d^2, clamped
template <LightShape kShape>
HWY_INLINE V3 irradiance(D d, const GeneralRun& run, const GeneralLight& light, V3 w, V side, V scale) {
  const V zero = hn::Zero(d);
  V factor = scale;
  if constexpr (kShape == LightShape::oriented) {
    const V cosine = hn::Max(hn::Neg(dot(spread(d, light.at.n), w)), zero);
    factor = hn::IfThenElseZero(hn::Gt(side, zero), hn::Mul(cosine, scale));
  } else if constexpr (kShape == LightShape::spot) {
    const V cos_axis = hn::Neg(dot(spread(d, light.at.n), w));
    factor = hn::Mul(spot_falloff(d, run.spots[light.extra], cos_axis), scale);
  }
  return spread(d, light.at.rgb) * factor;
}

/// The rows that a glossy light's lobes are still to be evaluated for: `w` is set, and in place of `rgb` what they
/// need.
enum BeforeLobes : std::size_t {
  kLightSide,        ///< -d . ng of the light, exact in its sign
  kInverseDistance,  ///< 1 / |d|
  kScale,            ///< 1 / d^2, clamped
};

/// Evaluates the lobes of a glossy light in a loop of its own: each loop's chain of operations is then short enough
/// that several vectors are under way at a time.
template <LobeKind kKind, bool kGgx>
void shine_on_rows(const GeneralRun& run, const GeneralLight& light, std::uint64_t bits, Incident& out) {
  const D d;
  // The lobes hold the light's colour, and directions from the light turned round.
  const SameFields fields = same_fields(run.lobes[light.extra], run.tables.data());
  for (std::size_t row = 0; row < kBlockRows; row += hn::Lanes(d)) {
    if (!has_rows(bits, row)) continue;
    const V side = hn::Load(d, out.rgb[kLightSide] + row), scale = hn::Load(d, out.rgb[kScale] + row);
    Mask live = hn::Eq(side, side);
    const V3 f = evaluate_lobes<kKind, kGgx, /*kOverCos=*/true>(d, fields, load(d, out.w, row), side, live);
    // An intensity has the cosine to the geometric normal.
    const V cos_ng = hn::Mul(hn::Mul(hn::Abs(side), hn::Load(d, out.rgb[kInverseDistance] + row)), scale);
    store(d,
          {hn::IfThenElseZero(live, hn::Mul(f.x, cos_ng)), hn::IfThenElseZero(live, hn::Mul(f.y, cos_ng)),
           hn::IfThenElseZero(live, hn::Mul(f.z, cos_ng))},
          out.rgb, row);
  }
}

/// @param bits rows wanted; vectors of rows without any are left as they are
template <LightShape kShape>
void light_rows(const RowBlock& rows, const GeneralRun& run, const GeneralLight& light, std::uint64_t bits,
                Incident& out) {
  const D d;
  const V least = hn::Set(d, kLeastSquaredDistance), one = hn::Set(d, 1.0f);
  const V bound = hn::Set(d, inverse_squared_clamp(run.clamp_distance));
  for (std::size_t row = 0; row < kBlockRows; row += hn::Lanes(d)) {
    if (!has_rows(bits, row)) continue;
    const V3 ng = load(d, rows.ng, row);
    V3 rgb, w;
    if constexpr (kShape == LightShape::directional) {
      const V3 n = spread(d, light.at.n);
      w = {hn::Neg(n.x), hn::Neg(n.y), hn::Neg(n.z)};
      rgb = spread(d, light.at.rgb);
      hn::Store(dot_unfused(w, ng), d, out.side + row);
      hn::Store(hn::Zero(d), d, out.excess + row);
    } else {
      const V3 to_light = spread(d, light.at.p) - load(d, rows.p, row);
      const V inverse = hn::Div(one, hn::Max(dot(to_light, to_light), least)), clamped = hn::Min(inverse, bound);
      const V inverse_distance = hn::Sqrt(inverse);
      w = to_light * inverse_distance;
      const V light_side = hn::Neg(dot_unfused(to_light, spread(d, light.at.ng)));
      if constexpr (kShape == LightShape::glossy)
        rgb = {light_side, inverse_distance, clamped};
      else
        rgb = irradiance<kShape>(d, run, light, w, light_side, clamped);
      hn::Store(dot_unfused(to_light, ng), d, out.side + row);
      if (is_tracked(run, row)) hn::Store(hn::Sub(hn::Div(inverse, clamped), one), d, out.excess + row);
    }
    store(d, w, out.w, row);
    store(d, rgb, out.rgb, row);
  }
}

struct GlossyLightVisitor {
  const GeneralRun& run;
  const GeneralLight& light;
  std::uint64_t bits;
  Incident& out;
  template <LobeKind kKind, bool kGgx>
  void visit() const {
    shine_on_rows<kKind, kGgx>(run, light, bits, out);
  }
};

inline void find_incident(const RowBlock& rows, const GeneralRun& run, const GeneralLight& light, std::uint64_t bits,
                          Incident& out) {
  switch (light.shape) {
    case LightShape::oriented:
      return light_rows<LightShape::oriented>(rows, run, light, bits, out);
    case LightShape::point:
      return light_rows<LightShape::point>(rows, run, light, bits, out);
    case LightShape::directional:
      return light_rows<LightShape::directional>(rows, run, light, bits, out);
    case LightShape::spot:
      return light_rows<LightShape::spot>(rows, run, light, bits, out);
    case LightShape::glossy:
      light_rows<LightShape::glossy>(rows, run, light, bits, out);
      return visit_class(run.lobes[light.extra].lobe_class, GlossyLightVisitor{run, light, bits, out});
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();
#endif
