#!/usr/bin/env python3
"""Measures the methods against each other on scenes; prints Markdown tables (docs/measurements.md holds a run's figures).

    measure_methods.py PROGRAM completion SCENE.xml... [--method NAME] [--seed N] [-- -D bamc.alpha=0.05 ...]
                                                         a completion (bamc unless named; with these options) against
                                                         slice-lightcuts, same cuts
    measure_methods.py PROGRAM ablations SCENE.xml...    completions and their options against slice-lightcuts
    measure_methods.py PROGRAM clusters SCENE.xml...     both against brute-force on the same lights, by --clusters

Only light from virtual lights counts (--direct vpl --residual off), so that a difference is the method's alone.
"""
import argparse
import json
import pathlib
import resource
import subprocess
import sys
import tempfile

import numpy as np
import OpenEXR


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
          f"shadow rays/s, full (M) | visibility + complete s, full | {args.method} | CPU s in all, full | {args.method} |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for scene in args.scenes:
        common = ["--size", args.size, "--spp", args.spp, "--vpls", args.vpls, "--clusters", args.clusters,
                  "--seed", args.seed]
        cpu = [cpu_seconds()]
        full, full_stats = render(args.program, scene, "slice-lightcuts", folder, *common)
        cpu.append(cpu_seconds())
        completed, stats = render(args.program, scene, args.method, folder, *common, *args.extra)
        cpu.append(cpu_seconds())
        errors = [relative_rmse(full, completed, n) for n in (0, 10, luminance(full).size // 1000)]
        v, t, tf = stats["visibility"], stats["time_s"], full_stats["time_s"]
        print(f"| {scene.parent.name} | {100 * v['fraction']:.1f} | {' | '.join(f'{100 * e:.2f}' for e in errors)} | "
              f"{full_stats['rays']['shadow'] / tf['visibility'] / 1e6:.1f} | {tf['visibility'] + tf['complete']:.2f} | "
              f"{t['visibility'] + t['complete']:.2f} | {cpu[1] - cpu[0]:.0f} | {cpu[2] - cpu[1]:.0f} |", flush=True)


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


def split_at_dashes(arguments):
    """What stands before and after "--"."""
    at = arguments.index("--") if "--" in arguments else len(arguments)
    return arguments[:at], arguments[at + 1:]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("what", choices=["completion", "ablations", "clusters"])
    parser.add_argument("scenes", type=pathlib.Path, nargs="+")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--vpls", type=int, default=100000)
    parser.add_argument("--clusters", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--spp", type=int, default=4, help="of completion and ablations")
    parser.add_argument("--method", default="bamc", help="of completion: any method of slices")
    own, extra = split_at_dashes(sys.argv[1:])
    args = parser.parse_args(own)
    args.extra = extra
    with tempfile.TemporaryDirectory() as name:
        {"completion": completion, "ablations": measure_ablations, "clusters": clusters}[args.what](args, pathlib.Path(name))


if __name__ == "__main__":
    main()
