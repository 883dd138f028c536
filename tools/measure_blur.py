#!/usr/bin/env python3
"""mdlc against brute-force on the same lights under depth of field and a moving camera; prints a Markdown table.

    measure_blur.py PROGRAM SCENE.xml [--spp 16,256,1024] [--size 16x9] [--vpls 2000] [--aperture R --focus D --way W]
                    [-- more options, as --fov 10]

The scene's camera gets a lens of radius R that is sharp at D and moves by W to its right while the shutter is open, in
scene units. Only light from virtual lights counts; emitters that are seen are left out.
"""
import argparse
import pathlib
import re
import sys
import tempfile

import numpy as np

from measure_methods import luminance, render, split_at_dashes


def blurred(scene, args, folder):
    """A copy of the scene file with a lens and two keyframes, beside links to the files it names."""
    for item in scene.parent.iterdir():
        (folder / item.name).symlink_to(item.resolve())
    text = scene.read_text()
    old = re.search(r'<scene version="[01]\.', text) is not None
    names = ("apertureRadius", "focusDistance", "shutterClose", "toWorld") if old else \
        ("aperture_radius", "focus_distance", "shutter_close", "to_world")
    numbers = "".join(f'<float name="{n}" value="{v}"/>' for n, v in zip(names, (args.aperture, args.focus, 1)))

    def keyframes(match):
        return (f'{numbers}<animation name="{names[3]}"><transform time="0">{match[1]}</transform>'
                f'<transform time="1"><translate x="{-args.way}"/>{match[1]}</transform></animation>')

    head, sensor = text.split('<sensor type="perspective"', 1)
    sensor = re.sub(r'<transform name="to_?[wW]orld"\s*>(.*?)</transform>', keyframes, sensor, count=1, flags=re.S)
    path = folder / "blurred.xml"
    path.write_text(head + '<sensor type="thinlens"' + sensor)
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--spp", default="16,256,1024")
    parser.add_argument("--size", default="16x9")
    parser.add_argument("--vpls", type=int, default=2000)
    parser.add_argument("--aperture", type=float, default=0.1)
    parser.add_argument("--focus", type=float, default=3)
    parser.add_argument("--way", type=float, default=0.2)
    own, extra = split_at_dashes(sys.argv[1:])
    args = parser.parse_args(own)
    print("| samples a pixel | entries a pixel | pairs | rays | rays of brute force | RMSE | median |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scene = blurred(args.scene, args, folder)
        width, height = map(int, args.size.split("x"))
        for spp in args.spp.split(","):
            common = ["--size", args.size, "--spp", spp, "--vpls", args.vpls, *extra]
            seen, _ = render(args.program, scene, "brute-force", folder, *common, "--max-depth", 1)
            truth, exact = render(args.program, scene, "brute-force", folder, *common)
            picture, stats = render(args.program, scene, "mdlc", folder, *common)
            error = np.abs(luminance(picture) - luminance(truth))
            light = luminance(truth) - luminance(seen)
            lit = light > 0
            print(f"| {spp} | {exact['visibility']['entries'] / (width * height):.0f} | {stats['clusters_mean']:.0f} | "
                  f"{stats['rays']['shadow'] / (width * height):.0f} | {exact['rays']['shadow'] / (width * height):.0f} | "
                  f"{100 * np.sqrt((error**2).mean()) / light.mean():.1f} % | "
                  f"{100 * np.median(error[lit] / light[lit]):.1f} % |", flush=True)


if __name__ == "__main__":
    main()
