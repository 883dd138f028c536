// Evaluates wide lobes, a vector of pairs at a time: f * |cos v| with everything of the fixed direction folded into the
// fields. Included once for each instruction set. Formulas as in scattering/, which follows Mitsuba 3; GGX and
// Beckmann after [walter07], Blinn-Phong after [blinn77], written with an unnormalised half vector and fractions that
// are multiplied out, so that one division serves D, G1 and Fresnel's reflectance.
#include "myrialux/kernels/lobes.h"
#include "myrialux/kernels/targets.h"
// Order matters: targets.h before Highway.
#include "hwy/contrib/math/math-inl.h"
#include "myrialux/kernels/vec3-inl.h"

#if defined(MYRIALUX_KERNELS_LOBES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef MYRIALUX_KERNELS_LOBES_INL
#undef MYRIALUX_KERNELS_LOBES_INL
#else
#define MYRIALUX_KERNELS_LOBES_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace myrialux {
namespace HWY_NAMESPACE {

/// Fields of rows that start at `row`: a value a lane.
struct RowFields {
  const BlockFloats* field;
  std::size_t row;
  const float* tables;
  const float* common_table;  ///< of all rows that are evaluated; null if theirs differ
  V operator()(D d, std::size_t k) const { return hn::Load(d, field[k] + row); }
};
/// Fields of one light: the same value in all lanes.
struct SameFields {
  const float* field;
  const float* tables;
  const float* common_table;
  V operator()(D d, std::size_t k) const { return hn::Set(d, field[k]); }
};
inline SameFields same_fields(const LightLobes& lobes, const float* tables) {
  const float* field = lobes.field.data();
  return {field, tables, tables + static_cast<std::size_t>(field[kFieldTable])};
}
/// The table of the rows of `bits` from `row` on, if they share one.
inline const float* common_table(const RowLobes& lobes, std::uint64_t bits, std::size_t row, const float* tables) {
  const float* first = nullptr;
  for (std::size_t k = row; k < row + hn::Lanes(D()); ++k) {
    if (!(bits >> k & 1)) continue;
    const float* table = tables + static_cast<std::size_t>(lobes.field[kFieldTable][k]);
    if (first && table != first) return nullptr;
    first = table;
  }
  return first;
}
template <class Fields>
HWY_INLINE V3 field3(D d, const Fields& f, std::size_t k) {
  return {f(d, k), f(d, k + 1), f(d, k + 2)};
}

/// A fraction that is not yet divided: factors are gathered so that one division serves all.
struct Ratio {
  V above, below;
};
HWY_INLINE V value(D d, Ratio r) { return hn::Div(r.above, hn::Max(r.below, hn::Set(d, 1e-37f))); }

/// above / root_below^2.
struct Reflectance {
  V above, root_below;
};
/// Of a smooth dielectric. @param h2 4 cos^2, which is |o + v|^2 where the half vector reflects; roundings beyond 4 do
/// no harm With c = cos^2 and e = eta^2, Fresnel's two terms over a common denominator are
///   (1 + (e - 3) c + 2 c^2) / (1 + (e + 1) / (e - 1) (c + sqrt(c (c + e - 1))))^2,
/// so that one root is all it takes; nothing cancels. Below 0 under the root reflection is total.
template <class Fields>
HWY_INLINE Reflectance fresnel(D d, const Fields& f, V h2) {
  const V one = hn::Set(d, 1.0f);
  const V beyond = hn::Add(h2, f(d, kFieldFresnel + 1));
  const V above = hn::MulAdd(h2, hn::MulAdd(h2, hn::Set(d, 0.125f), f(d, kFieldFresnel)), one);
  const V below = hn::MulAdd(f(d, kFieldFresnel + 2), hn::Add(hn::Sqrt(hn::Mul(h2, beyond)), h2), one);
  const Mask total = hn::Le(beyond, hn::Zero(d));
  if (HWY_LIKELY(hn::AllFalse(d, total))) return {above, below};
  return {hn::IfThenElse(total, one, above), hn::IfThenElse(total, one, below)};
}

/// Reflectance of a conductor in one channel. @param cos2 squared cosine
HWY_INLINE V fresnel_metal(D d, V cos2, V eta, V k) {
  const V one = hn::Set(d, 1.0f), zero = hn::Zero(d), two = hn::Set(d, 2.0f);
  const V sin2 = hn::Sub(one, cos2);
  const V t0 = hn::Sub(hn::MulSub(eta, eta, hn::Mul(k, k)), sin2);
  const V ek = hn::Add(hn::Mul(eta, k), hn::Mul(eta, k));
  const V a2_b2 = hn::Sqrt(hn::MulAdd(t0, t0, hn::Mul(ek, ek)));
  const V t1 = hn::Add(a2_b2, cos2);
  const V t2 = hn::Sqrt(hn::Max(hn::Mul(hn::Mul(two, cos2), hn::Add(a2_b2, t0)), zero));
  const V t3 = hn::MulAdd(a2_b2, cos2, hn::Mul(sin2, sin2)), t4 = hn::Mul(t2, sin2);
  // (rs + rp) / 2 = rs * t3 / (t3 + t4)
  return hn::Div(hn::Mul(hn::Sub(t1, t2), t3), hn::Mul(hn::Add(t1, t2), hn::Add(t3, t4)));
}

#if HWY_TARGET <= HWY_AVX3
/// table[node % 64] for vectors of 16: the table fits four of them, and sorting out lanes takes a quarter of the time
/// of GatherIndex().
HWY_INLINE V look_up_16(D d, const float* table, hn::Vec<hn::RebindToSigned<D>> node) {
  const auto half = [&](std::size_t h) {  // the instruction looks at the lowest five bits
    const V low = hn::LoadU(d, table + 32 * h), high = hn::LoadU(d, table + 32 * h + 16);
    return V{_mm512_permutex2var_ps(low.raw, node.raw, high.raw)};
  };
  const hn::RebindToSigned<D> di;
  const Mask upper = hn::RebindMask(d, hn::TestBit(node, hn::Set(di, 32)));
  return hn::IfThenElse(upper, half(1), half(0));
}
#endif

/// Transmittance of a rough coat at cosine cos_v > 0, linear between the nodes of its table.
template <class Fields>
HWY_INLINE V coat_transmittance(D d, const Fields& f, V cos_v) {
  const hn::RebindToSigned<D> di;
  constexpr float kLast = static_cast<float>(kTableNodes - 1);
  const V half = hn::Set(d, 0.5f), shift = hn::Set(d, 0x1.8p23f);
  // The interval is the nearest whole number to what lies half an interval below: once 1.5 * 2^23 is added, the lowest
  // bits tell it.
  const V x = hn::Min(hn::MulSub(cos_v, hn::Set(d, kLast), half), hn::Set(d, kLast - 0.5f));
#if HWY_TARGET <= HWY_AVX3
  if (f.common_table) {
    const V shifted = hn::Add(x, shift);
    const auto node = hn::BitCast(di, shifted);
    const V slope = look_up_16(d, f.common_table + kTableNodes, node);
    return hn::MulAdd(hn::Sub(x, hn::Sub(shifted, shift)), slope, look_up_16(d, f.common_table, node));
  }
#endif
  const V shifted = hn::Add(hn::Max(x, hn::Zero(d)), shift);  // the cosine may be negative where all is dark
  const auto node = hn::Sub(hn::BitCast(di, shifted), hn::BitCast(di, shift));
  const auto at = hn::Add(node, hn::ConvertTo(di, f(d, kFieldTable)));
  const V slope = hn::GatherIndex(d, f.tables + kTableNodes, at);
  return hn::MulAdd(hn::Sub(x, hn::Sub(shifted, shift)), slope, hn::GatherIndex(d, f.tables, at));
}

/// The half vector, of any length: what of it lies along the normal, and the squares.
struct Half {
  V z, z2, side2, length2;
};
/// @param h o + v or a multiple; @param z its part along the normal. The part along the surface is made before it is
/// squared, so that nothing cancels.
template <class Fields>
HWY_INLINE Half half_vector(D d, const Fields& f, V3 h, V z) {
  const V3 n = field3(d, f, kFieldN);
  const V3 side = {hn::NegMulAdd(z, n.x, h.x), hn::NegMulAdd(z, n.y, h.y), hn::NegMulAdd(z, n.z, h.z)};
  const V z2 = hn::Mul(z, z), side2 = dot(side, side);
  return {z, z2, side2, hn::Add(z2, side2)};
}

/// D(h) G1(v) / |h|^4 but for its constant factor, 2 alpha^2 / pi (GGX) or 1 / (pi alpha^2), which is part of the
/// colours; divided by |cos v| where kOverCos. above / (root_below^2 below).
struct Facets {
  V above, root_below, below;
};
/// @param vz |cos v| > 0
template <bool kGgx, bool kOverCos, class Fields>
HWY_INLINE Facets microfacets(D d, const Fields& f, const Half& h, V vz) {
  const V one = hn::Set(d, 1.0f), alpha2 = f(d, kFieldAlpha2);
  if constexpr (kGgx) {
    const V root = hn::Sqrt(hn::MulAdd(hn::Mul(vz, vz), f(d, kFieldOneLessAlpha2), alpha2));
    return {kOverCos ? one : vz, hn::MulAdd(alpha2, h.z2, h.side2), hn::Add(vz, root)};
  } else {
    const V z2 = hn::Max(h.z2, hn::Set(d, 1e-15f)), v_side2 = hn::Max(hn::NegMulAdd(vz, vz, one), hn::Zero(d));
    const V distribution = hn::Exp(d, hn::Neg(hn::Div(h.side2, hn::Mul(alpha2, z2))));
    // Rational fit of Smith's function [walter07, eq. 27]; exactly 1 from 1.6 on.
    const V s = hn::Sqrt(hn::Mul(alpha2, v_side2)), a = hn::Div(vz, hn::Max(s, hn::Set(d, 1e-20f)));
    const V above = hn::Mul(a, hn::MulAdd(a, hn::Set(d, 2.181f), hn::Set(d, 3.535f)));
    const V below = hn::MulAdd(a, hn::MulAdd(a, hn::Set(d, 2.577f), hn::Set(d, 2.276f)), one);
    const Mask whole = hn::Ge(a, hn::Set(d, 1.6f));
    const V rest = hn::IfThenElse(whole, one, below);
    return {hn::Mul(distribution, hn::IfThenElse(whole, one, above)), z2, kOverCos ? hn::Mul(rest, vz) : rest};
  }
}

/// above / below; 0 where both are too small for a float.
HWY_INLINE V quotient(D d, V above, V below) { return hn::Div(above, hn::Max(below, hn::Set(d, 1e-37f))); }
/// The product of all but what is above the line of the reflectance.
HWY_INLINE V below_both(const Facets& facets, const Reflectance& reflected) {
  const V root = hn::Mul(facets.root_below, reflected.root_below);
  return hn::Mul(hn::Mul(root, root), facets.below);
}

/// f * |cos v|, or f alone where kOverCos. @param w v in world space, unit; @param side of its sign: v . ng, ng on the
/// side of o. Lanes in which the entry is zero by its sides are cleared in `live`; their values may be anything, NaN
/// included.
template <LobeKind kKind, bool kGgx, bool kOverCos, class Fields>
HWY_INLINE V3 evaluate_lobes(D d, const Fields& f, V3 w, V side, Mask& live) {
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const V vz = dot(w, field3(d, f, kFieldN)), cosine = kOverCos ? one : vz;
  if constexpr (kKind != LobeKind::dielectric) live = hn::And(live, hn::And(hn::Gt(vz, zero), hn::Gt(side, zero)));
  const V3 base = field3(d, f, kFieldBase);
  if constexpr (kKind == LobeKind::diffuse) return kOverCos ? base : base * vz;
  if constexpr (kKind == LobeKind::coated) {
    const Reflectance reflected = fresnel(d, f, hn::Mul(hn::Set(d, 4.0f), hn::Mul(vz, vz)));
    const V below = hn::Mul(reflected.root_below, reflected.root_below);
    return base * hn::Mul(cosine, hn::Div(hn::Sub(below, reflected.above), below));
  }
  const V3 o = field3(d, f, kFieldO), gloss = field3(d, f, kFieldGloss);
  if constexpr (kKind == LobeKind::dielectric) {
    // Above o's side the half vector reflects, below it refracts [walter07, eq. 16].
    live = hn::And(live, hn::Gt(hn::Mul(side, vz), zero));
    const Mask is_above = hn::Gt(vz, zero);
    const V scale = hn::IfThenElse(is_above, one, f(d, kFieldEta));
    const V3 to_half = add_scaled(o, scale, w);
    const V oh = dot(o, to_half), vh = dot(w, to_half);
    Half h = half_vector(d, f, to_half, hn::MulAdd(scale, vz, f(d, kFieldCosO)));
    h.length2 = hn::Max(h.length2, hn::Set(d, 1e-20f));
    const Reflectance reflected = fresnel(d, f, hn::Div(hn::Mul(hn::Set(d, 4.0f), hn::Mul(oh, oh)), h.length2));
    const Facets facets = microfacets<kGgx, kOverCos>(d, f, h, hn::Max(hn::Abs(vz), hn::Set(d, 1e-12f)));
    // Both directions must see the front of the microfacet.
    live = hn::And(live, hn::Or(is_above, hn::And(hn::Gt(hn::Mul(oh, h.z), zero), hn::Lt(hn::Mul(vh, h.z), zero))));
    const V up = hn::Mul(reflected.above, hn::Mul(h.length2, h.length2));
    const V passed = hn::MulSub(reflected.root_below, reflected.root_below, reflected.above);
    const V down = hn::Mul(passed, hn::Abs(hn::Mul(oh, vh)));
    const V both =
        quotient(d, hn::Mul(facets.above, hn::IfThenElse(is_above, up, down)), below_both(facets, reflected));
    const V3 pass = field3(d, f, kFieldPass);
    return V3{hn::IfThenElse(is_above, gloss.x, pass.x), hn::IfThenElse(is_above, gloss.y, pass.y),
              hn::IfThenElse(is_above, gloss.z, pass.z)} *
           both;
  }
  const Half h = half_vector(d, f, o + w, hn::Add(vz, f(d, kFieldCosO)));
  if constexpr (kKind == LobeKind::blinn_phong) {
    const V tan2 = hn::Div(h.side2, hn::Max(h.z2, hn::Set(d, 1e-30f)));
    const V shine = hn::Exp(d, hn::Neg(hn::Mul(f(d, kFieldHalfExponent), hn::Log1p(d, tan2))));
    const V3 sum = add_scaled(base, shine, gloss);
    return kOverCos ? sum : sum * vz;
  }
  const Facets facets = microfacets<kGgx, kOverCos>(d, f, h, vz);
  const V above = hn::Mul(hn::Mul(h.length2, h.length2), facets.above);
  if constexpr (kKind == LobeKind::conductor) {
    const V root = facets.root_below, shine = quotient(d, above, hn::Mul(hn::Mul(root, root), facets.below));
    const V3 e = field3(d, f, kFieldEtaMetal), k = field3(d, f, kFieldKMetal);
    const V cos2_oh = hn::Mul(hn::Set(d, 0.25f), h.length2);  // |o + v|^2 / 4
    return gloss * V3{hn::Mul(shine, fresnel_metal(d, cos2_oh, e.x, k.x)),
                      hn::Mul(shine, fresnel_metal(d, cos2_oh, e.y, k.y)),
                      hn::Mul(shine, fresnel_metal(d, cos2_oh, e.z, k.z))};
  }
  const Reflectance reflected = fresnel(d, f, h.length2);
  const V shine = quotient(d, hn::Mul(above, reflected.above), below_both(facets, reflected));
  const V body = hn::Mul(cosine, coat_transmittance(d, f, vz));
  return add_scaled(gloss * shine, body, base);
}

}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();
#endif
