// Evaluates wide lobes, a vector of pairs at a time: f * |cos v| with everything of the fixed direction folded into the
// fields. Included once for each instruction set. Formulas as in scattering/, which follows Mitsuba 3; GGX and
// Beckmann after [walter07], Blinn-Phong after [blinn77], written with an unnormalised half vector so that one division
// serves D and G1.
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

/// Reflectance of a smooth dielectric; cos_i in [0, 1], eta: far side over near side.
HWY_INLINE V fresnel(D d, V cos_i, V eta, V inverse_eta) {
  const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  const V sin_t = hn::Mul(hn::Mul(hn::NegMulAdd(cos_i, cos_i, one), inverse_eta), inverse_eta);  // squared
  const V cos_t2 = hn::Sub(one, sin_t);
  const V cos_t = hn::Sqrt(hn::Max(cos_t2, zero));
  const V a = hn::NegMulAdd(eta, cos_t, cos_i), b = hn::MulAdd(eta, cos_t, cos_i);
  const V e = hn::NegMulAdd(eta, cos_i, cos_t), g = hn::MulAdd(eta, cos_i, cos_t);
  const V ag = hn::Mul(a, g), eb = hn::Mul(e, b), bg = hn::Mul(b, g);
  const V both = hn::Div(hn::MulAdd(ag, ag, hn::Mul(eb, eb)), hn::Mul(bg, bg));
  return hn::IfThenElse(hn::Le(cos_t2, zero), one, hn::Mul(hn::Set(d, 0.5f), both));
}

/// Reflectance of a conductor in one channel.
HWY_INLINE V fresnel_metal(D d, V cos_i, V eta, V k) {
  const V one = hn::Set(d, 1.0f), zero = hn::Zero(d), half = hn::Set(d, 0.5f);
  const V cos2 = hn::Mul(cos_i, cos_i), sin2 = hn::Sub(one, cos2);
  const V t0 = hn::Sub(hn::MulSub(eta, eta, hn::Mul(k, k)), sin2);
  const V ek = hn::Add(hn::Mul(eta, k), hn::Mul(eta, k));
  const V a2_b2 = hn::Sqrt(hn::MulAdd(t0, t0, hn::Mul(ek, ek)));
  const V a = hn::Sqrt(hn::Max(hn::Mul(half, hn::Add(a2_b2, t0)), zero));
  const V t1 = hn::Add(a2_b2, cos2), t2 = hn::Mul(hn::Add(cos_i, cos_i), a);
  const V t3 = hn::MulAdd(a2_b2, cos2, hn::Mul(sin2, sin2)), t4 = hn::Mul(t2, sin2);
  // (rs + rp) / 2 = rs * t3 / (t3 + t4)
  return hn::Div(hn::Mul(hn::Sub(t1, t2), t3), hn::Mul(hn::Add(t1, t2), hn::Add(t3, t4)));
}

/// table[node], node in [0, 64) = [0, kTableNodes), for vectors of 16: the table fits four of them, and sorting out
/// lanes takes half the time of GatherIndex().
template <class Nodes>
HWY_INLINE V look_up_16(D d, const float* table, Nodes node) {
  const hn::RebindToSigned<D> di;
  const auto lane = hn::IndicesFromVec(d, hn::And(node, hn::Set(di, 15)));
  const auto quarter = [&](std::size_t q) { return hn::TableLookupLanes(hn::LoadU(d, table + 16 * q), lane); };
  const auto bit = [&](std::int32_t b) { return hn::RebindMask(d, hn::TestBit(node, hn::Set(di, b))); };
  const Mask odd = bit(16);
  return hn::IfThenElse(bit(32), hn::IfThenElse(odd, quarter(3), quarter(2)),
                        hn::IfThenElse(odd, quarter(1), quarter(0)));
}

