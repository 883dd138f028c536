#!/usr/bin/env python3
"""Measures the methods against each other on scenes; prints Markdown tables (docs/measurements.md holds a run's figures).

    measure_methods.py PROGRAM completion SCENE.xml... [--method NAME] [--seed N] [-- -D bamc.alpha=0.05 ...]
                                                         a completion (bamc unless named; with these options) against
                                                         slice-lightcuts, same cuts
    measure_methods.py PROGRAM ablations SCENE.xml...    completions and their options against slice-lightcuts
    measure_methods.py PROGRAM clusters SCENE.xml...     both against brute-force on the same lights, by --clusters
    measure_methods.py PROGRAM sampling SCENE.xml...     error over traced entries: bamc, gauss-jordan, amc; rows by
                                                         importance or evenly; alpha fixed or adapted
                                                         (figures 12, 13, 15 of Wang and Holzschuch 2020)
    measure_methods.py PROGRAM completion-time SCENE.xml...  CPU time of completion by alpha and by --clusters (figure 11)
    measure_methods.py PROGRAM speedups SCENE.xml... --folder DIR [--budgets LIST]
                                                         runs `myrialux bench` there, or goes on with it; then time of
                                                         each method over bamc's (--against another's) at equal
                                                         error (section 5.3)
    measure_methods.py PROGRAM pairs SCENE.xml...        lightcuts, lightslice and illumination cuts against brute-force
                                                         (tables 1, 3, 4, 6 of Bus et al. 2015)
    measure_methods.py PROGRAM lights SCENE.xml... [--counts LIST]
                                                         CPU time, rays, memory by virtual lights (its table 5, figure 5)

Only light from virtual lights counts (--direct vpl --residual off), so that a difference is the method's alone. Errors
are relative RMSE of luminance; up to `clusters` over the picture's mean with the lamps seen, after it without them.
"""
import argparse
import csv
import json
import pathlib
import resource
import subprocess
import sys
import tempfile

import numpy as np
import OpenEXR

from bench_table import at_error


def render(program, scene, method, folder, *options):
    """Picture and stats of one run."""
    image, stats = folder / "picture.exr", folder / "stats.json"
    subprocess.run([program, "render", str(scene), "--method", method, "-o", str(image), "--stats", str(stats),
                    "--direct", "vpl", "--residual", "off", "--filter", "box", "--progress", "none", *map(str, options)],
                   check=True, stdout=subprocess.DEVNULL)
    channels = OpenEXR.File(str(image), separate_channels=True).channels()
    pixels = np.stack([channels[c].pixels for c in "RGB"], axis=-1).astype(float)
    return pixels, json.loads(stats.read_text())


def luminance(pixels):
    return pixels @ np.array([0.212671, 0.715160, 0.072169])


def relative_rmse(reference, picture, n_left_out=0):
    """Over the mean of the reference; without the n_left_out worst pixels."""
    reference, picture = luminance(reference), luminance(picture)
    squares = np.sort(((picture - reference) ** 2).ravel())
    return float(np.sqrt(squares[:squares.size - n_left_out].mean()) / reference.mean())


