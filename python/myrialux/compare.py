"""The part of `myrialux compare` that needs Python: FLIP and the HTML page.

    python -m myrialux.compare FOLDER

FOLDER/job.json (written by the program, which has read and measured the pictures) holds
  comparison  what `myrialux compare --json` prints, FLIP left out
  measures    key, name, unit, meaning and smaller_is_better of each measure, in the order to tell them
  relmse_epsilon
  pixels      files of float32 [height, width, 3] in FOLDER, linear Rec. 709: "reference" and "images", a list
  page        where to write the page; null: only FLIP
Writes FOLDER/flip.json: settings (null without light), and for each image flip (null likewise) and flip_shown.
Exit status 69: packages are missing; they are named on stdout.
"""
import dataclasses
import importlib.util
import json
import pathlib
import sys

PACKAGES = {"flip_evaluator": "flip-evaluator", "numpy": "numpy", "PIL": "pillow", "plotly": "plotly"}
FLIP_MEASURES = [
    ("flip", "HDR-FLIP", "FLIP over a range of exposures that the reference alone decides: the difference an eye sees "
                         "when flipping between the pictures, 0 to 1."),
    ("flip_shown", "FLIP as shown", "FLIP between the pictures as shown: this exposure, cut to 0 to 1, sRGB curve."),
]
# Header keys that tell most; the others of the program's own are folded away unless they differ.
MAIN_KEYS = ["method", "size", "spp", "passes", "seed", "vpls", "clusters", "filter", "direct", "residual",
             "entries_sampled_fraction", "max_depth", "version"]
PREFIX = "myrialux."


def evaluate_flip(reference, images, exposure):
    """What flip.json holds, and the HDR-FLIP maps of the images (None without light)."""
    from myrialux import flip
    settings, maps, values = None, [], []
    for image in images:
        error, settings = flip.hdr_flip(reference, image, settings)
        shown = flip.ldr_flip(reference, image, exposure)
        maps.append(error)
        values.append({"flip": None if error is None else float(error.mean()), "flip_shown": float(shown.mean())})
    return {"settings": settings and dataclasses.asdict(settings), "images": values}, maps


def comparison_page(job, reference, images, flip_maps):
    """The whole page. job["comparison"] has FLIP in it by now."""
    from myrialux.report.figures import signed_relative_error
    from myrialux.report.page import Page
    comparison = job["comparison"]
    width, height = comparison["size"]
    x, y, w, h = comparison["region"]
    part = "" if [x, y, w, h] == [0, 0, width, height] else f", region {w} x {h} at {x},{y}"
    path = pathlib.PurePath(comparison["reference"]["path"])
    page = Page(f"Compared with {path.name}",
                f"{path}: {width} x {height} pixels{part}. Shown at {comparison['exposure']:+g} stops with the sRGB curve. "
                f"Myrialux {comparison['version']}.")
    order = by_error(comparison)
    add_measures(page, job, order)
    errors = [signed_relative_error(reference, image, job["relmse_epsilon"]) for image in images]
    add_pictures(page, job, order, reference, images, errors, flip_maps)
    add_parameters(page, comparison, order)
    return page


def by_error(comparison):
    """Positions of the images, smallest error first."""
    images = comparison["images"]
    return sorted(range(len(images)), key=lambda k: images[k]["luminance"]["rmse"])


def add_measures(page, job, order):
    """Tables of all measures on luminance and on R G B, and what they mean."""
    from myrialux.report.tables import best_cells, definitions, number, table
    images = [job["comparison"]["images"][k] for k in order]
    page.heading("Errors, the smallest first")
    for title, key, extra in [("On luminance", "luminance", FLIP_MEASURES), ("On R, G, B", "rgb", [])]:
        page.heading(title, 3)
        measures = job["measures"]
        values = [[image[e[0]] for e in extra] + [image[key][m["key"]] for m in measures] for image in images]
        units = [""] * len(extra) + [m["unit"] for m in measures]
        better = [True] * len(extra) + [m["smaller_is_better"] for m in measures]
        # Equal pictures have an infinite ratio of signal to noise, which JSON cannot hold.
        texts = [["∞" if u == "dB" and v is None else number(v, u) for v, u in zip(row, units)] for row in values]
        means = [("mean", "Mean of the picture.")] if key == "luminance" else [
            ("means over reference", "Means of R, G and B over those of the reference.")]
        rows = []
        for image, row in zip(images, texts):
            mean = number(image[key]["mean"]) if key == "luminance" else " ".join(
                "–" if r is None else f"{r:.3f}" for r in image["mean_rgb_ratio"])
            rows.append([image["name"], *row, mean])
        columns = [("picture", "")] + [(n, m) for _, n, m in extra] + [(m["name"], m["meaning"]) for m in measures] + means
        page.html(table(columns, rows, best_cells(values, better)))
    if images:
        page.paragraph(f"Mean luminance of the reference: {number(images[0]['luminance']['mean_reference'])}.")
    page.heading("What they mean", 3)
    page.html(definitions([(n, m) for _, n, m in FLIP_MEASURES] + [(m["name"], m["meaning"]) for m in job["measures"]]))
    settings = job["comparison"]["flip_settings"]
    if settings:
        page.paragraph(f"HDR-FLIP used {settings['exposures']} exposures from {settings['start_exposure']:.2f} to "
                       f"{settings['stop_exposure']:.2f} stops, tone mapper {settings['tone_mapper']}, "
                       f"{settings['pixels_per_degree']:.0f} pixels a degree.")


