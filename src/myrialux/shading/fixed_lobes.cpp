// Multiplies out what a fixed direction contributes to a BSDF: the scalar half of kernels/lobes-inl.h.
#include "myrialux/shading/fixed_lobes.h"

#include <algorithm>
#include <cmath>

#include "myrialux/scattering/blinn_phong.h"
#include "myrialux/scattering/fresnel.h"
#include "myrialux/scattering/lobes.h"
#include "myrialux/scattering/microfacet.h"
#include "myrialux/scattering/rough_transmittance.h"

namespace myrialux {
namespace {

using Fields = std::array<float, kLobeFields>;

void put(Vec3 v, std::size_t k, Fields& f) { f[k] = v.x, f[k + 1] = v.y, f[k + 2] = v.z; }
void put(Rgb c, std::size_t k, Fields& f) { f[k] = c.r, f[k + 1] = c.g, f[k + 2] = c.b; }

LobeKind lobe_kind(const Bsdf& bsdf);

void put_fresnel(float eta, Fields& f) {
  f[kFieldEta] = eta;
  const float e = eta * eta, more = (eta - 1) * (eta + 1);
  // Where both sides are alike nothing is reflected; a large number stands for the infinite one.
  const float ratio = (e + 1) / (4 * std::copysign(std::max(std::fabs(more), 1e-15f), more));
  put(Vec3{0.25f * (e - 3), 4 * more, ratio}, kFieldFresnel, f);
}

/// Diffuse colour of plastic below its coat: what is reflected inside comes back, again and again.
Rgb plastic_base(const Bsdf& bsdf) {
  const Rgb lost = bsdf.nonlinear ? bsdf.reflectance * bsdf.fdr_internal : gray(bsdf.fdr_internal);
  return bsdf.reflectance / (gray(1) - lost) * (kInvPi * bsdf.inverse_eta_squared);
}

}  // namespace

std::size_t CoatTables::add(const float* row, float mix) {
  static_assert(kTableNodes == kTransmittanceNodes);
  // Rows of a slice mostly share a few materials, so the latest tables are the likeliest.
  const std::size_t oldest = known_.size() > 8 ? known_.size() - 8 : 0;
  for (std::size_t k = known_.size(); k-- > oldest;)
    if (known_[k].row == row && known_[k].mix == mix) return k * kTableFloats;
  known_.push_back({row, mix});
  const std::size_t begin = values_.size();
  values_.resize(begin + kTableFloats);
  float *const middle = values_.data() + begin, *const gain = middle + kTableNodes;
  const auto at = [&](std::size_t node) { return (1 - mix) * row[node] + mix * row[node + kTableNodes]; };
  for (std::size_t node = 0; node + 1 < kTableNodes; ++node)
    middle[node] = 0.5f * (at(node) + at(node + 1)), gain[node] = at(node + 1) - at(node);
  return begin;
}

FixedLobes fix_lobes(const Bsdf& bsdf, Vec3 n, Vec3 fixed, FixedEnd end, CoatTables& tables) {
  FixedLobes out;
  const ChosenLobes chosen = choose_lobes(bsdf, Lobes::wide);
  if (!chosen.any()) return out;
  // Glass is alike on both sides once its index is turned round; all else is black below.
  out.mirrored = dot(n, fixed) < 0;
  if (out.mirrored && bsdf.kind != BsdfKind::rough_dielectric) return out;
  if (out.mirrored) n = -n;
  const float cos_o = dot(fixed, n);
  if (!(cos_o > 0)) return out;
  out.any = true;

  out.lobes.lobe_class = {lobe_kind(bsdf), bsdf.distribution == Microfacets::ggx};
  Fields& f = out.lobes.field;
  const float eta = out.mirrored ? 1 / bsdf.eta : bsdf.eta;
  put(n, kFieldN, f), put(fixed, kFieldO, f);
  f[kFieldCosO] = cos_o;
  put(bsdf.eta_metal, kFieldEtaMetal, f), put(bsdf.k_metal, kFieldKMetal, f);
  const float alpha2 = bsdf.alpha > 0 ? bsdf.alpha * bsdf.alpha : 1;  // 0: no gloss is evaluated
  f[kFieldAlpha2] = alpha2, f[kFieldOneLessAlpha2] = 1 - alpha2;
  put_fresnel(eta, f);

  if (bsdf.kind == BsdfKind::diffuse || bsdf.kind == BsdfKind::blinn_phong)
    put(bsdf.reflectance * kInvPi, kFieldBase, f);
  if (bsdf.kind == BsdfKind::plastic) {
    const float through = 1 - fresnel_dielectric(cos_o, bsdf.eta).reflectance;
    put(plastic_base(bsdf) * through, kFieldBase, f);
  }
  if (bsdf.kind == BsdfKind::rough_plastic) {
    const float through = external_transmittance(bsdf.transmittance_row, bsdf.transmittance_mix, cos_o);
    put(plastic_base(bsdf) * through, kFieldBase, f);
    f[kFieldTable] = static_cast<float>(tables.add(bsdf.transmittance_row, bsdf.transmittance_mix));
  }
  if (chosen.gloss && bsdf.kind == BsdfKind::blinn_phong) {
    put(bsdf.specular * blinn_phong_peak(bsdf.exponent), kFieldGloss, f);
    f[kFieldHalfExponent] = 0.5f * bsdf.exponent;
  } else if (chosen.gloss) {
    const bool ggx = bsdf.distribution == Microfacets::ggx;
    const float of_facets = ggx ? 2 * alpha2 * kInvPi : kInvPi / alpha2;   // see microfacets() in kernels/lobes-inl.h
    const Vec3 o{std::sqrt(std::max(0.0f, 1 - cos_o * cos_o)), 0, cos_o};  // lobes have no direction along the surface
    const float shadowing = of_facets * smith_g1(bsdf.distribution, bsdf.alpha, o, {0, 0, 1});
    put(bsdf.specular * (shadowing / (4 * cos_o)), kFieldGloss, f);
    // Radiance is squeezed by 1 / eta^2 on its way to the viewer; light walks carry power, which is not.
    const float squeeze = end == FixedEnd::source ? eta * eta : 1;
    put(bsdf.transmittance * (shadowing / cos_o * squeeze), kFieldPass, f);
  }
  return out;
}

namespace {

LobeKind lobe_kind(const Bsdf& bsdf) {
  switch (bsdf.kind) {
    case BsdfKind::plastic:
      return LobeKind::coated;
    case BsdfKind::rough_plastic:
      return LobeKind::plastic;
    case BsdfKind::blinn_phong:
      return is_wide_part_lambertian(bsdf) ? LobeKind::diffuse : LobeKind::blinn_phong;
    case BsdfKind::rough_conductor:
      return LobeKind::conductor;
    case BsdfKind::rough_dielectric:
      return LobeKind::dielectric;
    case BsdfKind::diffuse:
    case BsdfKind::conductor:
    case BsdfKind::dielectric:
    case BsdfKind::thin_dielectric:
    case BsdfKind::null:
      break;
  }
  return LobeKind::diffuse;
}

}  // namespace
}  // namespace myrialux