def cpu_seconds():
    """Of all programs run so far; other programs on the machine disturb it less than they do the wall clock."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def completion(args, folder):
    print("| scene | traced % of active | relative RMSE % | without 10 worst pixels | without 0.1 % | "
          f"visibility + complete CPU s, full | {args.method} | ratio | CPU s in all, full | {args.method} | ratio |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    ratios = []
    for scene in args.scenes:
        common = ["--size", args.size, "--spp", args.spp, "--vpls", args.vpls, "--clusters", args.clusters,
                  "--seed", args.seed]
        cpu = [cpu_seconds()]
        full, full_stats = render(args.program, scene, "slice-lightcuts", folder, *common)
        cpu.append(cpu_seconds())
        completed, stats = render(args.program, scene, args.method, folder, *common, *args.extra)
        cpu.append(cpu_seconds())
        errors = [relative_rmse(full, completed, n) for n in (0, 10, luminance(full).size // 1000)]
        full_s, s = (sum(x["cpu_s"][stage] for stage in ("visibility", "complete")) for x in (full_stats, stats))
        all_full_s, all_s = cpu[1] - cpu[0], cpu[2] - cpu[1]
        ratios.append((full_s / s, all_full_s / all_s))
        print(f"| {scene.parent.name} | {100 * stats['visibility']['fraction']:.1f} | "
              f"{' | '.join(f'{100 * e:.2f}' for e in errors)} | {full_s:.1f} | {s:.1f} | {full_s / s:.2f} | "
              f"{all_full_s:.1f} | {all_s:.1f} | {all_full_s / all_s:.2f} |", flush=True)
    means = np.exp(np.mean(np.log(ratios), axis=0))
    print(f"\nGeometric means of the ratios: {means[0]:.2f}, {means[1]:.2f}")


def ablations():
    """Name, method and options of each line of the table; bamc without guard, as published."""
    rates = (5, 10, 20)
    lines = [("default", "")]
    lines += [(f"alpha fixed at {a} %", f"alpha={a / 100} adaptive=false") for a in rates]
    uniform = [("uniform rows", "importance=false")]
    uniform += [(f"uniform rows, alpha fixed at {a} %", f"importance=false alpha={a / 100} adaptive=false")
                for a in rates]
    letter = [("algorithm 1, alpha 10 %", "alpha=0.1 importance=false adaptive=false resample=false beta=0")]
    separation = [("default", ""), ("guesses alone", "separate=false"),
                  ("guesses alone, error 2 %, all columns validated", "separate=false error=0.02 energy=0")]
    for method, prefix, variants in (("bamc", "bamc", lines + uniform), ("gauss-jordan", "gauss-jordan", lines),
                                     ("amc", "amc", lines + letter), ("matrix-separation", "separation", separation)):
        for name, text in variants:
            yield name, method, [word for o in f"{text} guard=0".split() for word in ("-D", f"{prefix}.{o}")]


def measure_ablations(args, folder):
    print("| scene | method | options | traced % of active | relative RMSE % | without 0.1 % | mean % | "
          "complete, share of visibility + complete |")
    print("|---|---|---|---|---|---|---|---|")
    for scene in args.scenes:
        common = ["--size", args.size, "--spp", args.spp, "--vpls", args.vpls, "--clusters", args.clusters,
                  "--seed", args.seed]
        full, _ = render(args.program, scene, "slice-lightcuts", folder, *common)
        n_worst = luminance(full).size // 1000
        for name, method, options in ablations():
            picture, stats = render(args.program, scene, method, folder, *common, *options)
            v, t = stats["visibility"], stats["time_s"]
            mean = luminance(picture).mean() / luminance(full).mean() - 1
            print(f"| {scene.parent.name} | {method} | {name} | {100 * v['fraction']:.1f} | "
                  f"{100 * relative_rmse(full, picture):.2f} | {100 * relative_rmse(full, picture, n_worst):.2f} | "
                  f"{100 * mean:+.2f} | {t['complete'] / (t['visibility'] + t['complete']):.2f} |", flush=True)


def clusters(args, folder):
    counts = [125, 250, 500, 1000, 2000]
    print("| scene | method | " + " | ".join(f"C = {c}" for c in counts) + " |")
    print("|---|---|" + "---|" * len(counts))
    for scene in args.scenes:
        common = ["--size", args.size, "--spp", 1, "--vpls", args.vpls]
        truth, _ = render(args.program, scene, "brute-force", folder, *common)
        for method in ("slice-lightcuts", "bamc"):
            errors = [relative_rmse(truth, render(args.program, scene, method, folder, *common, "--clusters", c)[0])
                      for c in counts]
            print(f"| {scene.parent.name} | {method} | " + " | ".join(f"{100 * e:.2f} %" for e in errors) + " |", flush=True)


def share_without_lamps(args, scene, folder, pixels, *options):
    """Share of a picture's mean that is no lamp seen directly: a frame of paths of one edge shows those."""
    lamps, _ = render(args.program, scene, "slice-lightcuts", folder, *options, "--max-depth", 1)
    return 1 - luminance(lamps).mean() / luminance(pixels).mean()


def options_of(args, **changes):
    """Options of render that all rows of a table share."""
    values = {k: getattr(args, k) for k in ("size", "spp", "vpls", "clusters", "seed")} | changes
    return [word for name, value in values.items() for word in (f"--{name}", value)]


RATES = (0.025, 0.05, 0.1, 0.2, 0.4)


def keys(prefix, text):
    return [word for o in f"{text} guard=0".split() for word in ("-D", f"{prefix}.{o}")]


