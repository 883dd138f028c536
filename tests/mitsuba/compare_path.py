#!/usr/bin/env python3
"""Does our path tracer agree with Mitsuba 3's? Mean and 8x8-block z-tests from the scatter of independent runs.

    compare_path.py PROGRAM SCENE.xml [--size 96x54] [--spp 64] [--runs 6] [--method path] [--thin-lens RADIUS,FOCUS]
                    [-- more options of ours]

Both renderers get the same scene, size, samples and box filter. Every run has another seed, so the scatter of the block
means gives their standard errors; Welch's t for each block, Sidak-corrected at 1 % over all blocks, and for the mean.
Exit status: 0 equal, 1 different, 77 Mitsuba or the scene is missing (skipped).
"""
import argparse
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile


def arguments():
    own = sys.argv[1:]
    extra = own[own.index("--") + 1:] if "--" in own else []
    own = own[:own.index("--")] if "--" in own else own
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--size", default="96x54")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--runs", type=int, default=6)
    parser.add_argument("--method", default="path")
    parser.add_argument("--thin-lens", help="aperture radius and focus distance that the scene's camera gets")
    return parser.parse_args(own), extra


def with_box_filter(scene, width, height, lens, folder):
    """A copy of the scene file with another film, and lens if asked for, beside links to the files it names."""
    for item in scene.parent.iterdir():
        (folder / item.name).symlink_to(item.resolve())
    text = scene.read_text()
    text = re.sub(r'(<default name="resx" value=)"\d+"', rf'\1"{width}"', text)
    text = re.sub(r'(<default name="resy" value=)"\d+"', rf'\1"{height}"', text)
    text = re.sub(r'(<integer name="width" value=)"[^"]*"', rf'\1"{width}"', text)
    text = re.sub(r'(<integer name="height" value=)"[^"]*"', rf'\1"{height}"', text)
    text = re.sub(r'<rfilter.*?(/>|</rfilter>)', '<rfilter type="box"/>', text, flags=re.S)
    if lens:
        radius, focus = lens.split(",")
        text = text.replace('<sensor type="perspective">', '<sensor type="thinlens">'
                            f'<float name="aperture_radius" value="{radius}"/>'
                            f'<float name="focus_distance" value="{focus}"/>')
        assert '"thinlens"' in text, "the scene has no perspective camera"
    path = folder / "compared.xml"
    path.write_text(text)
    return path


def block_means(picture, size=8):
    import numpy as np
    height, width = picture.shape[0] // size * size, picture.shape[1] // size * size
    blocks = picture[:height, :width].reshape(height // size, size, width // size, size, 3)
    return blocks.mean(axis=(1, 3)).reshape(-1, 3) if height and width else np.zeros((0, 3))


def t_values(a, b):
    """Welch's t and degrees of freedom for each column of two sets of runs."""
    import numpy as np
    va, vb = a.var(axis=0, ddof=1) / len(a), b.var(axis=0, ddof=1) / len(b)
    spread = np.maximum(va + vb, 1e-20)
    freedom = spread**2 / np.maximum(va**2 / (len(a) - 1) + vb**2 / (len(b) - 1), 1e-40)
    return (a.mean(axis=0) - b.mean(axis=0)) / np.sqrt(spread), freedom


def p_values(t, freedom):
    from scipy import stats
    return 2 * stats.t.sf(abs(t), freedom)


def main():
    options, extra = arguments()
    if not options.scene.exists():
        print(f"skipped: {options.scene} is not there")
        return 77
    try:
        import mitsuba
        import numpy as np
        import scipy  # noqa: F401
    except ImportError as missing:
        print(f"skipped: {missing}")
        return 77
    mitsuba.set_variant("scalar_rgb")
    mitsuba.set_log_level(mitsuba.LogLevel.Warn)
    width, height = map(int, options.size.split("x"))
    theirs, ours = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        path = with_box_filter(options.scene, width, height, options.thin_lens, folder)
        scene = mitsuba.load_file(str(path))
        for seed in range(options.runs):
            theirs.append(np.array(mitsuba.render(scene, spp=options.spp, seed=seed + 1))[:, :, :3])
            out = folder / "ours.exr"
            subprocess.run([options.program, "render", str(path), "--method", options.method, "--size", options.size,
                            "--spp", str(options.spp), "--filter", "box", "--seed", str(seed + 1), "--progress", "none",
                            "-o", str(out), *extra], check=True, stdout=subprocess.DEVNULL)
            layers = dict(mitsuba.Bitmap(str(out)).split())
            ours.append(np.array(layers["<root>"])[:, :, :3])
    ours, theirs = np.array(ours, dtype=float), np.array(theirs, dtype=float)
    mean_p = p_values(*t_values(ours.mean(axis=(1, 2)), theirs.mean(axis=(1, 2)))).min()
    a, b = (np.array([block_means(r).reshape(-1) for r in runs]) for runs in (ours, theirs))
    t, freedom = t_values(a, b)
    block_p = p_values(t, freedom)
    level_blocks, level_mean = 1 - (1 - 0.01) ** (1 / len(block_p)), 1 - (1 - 0.01) ** (1 / 3)
    ratio = ours.mean() / theirs.mean()
    worst = int(block_p.argmin())
    print(f"{options.scene.parent.name}: mean ours / Mitsuba = {ratio:.5f} (p {mean_p:.3g}, level {level_mean:.3g}); "
          f"{len(block_p)} block values, smallest p {block_p[worst]:.3g} (level {level_blocks:.3g}) at block {worst // 3}, "
          f"ours {a[:, worst].mean():.5g}, Mitsuba {b[:, worst].mean():.5g}; "
          f"rms t {math.sqrt(float((t**2).mean())):.3f}")
    if os.environ.get("MYRIALUX_KEEP"):
        np.savez(os.environ["MYRIALUX_KEEP"], ours=ours.mean(axis=0), theirs=theirs.mean(axis=0))
    return 0 if mean_p >= level_mean and block_p[worst] >= level_blocks else 1


if __name__ == "__main__":
    sys.exit(main())
