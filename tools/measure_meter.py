#!/usr/bin/env python3
"""How often the error meter's 95 % interval holds the true error of copied visibility; prints Markdown.

    measure_meter.py PROGRAM SCENE.xml... [--size WxH] [--seeds N] [--limit X] [--spp N]

For each scene and seed, lbamc against slice-lightcuts with the same cuts: the root mean square over pixels of their
difference, over the mean radiance from virtual lights, beside `visibility.meter.error` of stats.json.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy as np
import OpenEXR


def luminance(program, scene, folder, *options):
    image, stats = folder / "picture.exr", folder / "stats.json"
    subprocess.run([program, "render", scene, "-o", image, "--stats", stats, "--direct", "vpl", "--residual", "off",
                    "--filter", "box", "--progress", "none", *map(str, options)], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    channels = OpenEXR.File(str(image), separate_channels=True).channels()
    pixels = np.stack([channels[c].pixels for c in "RGB"], axis=-1).astype(float)
    return pixels @ np.array([0.212671, 0.715160, 0.072169]), json.loads(stats.read_text())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--size", default="480x270")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--limit", default="0.005")
    parser.add_argument("--spp", default="4")
    args = parser.parse_args()
    print("| scene | seed | error, estimated % | 95 % interval | true % | slices redone |")
    print("|---|---|---|---|---|---|")
    n = held = 0
    for scene in args.scenes:
        for seed in range(args.seeds):
            common = ["--size", args.size, "--spp", args.spp, "--seed", seed]
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                full, _ = luminance(args.program, scene, folder, *common, "--method", "slice-lightcuts")
                picture, stats = luminance(args.program, scene, folder, *common, "--method", "lbamc",
                                           "--visibility-error", args.limit)
            meter = stats["visibility"]["meter"]
            if meter is None:
                continue  # all traced
            true = float(np.sqrt(((picture - full) ** 2).mean()) / meter["mean_radiance"])
            e = meter["error"]
            n += 1
            held += e["low"] <= true <= e["high"]
            print(f"| {pathlib.Path(scene).parent.name} | {seed} | {100 * e['estimate']:.3f} | {100 * e['low']:.3f} to "
                  f"{100 * e['high']:.3f} | {100 * true:.3f} | {meter['redone_slices']} |", flush=True)
    print(f"\nThe interval held the true error in {held} of {n} frames.")


if __name__ == "__main__":
    main()