def sampling(args, folder):
    variants = [("bamc", "importance", ""), ("gauss-jordan", "importance", ""), ("amc", "importance", ""),
                ("bamc", "evenly", "importance=false")]
    print("| scene | method | rows drawn by | alpha | traced % of active | relative RMSE % | without 0.1 % | mean % |")
    print("|---|---|---|---|---|---|---|---|")
    for scene in args.scenes:
        common = options_of(args)
        full, _ = render(args.program, scene, "slice-lightcuts", folder, *common)
        share = share_without_lamps(args, scene, folder, full, *common)
        for method, drawn, text in variants:
            fixed = [(f"{100 * a:g} %", f"alpha={a} adaptive=false {text}") for a in RATES]
            for alpha, options in ([("adapted", text)] if method == "bamc" else []) + fixed:
                picture, stats = render(args.program, scene, method, folder, *common, *keys(method, options))
                errors = [relative_rmse(full, picture, n) / share for n in (0, luminance(full).size // 1000)]
                mean = (luminance(picture).mean() / luminance(full).mean() - 1) / share
                traced = 100 * stats["visibility"]["fraction"]
                print(f"| {scene.parent.name} | {method} | {drawn} | {alpha} | {traced:.1f} | "
                      f"{100 * errors[0]:.2f} | {100 * errors[1]:.2f} | {100 * mean:+.2f} |", flush=True)


def stage_cpu_seconds(args, scene, method, folder, *options):
    """CPU seconds of a run's stages: its wall times on one thread, scaled to the CPU time of the program."""
    before = cpu_seconds()
    _, stats = render(args.program, scene, method, folder, "--threads", 1, *options)
    scale = (cpu_seconds() - before) / stats["time_s"]["total"]
    return {stage: (seconds or 0) * scale for stage, seconds in stats["time_s"].items()}


def completion_time(args, folder):
    counts = (125, 250, 500, 1000, 2000)
    print("CPU seconds of completion + of tracing\n")
    for title, columns, steps in (
            ("alpha", [f"{100 * a:g} %" for a in RATES], [(a, args.clusters) for a in RATES]),
            ("clusters", counts, [(0.1, c) for c in counts])):
        print(f"| scene | method | " + " | ".join(f"{title} {c}" for c in columns) + " |\n|---|---|" + "---|" * len(columns))
        for scene in args.scenes:
            for method in ("bamc", "gauss-jordan", "amc"):
                cells = []
                for alpha, clusters_ in steps:
                    t = stage_cpu_seconds(args, scene, method, folder, *options_of(args, clusters=clusters_),
                                          *keys(method, f"alpha={alpha} adaptive=false"))
                    cells.append(f"{t['complete']:.2f} + {t['visibility']:.2f}")
                print(f"| {scene.parent.name} | {method} | {' | '.join(cells)} |", flush=True)
        print()


def speedups(args, folder):
    out = args.folder or folder / "bench"
    methods = "bamc,slice-lightcuts,lightslice,matrix-separation,illumination-cut,illumination-cut-sampling,lightcuts"
    subprocess.run([args.program, "bench", *map(str, args.scenes), "-o", str(out), "--methods", methods, "--no-page",
                    "--budgets", args.budgets, "--progress", "none", *map(str, options_of(args)), *args.extra],
                   check=True, stdout=subprocess.DEVNULL)
    curves = {}
    with open(out / "results.csv", newline="") as lines:
        for line in csv.DictReader(lines):
            if line["relative_rmse"]:
                curve = curves.setdefault(line["scene"], {}).setdefault(line["method"], [])
                curve.append((float(line["relative_rmse"]), float(line["seconds"])))
    print("| scene | method | at error % | seconds over X's | at error % | seconds over X's |"
          .replace("X", args.against))
    print("|---|---|---|---|---|---|")
    for scene, of_scene in curves.items():
        for method, curve in of_scene.items():
            errors = [[e for e, _ in c] for c in (curve, of_scene[args.against])]
            ends = max(map(min, errors)), min(map(max, errors))  # errors that both reach
            if ends[0] <= ends[1]:
                cells = [f"{100 * e:.2f} | {at_error(curve, e) / at_error(of_scene[args.against], e):.2f}" for e in ends]
            else:
                cells = [f"{100 * end(errors[0]):.2f} | not reached by {args.against}" for end in (min, max)]
            print(f"| {scene} | {method} | {cells[0]} | {cells[1]} |")


def mean_relative_error(reference, picture):
    reference, picture = luminance(reference), luminance(picture)
    lit = reference > 0
    return float((np.abs(picture - reference)[lit] / reference[lit]).mean())


NO_LIMIT = 1000000  # nodes of a cut


def pairs(args, folder):
    rows = [("lightcuts", "1 %", NO_LIMIT, "lightcuts.error=0.01"),
            ("lightcuts", "1 %, at most 2000 nodes", 2000, "lightcuts.error=0.01"),
            ("lightcuts", "0.1 %", NO_LIMIT, "lightcuts.error=0.001"),
            ("lightslice", "800 columns", 800, ""), ("lightslice", "3200 columns", 3200, ""),
            ("illumination-cut", "6 %", None, "illumination-cut.error=0.06"),
            ("illumination-cut", "1.5 %", None, "illumination-cut.error=0.015"),
            ("illumination-cut", "1 %", None, "illumination-cut.error=0.01"),
            ("illumination-cut", "0.15 %", None, "illumination-cut.error=0.0015"),
            ("illumination-cut-sampling", "6 %", None, "illumination-cut-sampling.error=0.06"),
            ("illumination-cut-sampling", "1 %", None, "illumination-cut-sampling.error=0.01"),
            ("illumination-cut-sampling", "0.1 %", None, "illumination-cut-sampling.error=0.001")]
    print("| scene | method | | nodes a receiver | bounds a pixel | rays a pixel | of phase I | relative RMSE % | "
          "mean relative error % | CPU s |\n|---|---|---|---|---|---|---|---|---|---|")
    for scene in args.scenes:
        common = [*options_of(args), "--clamp", args.clamp]
        truth, _ = render(args.program, scene, "brute-force", folder, *common)
        share = share_without_lamps(args, scene, folder, truth, *common)
        for method, name, limit, key in rows:
            before = cpu_seconds()
            picture, stats = render(args.program, scene, method, folder, "--clamp", args.clamp,
                                    *options_of(args, clusters=limit or args.clusters), *(["-D", key] if key else []))
            bounds, first = (stats["refinement"][k] for k in ("bounds", "approximate_rays"))
            counts = [a_pixel(args, n) for n in (bounds, stats["rays"]["shadow"], first)]
            print(f"| {scene.parent.name} | {method} | {name} | {stats['clusters_mean']:.0f} | {' | '.join(counts)} | "
                  f"{100 * relative_rmse(truth, picture) / share:.2f} | {100 * mean_relative_error(truth, picture):.2f} | "
                  f"{cpu_seconds() - before:.1f} |", flush=True)


def a_pixel(args, count):
    width, height = map(int, args.size.split("x"))
    return f"{count / (width * height):.0f}" if count else "-"


def lights(args, folder):
    print("| scene | method | virtual lights | CPU s | of it trees and cuts | shadow rays a pixel | peak memory, MiB |\n"
          "|---|---|---|---|---|---|---|")
    for scene in args.scenes:
        for method in ("illumination-cut", "illumination-cut-sampling", "lightcuts", "mdlc", "lightslice",
                       "slice-lightcuts"):
            limit = {"lightcuts": NO_LIMIT, "mdlc": NO_LIMIT}.get(method, args.clusters)
            for count in map(int, args.counts.split(",")):
                before = cpu_seconds()
                _, stats = render(args.program, scene, method, folder, *options_of(args, vpls=count, clusters=limit),
                                  "--clamp", args.clamp, *args.extra)
                cpu, t = cpu_seconds() - before, stats["time_s"]
                print(f"| {scene.parent.name} | {method} | {stats['virtual_lights']} | {cpu:.1f} | "
                      f"{cpu * t['cluster'] / t['total']:.1f} | {a_pixel(args, stats['rays']['shadow'])} | "
                      f"{stats['memory_bytes']['peak_rss'] / 2**20:.0f} |", flush=True)


def split_at_dashes(arguments):
    """What stands before and after "--"."""
    at = arguments.index("--") if "--" in arguments else len(arguments)
    return arguments[:at], arguments[at + 1:]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    measures = {"completion": completion, "ablations": measure_ablations, "clusters": clusters, "sampling": sampling,
                "completion-time": completion_time, "speedups": speedups, "pairs": pairs, "lights": lights}
    parser.add_argument("what", choices=list(measures))
    parser.add_argument("scenes", type=pathlib.Path, nargs="+")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--vpls", type=int, default=100000)
    parser.add_argument("--clusters", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--spp", type=int, default=4, help="of all but clusters")
    parser.add_argument("--method", default="bamc", help="of completion: any method of slices")
    parser.add_argument("--folder", type=pathlib.Path, help="of speedups: where myrialux bench works")
    parser.add_argument("--budgets", default="0.25,0.5,1,2,4", help="of speedups, as for myrialux bench")
    parser.add_argument("--against", default="bamc", help="of speedups")
    parser.add_argument("--clamp", type=float, default=0.02, help="of pairs and lights; published: 0.05")
    parser.add_argument("--counts", default="50000,100000,200000,400000,800000,1200000", help="of lights")
    own, extra = split_at_dashes(sys.argv[1:])
    args = parser.parse_args(own)
    args.extra = extra
    with tempfile.TemporaryDirectory() as name:
        measures[args.what](args, pathlib.Path(name))


if __name__ == "__main__":
    main()
