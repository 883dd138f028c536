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

/// Reflectance of a smooth dielectric. @param cos2_i squared cosine; roundings beyond 1 do no harm
/// With t the cosine behind, r_s^2 + r_p^2 over a common denominator is 2 (x^2 + y^2), where
/// x = (1 - eta^2) cos t and y = (eta - 1 / eta) sin^2: nothing cancels, and cos t takes one root.
template <class Fields>
HWY_INLINE Ratio fresnel(D d, const Fields& f, V cos2_i) {
  const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  const V sin2 = hn::Sub(one, cos2_i), t2 = hn::NegMulAdd(sin2, f(d, kFieldInverseEta2), one);
  const Mask total = hn::Le(t2, zero);
  const V cos_t = hn::Sqrt(hn::Mul(cos2_i, hn::Max(t2, zero)));
  const V x = hn::Mul(cos_t, f(d, kFieldFresnel)), y = hn::Mul(sin2, f(d, kFieldFresnel + 1));
  const V below = hn::MulAdd(f(d, kFieldEta), hn::Add(cos2_i, t2), hn::Mul(cos_t, f(d, kFieldFresnel + 2)));
  return {hn::IfThenElse(total, one, hn::MulAdd(x, x, hn::Mul(y, y))),
          hn::IfThenElse(total, one, hn::Mul(below, below))};
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
/// table[node % 64] for vectors of 16: the table fits four of them, and sorting out lanes takes a quarter of the time of
/// GatherIndex().
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
  const V half = hn::Set(d, 0.5f), last = hn::Set(d, static_cast<float>(kTableNodes) - 1.5f);
  const V shift = hn::Set(d, 0x1.8p23f);
  // The nearest whole number to what lies half a node below: added to 1.5 * 2^23, it is what the lowest bits say.
  const V middle = hn::Max(hn::Min(hn::MulSub(cos_v, hn::Set(d, static_cast<float>(kTableNodes - 1)), half), last),
                           hn::Neg(half));
  const V shifted = hn::Add(middle, shift);
  const auto node = hn::Sub(hn::BitCast(di, shifted), hn::BitCast(di, shift));
  const V t = hn::Add(hn::Sub(middle, hn::Sub(shifted, shift)), half);
#if HWY_TARGET <= HWY_AVX3
  if (f.common_table) {
    const V below = look_up_16(d, f.common_table, node);
    const V above = look_up_16(d, f.common_table, hn::Add(node, hn::Set(di, 1)));
    return hn::MulAdd(t, hn::Sub(above, below), below);
  }
#endif
  const auto at = hn::Add(node, hn::ConvertTo(di, f(d, kFieldTable)));
  const V below = hn::GatherIndex(d, f.tables, at), above = hn::GatherIndex(d, f.tables + 1, at);
  return hn::MulAdd(t, hn::Sub(above, below), below);
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
/// colours; divided by |cos v| where kOverCos. @param vz |cos v| > 0
template <bool kGgx, bool kOverCos>
HWY_INLINE Ratio microfacets(D d, const Half& h, V vz, V alpha2) {
  const V one = hn::Set(d, 1.0f), v_side2 = hn::NegMulAdd(vz, vz, one);
  if constexpr (kGgx) {
    const V q = hn::MulAdd(alpha2, h.z2, h.side2);
    const V root = hn::Sqrt(hn::MulAdd(alpha2, v_side2, hn::Mul(vz, vz)));
    return {kOverCos ? one : vz, hn::Mul(hn::Mul(q, q), hn::Add(vz, root))};
  } else {
    const V z2 = hn::Max(h.z2, hn::Set(d, 1e-15f));
    const V distribution = hn::Exp(d, hn::Neg(hn::Div(h.side2, hn::Mul(alpha2, z2))));
    // Rational fit of Smith's function [walter07, eq. 27]; exactly 1 from 1.6 on.
    const V s = hn::Sqrt(hn::Mul(alpha2, hn::Max(v_side2, hn::Zero(d)))), a = hn::Div(vz, hn::Max(s, hn::Set(d, 1e-20f)));
    const V above = hn::Mul(a, hn::MulAdd(a, hn::Set(d, 2.181f), hn::Set(d, 3.535f)));
    const V below = hn::MulAdd(a, hn::MulAdd(a, hn::Set(d, 2.577f), hn::Set(d, 2.276f)), one);
    const Mask whole = hn::Ge(a, hn::Set(d, 1.6f));
    const V z4 = hn::Mul(hn::Mul(z2, z2), hn::IfThenElse(whole, one, below));
    return {hn::Mul(distribution, hn::IfThenElse(whole, one, above)), kOverCos ? hn::Mul(z4, vz) : z4};
  }
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
    const Ratio reflected = fresnel(d, f, hn::Mul(vz, vz));
    return base * value(d, {hn::Mul(cosine, hn::Sub(reflected.below, reflected.above)), reflected.below});
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
    const Ratio reflected = fresnel(d, f, hn::Div(hn::Mul(oh, oh), h.length2));
    const Ratio dg = microfacets<kGgx, kOverCos>(d, h, hn::Max(hn::Abs(vz), hn::Set(d, 1e-12f)), f(d, kFieldAlpha2));
    // Both directions must see the front of the microfacet.
    live = hn::And(live, hn::Or(is_above, hn::And(hn::Gt(hn::Mul(oh, h.z), zero), hn::Lt(hn::Mul(vh, h.z), zero))));
    const V up = hn::Mul(reflected.above, hn::Mul(h.length2, h.length2));
    const V down = hn::Mul(hn::Sub(reflected.below, reflected.above), hn::Abs(hn::Mul(oh, vh)));
    const V both = value(d, {hn::Mul(dg.above, hn::IfThenElse(is_above, up, down)), hn::Mul(dg.below, reflected.below)});
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
  const V cos2_oh = hn::Mul(hn::Set(d, 0.25f), h.length2);  // |o + v|^2 / 4
  const Ratio dg = microfacets<kGgx, kOverCos>(d, h, vz, f(d, kFieldAlpha2));
  const V above = hn::Mul(dg.above, hn::Mul(h.length2, h.length2));
  if constexpr (kKind == LobeKind::conductor) {
    const V shine = value(d, {above, dg.below});
    const V3 e = field3(d, f, kFieldEtaMetal), k = field3(d, f, kFieldKMetal);
    return gloss * V3{hn::Mul(shine, fresnel_metal(d, cos2_oh, e.x, k.x)),
                      hn::Mul(shine, fresnel_metal(d, cos2_oh, e.y, k.y)),
                      hn::Mul(shine, fresnel_metal(d, cos2_oh, e.z, k.z))};
  }
  const Ratio reflected = fresnel(d, f, cos2_oh);
  const V shine = value(d, {hn::Mul(above, reflected.above), hn::Mul(dg.below, reflected.below)});
  const V body = hn::Mul(cosine, coat_transmittance(d, f, vz));
  return add_scaled(gloss * shine, body, base);
}

}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();
#endif