def add_pictures(page, job, order, reference, images, errors, flip_maps):
    """Of every image: slider, error maps, histogram, header."""
    from myrialux.report.figures import error_histogram, error_limit, error_maps, percent
    from myrialux.report.pictures import png_data
    from myrialux.report.tables import text_table
    comparison = job["comparison"]
    exposure = comparison["exposure"]
    x, y, w, h = comparison["region"]
    names = [image["name"] for image in comparison["images"]]
    map_limit, histogram_limit = error_limit(errors, 95), error_limit(errors, 99)
    page.picture("reference", png_data(reference, exposure))
    for k in order:
        page.picture(names[k], png_data(images[k], exposure))
    if len(images) > 1:
        page.heading("How the errors are spread")
        page.figure(error_histogram({names[k]: errors[k] for k in order}, histogram_limit))
    for k in order:
        page.heading(names[k])
        page.slider("reference", names[k], w, h)
        page.heading("Where the errors are", 3)
        page.paragraph("(picture - reference) / sqrt(reference² + "
                       f"{job['relmse_epsilon']:g}); all pictures have the same colours, which end at {percent(map_limit)}. "
                       "Drag to zoom, double-click to see all.")
        page.figure(error_maps(errors[k], flip_maps[k], map_limit, (x, y)))
        page.figure(error_histogram({names[k]: errors[k]}, histogram_limit))
        header = comparison["images"][k]["header"]
        if header:
            rows = text_table(["in the file's header", ""], sorted(header.items()))
            page.html(f"<details><summary>All that the file tells of itself</summary>{rows}</details>")


def add_parameters(page, comparison, order):
    """The pictures' parameters side by side, as far as their headers tell them."""
    from myrialux.report.tables import text_table
    images = [comparison["images"][k] for k in order]
    headers = [{k.removeprefix(PREFIX): v for k, v in picture["header"].items() if k.startswith(PREFIX)}
               for picture in [comparison["reference"], *images]]
    if not any(headers):
        return
    keys = sorted(set().union(*headers) - {"command", "camera_to_world"},
                  key=lambda k: (MAIN_KEYS.index(k) if k in MAIN_KEYS else len(MAIN_KEYS), k))
    # The reference is made otherwise as a rule: what tells the images apart is marked.
    differing = {key for key in keys if len({header.get(key) for header in headers[1:] if header}) > 1}
    columns = ["", "reference", *[image["name"] for image in images]]
    rows = [(key, *[header.get(key, "") for header in headers]) for key in keys]
    page.heading("Parameters")
    page.html(text_table(columns, [r for r in rows if r[0] in MAIN_KEYS or r[0] in differing], differing))
    page.html("<details><summary>All others</summary>"
              + text_table(columns, [r for r in rows if r[0] not in MAIN_KEYS and r[0] not in differing]) + "</details>")


def missing_packages():
    """Names of the packages that pages need and this Python lacks, by commas."""
    return ", ".join(package for module, package in PACKAGES.items() if importlib.util.find_spec(module) is None)


def main(folder):
    missing = missing_packages()
    if missing:
        print(missing)
        return 69
    import numpy as np
    folder = pathlib.Path(folder)
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    _, _, width, height = job["comparison"]["region"]

    def pixels(name):
        return np.fromfile(folder / name, "<f4").reshape(height, width, 3)

    reference, images = pixels(job["pixels"]["reference"]), [pixels(name) for name in job["pixels"]["images"]]
    flip, maps = evaluate_flip(reference, images, job["comparison"]["exposure"])
    (folder / "flip.json").write_text(json.dumps(flip))
    if job["page"]:
        job["comparison"]["flip_settings"] = flip["settings"]
        for image, values in zip(job["comparison"]["images"], flip["images"]):
            image.update(values)
        comparison_page(job, reference, images, maps).write(job["page"])
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