/// Transmittance of a rough coat at cosine cos_v > 0, linear between the nodes of its table.
template <class Fields>
HWY_INLINE V coat_transmittance(D d, const Fields& f, V cos_v) {
  const hn::RebindToSigned<D> di;
  const V last = hn::Set(d, static_cast<float>(kTableNodes - 1)),
          before = hn::Set(d, static_cast<float>(kTableNodes - 2));
  const V x = hn::Mul(cos_v, last);
  const auto node = hn::ConvertTo(di, hn::Max(hn::Min(x, before), hn::Zero(d)));
  const V t = hn::Sub(x, hn::ConvertTo(d, node));
  if constexpr (hn::MaxLanes(D()) == 16) {
    if (f.common_table) {
      const V below = look_up_16(d, f.common_table, node);
      const V above = look_up_16(d, f.common_table, hn::Add(node, hn::Set(di, 1)));
      return hn::MulAdd(t, hn::Sub(above, below), below);
    }
  }
  const auto at = hn::Add(node, hn::ConvertTo(di, f(d, kFieldTable)));
  const V below = hn::GatherIndex(d, f.tables, at), above = hn::GatherIndex(d, f.tables + 1, at);
  return hn::MulAdd(t, hn::Sub(above, below), below);
}

/// D(h) G1(v) / |h|^4 for h of any length; v: local, its z > 0 taken by absolute value.
template <bool kGgx>
HWY_INLINE V microfacets(D d, V3 h, V3 v, V alpha) {
  const V a2 = hn::Mul(alpha, alpha), vz = hn::Abs(v.z), hz2 = hn::Mul(h.z, h.z);
  const V h_side = hn::MulAdd(h.x, h.x, hn::Mul(h.y, h.y)), v_side = hn::MulAdd(v.x, v.x, hn::Mul(v.y, v.y));
  const V pi = hn::Set(d, 3.14159265f);
  if constexpr (kGgx) {
    const V q = hn::Max(hn::MulAdd(a2, hz2, h_side), hn::Set(d, 1e-16f));
    const V root = hn::Sqrt(hn::MulAdd(a2, v_side, hn::Mul(vz, vz)));
    const V below = hn::Mul(hn::Mul(pi, hn::Mul(q, q)), hn::Max(hn::Add(vz, root), hn::Set(d, 1e-20f)));
    return hn::Div(hn::Mul(a2, hn::Add(vz, vz)), below);
  } else {
    const V one = hn::Set(d, 1.0f), z2 = hn::Max(hz2, hn::Set(d, 1e-15f));
    const V slope = hn::Div(h_side, hn::Mul(a2, z2));
    const V distribution = hn::Div(hn::Exp(d, hn::Neg(slope)), hn::Mul(hn::Mul(pi, a2), hn::Mul(z2, z2)));
    // Rational fit of Smith's function [walter07, eq. 27]; exactly 1 from 1.6 on.
    const V s = hn::Mul(alpha, hn::Sqrt(v_side));
    const V a = hn::Div(vz, hn::Max(s, hn::Set(d, 1e-20f)));
    const V above = hn::Mul(a, hn::MulAdd(a, hn::Set(d, 2.181f), hn::Set(d, 3.535f)));
    const V below = hn::MulAdd(a, hn::MulAdd(a, hn::Set(d, 2.577f), hn::Set(d, 2.276f)), one);
    const V shadowing = hn::IfThenElse(hn::Ge(a, hn::Set(d, 1.6f)), one, hn::Div(above, below));
    return hn::Mul(distribution, shadowing);
  }
}

