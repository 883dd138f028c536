#!/usr/bin/env python3
"""Checks what --clusters auto estimates; prints Markdown tables (docs/clusters_auto.md holds a run's figures).

    measure_auto.py PROGRAM scatter SCENE.xml...  the choice and its errors; spread between pictures of --sets light
                                                  sets with the same receivers, which has both errors in it
    measure_auto.py PROGRAM brute SCENE.xml...    light-set error as the spread of brute-force pictures, cluster error
                                                  as the distance of slice-lightcuts from them; use a small --size
    measure_auto.py PROGRAM cost SCENE.xml...     what the choice takes of a pass, and a pass besides its clusters

Only light from virtual lights counts (--direct vpl --residual off), without lamps seen directly. Errors are root mean
squares over the mean, without the worst 1 % of pixels; a pixel holds --spp receivers that share lights and clusters.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

import numpy as np

from measure_methods import luminance, render


def options(args, seed=0):
    return ["--size", args.size, "--spp", args.spp, "--vpls", args.vpls, "--seed", seed]


def light_files(args, scene, folder):
    for k in range(args.sets):
        path = folder / f"{k}.ply"
        if not path.exists():
            subprocess.run([args.program, "lights", str(scene), "-o", str(path), "--vpls", str(args.vpls),
                            "--seed", str(k), "--progress", "none"], check=True, stdout=subprocess.DEVNULL)
        yield path


def trimmed_rms(squares):
    squares = np.sort(squares.ravel())
    return float(np.sqrt(squares[:squares.size - squares.size // 100].mean()))


def estimates(args, scene, method, folder):
    """Of one frame a light set."""
    runs = [render(args.program, scene, method, folder, *options(args, k), "--clusters", "auto")[1]
            for k in range(args.sets)]
    return [r["clusters_auto"] for r in runs]


def words(values):
    return ", ".join(f"{100 * v:.1f}" for v in values)


def without_lamps(args, scene, folder):
    lamps, _ = render(args.program, scene, "slice-lightcuts", folder, *options(args), "--max-depth", 1)
    return lambda pixels: luminance(pixels) - luminance(lamps)


def spread(pictures):
    pictures = np.array(pictures)
    return trimmed_rms(pictures.var(axis=0, ddof=1)) / pictures.mean()


def scatter(args, scene, folder):
    chosen = estimates(args, scene, args.method, folder)
    light = without_lamps(args, scene, folder)
    n = round(statistics.median(c["chosen"] for c in chosen))
    pictures = [light(render(args.program, scene, args.method, folder, *options(args), "--clusters", n,
                             "--lights", p)[0]) for p in light_files(args, scene, folder)]
    foreseen = [np.hypot(c["light_set_error"], c["cluster_error"]) for c in chosen]
    print(f"| {scene.parent.name} | {', '.join(str(c['chosen']) for c in chosen)} | "
          f"{words(c['light_set_error'] for c in chosen)} | {words(c['cluster_error'] for c in chosen)} | "
          f"{100 * statistics.median(foreseen):.1f} | {100 * spread(pictures):.1f} |", flush=True)


def brute(args, scene, folder):
    light = without_lamps(args, scene, folder)
    truths = [light(render(args.program, scene, "brute-force", folder, *options(args), "--lights", p)[0])
              for p in light_files(args, scene, folder)]
    chosen = estimates(args, scene, "slice-lightcuts", folder)
    errors = []
    for c, path, truth in zip(chosen, light_files(args, scene, folder), truths):
        picture = light(render(args.program, scene, "slice-lightcuts", folder, *options(args),
                               "--clusters", c["chosen"], "--lights", path)[0])
        errors.append(trimmed_rms((picture - truth) ** 2) / truth.mean())
    print(f"| {scene.parent.name} | {', '.join(str(c['chosen']) for c in chosen)} | "
          f"{words(c['light_set_error'] for c in chosen)} | {100 * spread(truths):.1f} | "
          f"{words(c['cluster_error'] for c in chosen)} | {words(errors)} |", flush=True)


def cost(args, scene, folder):
    def passes(n):
        """Stage times of some passes of one thread with residual rays; without loading and building."""
        for _ in range(args.repeats):
            subprocess.run([args.program, "render", str(scene), "--method", args.method, "-o", str(folder / "a.exr"),
                            "--stats", str(folder / "a.json"), "--progress", "none", "--clusters", str(n),
                            *map(str, options(args)), "--threads", "1"], check=True, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL)
            stats = json.loads((folder / "a.json").read_text())
            times = stats["time_s"]
            yield times["total"] - times["load"] - times["build"], times.get("choice"), stats["clusters_auto"]["chosen"]
    auto = list(passes("auto"))
    few, many = (min(seconds for seconds, _, _ in passes(c)) for c in (250, 1000))
    print(f"| {scene.parent.name} | {auto[0][2]} | {100 * statistics.median(c / s for s, c, _ in auto):.1f} | "
          f"{few * 750 / (many - few) - 250:.0f} |", flush=True)


HEADS = {"scatter": ("chosen", "light set %, foreseen", "clusters %, foreseen", "both %, foreseen", "both %, measured"),
         "brute": ("chosen", "light set %, foreseen", "measured", "clusters %, foreseen", "measured"),
         "cost": ("chosen", "choice, % of the pass", "work beside clusters, in clusters")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("measure", choices=HEADS)
    parser.add_argument("scenes", type=pathlib.Path, nargs="+")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--spp", type=int, default=4)
    parser.add_argument("--vpls", type=int, default=100000)
    parser.add_argument("--sets", type=int, default=4, help="light sets")
    parser.add_argument("--method", default="lbamc", help="of scatter and cost")
    parser.add_argument("--repeats", type=int, default=3, help="of cost")
    args = parser.parse_args()
    print("| scene | " + " | ".join(HEADS[args.measure]) + " |")
    print("|---|" + "---|" * len(HEADS[args.measure]))
    for scene in args.scenes:
        with tempfile.TemporaryDirectory() as folder:
            {"scatter": scatter, "brute": brute, "cost": cost}[args.measure](args, scene, pathlib.Path(folder))


if __name__ == "__main__":
    main()
