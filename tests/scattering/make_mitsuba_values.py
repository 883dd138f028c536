"""Writes mitsuba_values.csv: what Mitsuba 3's BSDF plugins answer over a grid of directions.

Run with a Python that has mitsuba 3.9 (variant scalar_rgb). Colours and indices below are repeated in
mitsuba_test.cpp. Directions: wo is towards the viewer (Mitsuba's wi), wi towards the light (Mitsuba's wo).
Rows: what, kind, distribution, alpha, eta, nonlinear, wo (3), wi (3), value (3), pdf
  eval    value = f |cos wi|, pdf per solid angle
  delta   wi and value = direction and weight of a sample with the lobe number at 0 (reflection) or 1 (refraction)
  fresnel dielectric: wo = (cos_i, 0, 0), value = (reflectance, cos_t, eta_it); conductor: value = reflectance
"""

import itertools
import math
import pathlib

import mitsuba as mi

mi.set_variant("scalar_rgb")

ALPHAS = [0.05, 0.2, 0.5, 0.9]
UPPER = [5, 35, 65, 85]  # polar angles, degrees
LOWER = [100, 130, 160]


def rgb(*values):
    return {"type": "rgb", "value": list(values)}


REFLECTANCE, SPECULAR = rgb(0.2, 0.5, 0.8), rgb(0.9, 0.7, 0.5)
TRANSMITTANCE = rgb(0.8, 0.9, 0.6)
ETA_METAL = {"type": "rgb", "value": [0.2, 0.92, 1.1]}
K_METAL = {"type": "rgb", "value": [3.9, 2.45, 2.14]}


def direction(theta_deg, phi_deg):
    t, p = math.radians(theta_deg), math.radians(phi_deg)
    return [math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)]


def side(wo):
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(*wo)
    return si


def plugin(kind, distribution, alpha, eta, nonlinear):
    d = {"type": kind}
    if kind.startswith("rough"):
        d |= {"distribution": distribution, "alpha": alpha}
    if kind == "diffuse":
        d |= {"reflectance": REFLECTANCE}
    elif kind.endswith("conductor"):
        d |= {"eta": ETA_METAL, "k": K_METAL, "specular_reflectance": SPECULAR}
    else:
        d |= {"int_ior": eta, "ext_ior": 1.0, "specular_reflectance": SPECULAR}
    if kind.endswith("plastic"):
        d |= {"diffuse_reflectance": REFLECTANCE, "nonlinear": nonlinear}
    elif kind.endswith("dielectric"):
        d |= {"specular_transmittance": TRANSMITTANCE}
    return mi.load_dict(d)


def variants():
    yield "diffuse", "ggx", 0, 1.5, False
    for eta, nonlinear in itertools.product([1.3, 1.5046], [False, True]):
        yield "plastic", "ggx", 0, eta, nonlinear
    for distribution, alpha in itertools.product(["beckmann", "ggx"], ALPHAS):
        yield "roughconductor", distribution, alpha, 1.5, False
        yield "roughplastic", distribution, alpha, 1.3, True
        yield "roughplastic", distribution, alpha, 1.5046, False
        yield "roughdielectric", distribution, alpha, 1.5046, False


def main():
    rows = []

    def add(what, variant, wo, wi, value, pdf):
        kind, distribution, alpha, eta, nonlinear = variant
        numbers = [*wo, *wi, *value, pdf]
        rows.append(
            f"{what},{kind},{distribution},{alpha:g},{eta:g},{int(nonlinear)}," + ",".join(f"{x:.8g}" for x in numbers)
        )

    context = mi.BSDFContext()
    for variant in variants():
        bsdf = plugin(*variant)
        angles = UPPER + (LOWER if variant[0] == "roughdielectric" else [])
        for theta_o, theta_i, phi in itertools.product(angles, [t - 1 for t in angles], [0, 50, 180]):
            wo, wi = direction(theta_o, 0), direction(theta_i, phi)
            f, pdf = bsdf.eval_pdf(context, side(wo), mi.Vector3f(*wi))
            add("eval", variant, wo, wi, list(f), pdf)

    for kind in ["conductor", "plastic", "dielectric", "thindielectric"]:
        variant = (kind, "ggx", 0, 1.5046, False)
        bsdf = plugin(*variant)
        angles = UPPER + (LOWER if kind.endswith("dielectric") else [])
        for theta_o, u in itertools.product(angles, [0.0, 0.9999999]):
            if u > 0 and not kind.endswith("dielectric"):
                continue
            wo = direction(theta_o, 0)
            s, weight = bsdf.sample(context, side(wo), u, mi.Point2f(0.3, 0.6))
            add("delta", variant, wo, list(s.wo), list(weight), s.eta)

    for theta, eta in itertools.product(range(0, 181, 15), [1.0, 1.3, 1.5046, 0.7]):
        c = math.cos(math.radians(theta))
        r, cos_t, eta_it, _ = mi.fresnel(c, eta)
        add("fresnel", ("dielectric", "ggx", 0, eta, False), [c, 0, 0], [0, 0, 0], [r, cos_t, eta_it], 0)
    for theta, (eta, k) in itertools.product(range(0, 90, 10), [(0.2, 3.9), (1.1, 2.14), (1.5, 0), (0, 1)]):
        c = math.cos(math.radians(theta))
        r = mi.fresnel_conductor(c, mi.Complex2f(eta, k))
        add("fresnel", ("conductor", "ggx", k, eta, False), [c, 0, 0], [0, 0, 0], [r, r, r], 0)
    for eta in [0.5, 0.66, 0.9, 1.1, 1.5, 2.4]:
        r = mi.fresnel_diffuse_reflectance(eta)
        add("fresnel", ("plastic", "ggx", 0, eta, False), [0, 0, 0], [0, 0, 0], [r, r, r], 0)

    head = "what,kind,distribution,alpha,eta,nonlinear,wo_x,wo_y,wo_z,wi_x,wi_y,wi_z,value_r,value_g,value_b,pdf_omega"
    path = pathlib.Path(__file__).with_name("mitsuba_values.csv")
    path.write_text("\n".join([head, *rows]) + "\n")


if __name__ == "__main__":
    main()