/// f * |cos v|. @param w v in world space, unit; @param side of its sign: v . ng, ng on the side of o. Lanes in which
/// the entry is zero by its sides are cleared in `live`; their values may be anything, NaN included.
template <LobeKind kKind, bool kGgx, class Fields>
HWY_INLINE V3 evaluate_lobes(D d, const Fields& f, V3 w, V side, Mask& live) {
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const V vz = dot(w, field3(d, f, kFieldN));
  if constexpr (kKind != LobeKind::dielectric) live = hn::And(live, hn::And(hn::Gt(vz, zero), hn::Gt(side, zero)));
  if constexpr (kKind == LobeKind::diffuse) return field3(d, f, kFieldBase) * vz;
  const V eta = f(d, kFieldEta), inverse_eta = f(d, kFieldInverseEta);
  if constexpr (kKind == LobeKind::coated) {
    const V through = hn::Sub(one, fresnel(d, hn::Min(vz, one), eta, inverse_eta));
    return field3(d, f, kFieldBase) * hn::Mul(vz, through);
  }
  const V3 v = {dot(w, field3(d, f, kFieldS)), dot(w, field3(d, f, kFieldT)), vz}, o = field3(d, f, kFieldO);
  const V3 gloss = field3(d, f, kFieldGloss);
  if constexpr (kKind == LobeKind::blinn_phong) {
    const V3 h = o + v;
    const V tan2 = hn::Div(hn::MulAdd(h.x, h.x, hn::Mul(h.y, h.y)), hn::Max(hn::Mul(h.z, h.z), hn::Set(d, 1e-30f)));
    const V shine = hn::Exp(d, hn::Neg(hn::Mul(f(d, kFieldHalfExponent), hn::Log1p(d, tan2))));
    return add_scaled(field3(d, f, kFieldBase), shine, gloss) * vz;
  }
  const V alpha = f(d, kFieldAlpha);
  if constexpr (kKind == LobeKind::dielectric) {
    // Above o's side the half vector reflects, below it refracts [walter07, eq. 16].
    live = hn::And(live, hn::Gt(hn::Mul(side, vz), zero));
    const Mask above = hn::Gt(vz, zero);
    const V3 h = add_scaled(o, hn::IfThenElse(above, one, eta), v);
    const V oh = dot(o, h), vh = dot(v, h), h2 = hn::Max(dot(h, h), hn::Set(d, 1e-20f));
    const V cos_oh = hn::Min(hn::Div(hn::Abs(oh), hn::Sqrt(h2)), one);
    const V reflectance = fresnel(d, cos_oh, eta, inverse_eta);
    const V dg = microfacets<kGgx>(d, h, v, alpha);
    // Both directions must see the front of the microfacet.
    live = hn::And(live, hn::Or(above, hn::And(hn::Gt(hn::Mul(oh, h.z), zero), hn::Lt(hn::Mul(vh, h.z), zero))));
    const V up = hn::Mul(hn::Mul(dg, reflectance), hn::Mul(h2, h2));
    const V down = hn::Mul(hn::Mul(dg, hn::Sub(one, reflectance)), hn::Abs(hn::Mul(oh, vh)));
    const V3 pass = field3(d, f, kFieldPass);
    return {hn::IfThenElse(above, hn::Mul(gloss.x, up), hn::Mul(pass.x, down)),
            hn::IfThenElse(above, hn::Mul(gloss.y, up), hn::Mul(pass.y, down)),
            hn::IfThenElse(above, hn::Mul(gloss.z, up), hn::Mul(pass.z, down))};
  }
  const V3 h = o + v;
  const V h2 = dot(h, h), dg = hn::Mul(microfacets<kGgx>(d, h, v, alpha), hn::Mul(h2, h2));
  const V cos_oh = hn::Min(hn::Mul(hn::Set(d, 0.5f), hn::Sqrt(h2)), one);  // |o + v| / 2
  if constexpr (kKind == LobeKind::conductor) {
    const V3 e = field3(d, f, kFieldEtaMetal), k = field3(d, f, kFieldKMetal);
    return gloss * V3{hn::Mul(dg, fresnel_metal(d, cos_oh, e.x, k.x)), hn::Mul(dg, fresnel_metal(d, cos_oh, e.y, k.y)),
                      hn::Mul(dg, fresnel_metal(d, cos_oh, e.z, k.z))};
  }
  const V shine = hn::Mul(dg, fresnel(d, cos_oh, eta, inverse_eta));
  const V body = hn::Mul(vz, coat_transmittance(d, f, vz));
  return add_scaled(gloss * shine, body, field3(d, f, kFieldBase));
}

}  // namespace HWY_NAMESPACE
}  // namespace myrialux
HWY_AFTER_NAMESPACE();
#endif
