"""The part of `myrialux bench` that needs Python: FLIP of every picture and the page.

    python -m myrialux.bench FOLDER

FOLDER/job.json (written by the program) holds
  config   settings of the bench: size as "WxH", spp, vpls, scenes, ...
  results  one object for each scene, method and budget, as in results.json, and
             pixels  a file of float32 [height, width, 3] in FOLDER, linear Rec. 709
           the method "brute-force" is the reference of its scene
  page     where to write the page
Writes FOLDER/flip.json: mean HDR-FLIP of each result (null for references and scenes without light).
Exit status 69: packages are missing; they are named on stdout.
"""
import json
import pathlib
import sys

from myrialux.compare import missing_packages

REFERENCE = "brute-force"
ERRORS = [("relative_rmse", "relative RMSE"), ("relmse", "relMSE"), ("flip", "HDR-FLIP")]
# Error maps are large: below this many results a page shows all of them, above only the finest of each method.
FEW = 8


def evaluate_flip(results, pictures):
    """Mean HDR-FLIP of each result and the maps; None for references and without light."""
    from myrialux import flip
    references = {r["scene"]: p for r, p in zip(results, pictures) if r["method"] == REFERENCE}
    settings, maps = {}, []
    for result, picture in zip(results, pictures):
        scene = result["scene"]
        if result["method"] == REFERENCE:
            maps.append(None)
            continue
        error, settings[scene] = flip.hdr_flip(references[scene], picture, settings.get(scene))
        maps.append(error)
    return [None if m is None else float(m.mean()) for m in maps], maps


def bench_page(job, pictures, maps):
    """The whole page."""
    from myrialux.report.page import Page
    config, results = job["config"], job["results"]
    scenes = list(dict.fromkeys(r["scene"] for r in results))
    page = Page("Methods compared",
                f"{config['size']} pixels, {config['spp']} samples a pixel, {config['vpls']} virtual lights, seed "
                f"{config['seed']}, {config['threads']} threads, {config['isa']}. Myrialux {config['version']}.")
    page.paragraph("All methods got the same receivers and the same virtual lights, in one process, and took turns. Errors "
                   "are against every light and every ray for these lights; light seen directly is left out. A budget "
                   "multiplies clusters or divides error thresholds; 1 is each method's default. Seconds are the method's "
                   "own (trees, cuts, rays, sums), medians of the repeats; bars span the fastest and the slowest.")
    for scene in scenes:
        chosen = [k for k, r in enumerate(results) if r["scene"] == scene]
        add_scene(page, job, scene, chosen, pictures, maps)
    return page


def add_scene(page, job, scene, chosen, pictures, maps):
    """Curves, table and pictures of one scene. chosen: positions of its results."""
    from myrialux.report.figures import lines_log_log
    results = job["results"]
    methods = [k for k in chosen if results[k]["method"] != REFERENCE]
    page.heading(scene)
    for key, name in ERRORS:
        page.figure(lines_log_log(curves(results, methods, "seconds", key), "seconds", name))
    page.figure(lines_log_log(curves(results, methods, "shadow_rays", "relative_rmse"), "shadow rays", "relative RMSE"))
    add_table(page, results, chosen)
    add_pictures(page, job, scene, chosen, pictures, maps)


def curves(results, chosen, x, y):
    """One line a method; what is 0 or unknown has no place on a logarithmic axis."""
    from myrialux.report.figures import Line
    lines = {}
    for k in chosen:
        r = results[k]
        if not r[x] or not r[y]:
            continue
        line = lines.setdefault(r["method"], Line(r["method"], [], [], hover=[]))
        line.x.append(r[x])
        line.y.append(r[y])
        line.hover.append(f"{r['knob']}, {r['seconds']:.2f} s ({r['seconds_least']:.2f} to {r['seconds_most']:.2f})")
    return list(lines.values())


def add_table(page, results, chosen):
    from myrialux.report.tables import best_cells, number, table
    columns = [("method", ""), ("knob", "what the budget came to"), ("seconds", "median of the repeats"),
               ("fastest", ""), ("slowest", ""), ("CPU s", "of all threads, median"), ("shadow rays, M", ""),
               ("traced", "share of the entries that could carry light"), ("clusters", "a slice, receiver or pixel"),
               ("memory, MiB", "the method's own"), ("relative RMSE", ""), ("without worst 0.1 %", ""), ("relMSE", ""),
               ("bias", ""), ("HDR-FLIP", "")]
    rows, values = [], []
    for k in chosen:
        r = results[k]
        share = r["traced"] / r["entries"] if r["entries"] else None
        cells = [(r["seconds"], ""), (r["seconds_least"], ""), (r["seconds_most"], ""), (r["cpu_seconds"], ""),
                 (r["shadow_rays"] / 1e6, ""),
                 (share, "%"), (r["clusters_mean"] or None, ""), (r["method_bytes"] / 2**20 or None, ""),
                 (r["relative_rmse"], "%"), (r["relative_rmse_without_worst"], "%"), (r["relmse"], ""), (r["bias"], "%"),
                 (r["flip"], "")]
        rows.append([r["method"], r["knob"] or "–"] + [number(v, u) for v, u in cells])
        values.append([None] + [v for v, _ in cells])
    better = [None, True, None, None, True, True, None, None, None, True, True, True, None, True]
    page.html(table(columns, rows, best_cells(values, better)))


def add_pictures(page, job, scene, chosen, pictures, maps):
    from myrialux.report.figures import error_limit, error_maps, percent, signed_relative_error
    from myrialux.report.pictures import png_data
    results = job["results"]
    width, height = map(int, job["config"]["size"].split("x"))
    reference = next(k for k in chosen if results[k]["method"] == REFERENCE)
    finest = {results[k]["method"]: k for k in chosen if k != reference}
    shown = [k for k in chosen if k != reference] if len(chosen) <= FEW else list(finest.values())
    if not shown:
        return

    def name(k):
        return f"{scene}: {results[k]['method']} {results[k]['knob']}".strip()

    errors = {k: signed_relative_error(pictures[reference], pictures[k], 1e-2) for k in shown}
    limit = error_limit(list(errors.values()), 95)
    for k in [reference, *shown]:
        page.picture(name(k), png_data(pictures[k]))
    page.slider(name(reference), name(shown[-1]), width, height)
    page.paragraph("Where the errors are: (picture - reference) / sqrt(reference² + 0.01); colours end at "
                   f"{percent(limit)}. Drag to zoom, double-click to see all.")
    for k in shown:
        page.heading(name(k), 3)
        page.figure(error_maps(errors[k], maps[k], limit))


def main(folder):
    missing = missing_packages()
    if missing:
        print(missing)
        return 69
    import numpy as np
    folder = pathlib.Path(folder)
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    width, height = map(int, job["config"]["size"].split("x"))
    pictures = [np.fromfile(folder / r["pixels"], "<f4").reshape(height, width, 3) for r in job["results"]]
    flip, maps = evaluate_flip(job["results"], pictures)
    for result, value in zip(job["results"], flip):
        result["flip"] = value
    (folder / "flip.json").write_text(json.dumps(flip))
    bench_page(job, pictures, maps).write(job["page"])
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
