#!/usr/bin/env python3
"""Figures of docs/methods from the folder of a `myrialux bench`: picture and error map of every method, side by side.

    .venv/bin/python tools/make_method_figures.py BENCH SCENE OUT [--budget 1] [--limit 0.2] [--exposure 0]

Writes OUT/METHOD.jpg. The map has the relative error of luminance against brute force on the same lights, which the
bench kept: red too bright, blue too dark, white right; full colour at +-LIMIT, the same for all methods.
"""
import argparse
import json
import pathlib
import sys

import numpy as np
import OpenEXR
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "python"))
from myrialux.report.figures import signed_relative_error  # noqa: E402
from myrialux.report.pictures import shown  # noqa: E402

EPSILON = 1e-2  # as the pages of bench


def read_pixels(path):
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return np.stack([channels[c].pixels for c in "RGB"], axis=-1)


def error_colours(error, limit):
    """[height, width, 3] in 0 to 1: white at 0, red above, blue below."""
    strength = np.clip(np.abs(error) / limit, 0, 1)[..., None]
    full = np.where(error[..., None] > 0, np.array([0.70, 0.09, 0.17]), np.array([0.13, 0.40, 0.67]))
    return 1 + strength * (full - 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench", type=pathlib.Path)
    parser.add_argument("scene")
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--budget", type=float, default=1)
    parser.add_argument("--limit", type=float, default=0.2)
    parser.add_argument("--exposure", type=float, default=0, help="stops")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    runs = [json.loads(line) for line in (args.bench / "runs.jsonl").read_text().splitlines()]
    chosen = {r["method"]: r for r in runs if r["scene"] == args.scene and r["budget"] == args.budget}
    reference = read_pixels(args.bench / chosen.pop("brute-force")["picture"])
    for method, run in chosen.items():
        picture = read_pixels(args.bench / run["picture"])
        error = signed_relative_error(reference, picture, EPSILON)
        both = np.hstack([shown(picture, args.exposure), error_colours(error, args.limit)])
        image = Image.fromarray(np.rint(255 * both).astype(np.uint8))
        image = image.resize((960, 960 * image.height // image.width), Image.Resampling.LANCZOS)
        image.save(args.out / f"{method}.jpg", quality=80, optimize=True, progressive=True)
        print(f"{args.out / method}.jpg: {run['knob']}, relative RMSE {100 * run['relative_rmse']:.1f} %")


if __name__ == "__main__":
    main()
