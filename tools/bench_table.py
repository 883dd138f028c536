#!/usr/bin/env python3
"""Prints the results of a `myrialux bench` as Markdown tables, one a scene: tools/bench_table.py BENCH

With --against METHOD: how many times METHOD's CPU seconds each method takes at the errors that both reach (those of
its curves over budgets, straight between them on logarithmic axes).

Reads runs.jsonl, so an unfinished bench will do. CPU seconds are those of all threads, medians of the repeats; errors are
of luminance over the mean of the light that virtual lights bring, against brute force on the same lights.
"""
import argparse
import json
import math
import pathlib
import statistics
import sys


def share(value):
    """Three digits, in percent."""
    return "-" if value is None else f"{100 * value:.3g}"


def table(runs):
    """Lines of one scene's table, methods as they first ran, budgets rising."""
    groups = {}
    for run in runs:
        groups.setdefault((run["method"], run["budget"]), []).append(run)
    methods = list(dict.fromkeys(run["method"] for run in runs))
    yield ("| method | knob | CPU s | shadow rays, M | traced % | clusters | memory, MiB | relative RMSE % | "
           "without 0.1 % | bias % |")
    yield "|---|---|---|---|---|---|---|---|---|---|"
    for method, budget in sorted(groups, key=lambda key: (methods.index(key[0]), key[1])):
        same = groups[method, budget]
        run, cpu = same[0], statistics.median(r["cpu_seconds"] for r in same)
        traced = run["traced"] / run["entries"] if run["entries"] else None
        cells = [f"`{method}`", run["knob"] or "-", f"{cpu:.1f}", f"{run['shadow_rays'] / 1e6:.0f}", share(traced),
                 f"{run['clusters_mean']:.0f}" if run["clusters_mean"] else "-",
                 f"{run['method_bytes'] / 2**20:.1f}" if run["method_bytes"] else "-",
                 share(run["relative_rmse"]), share(run["relative_rmse_without_worst"]), share(run["bias"])]
        yield f"| {' | '.join(cells)} |"


def at_error(curve, error):
    """Seconds at an error, straight between the points (error, seconds) on logarithmic axes; a curve's best times count."""
    best = []
    for e, t in sorted(curve, key=lambda point: point[1]):
        if not best or e < best[-1][0]:
            best.append((e, t))
    for (e0, t0), (e1, t1) in zip(best, best[1:]):
        if e1 <= error <= e0:
            x = math.log(e0 / error) / math.log(e0 / e1)
            return t0 * (t1 / t0) ** x
    return best[0][1] if error >= best[0][0] else None


def speedups(runs, against):
    """Lines of one scene's table of times at equal error, at the ends of the errors that both methods reach."""
    curves = {}
    for run in runs:
        if run["relative_rmse"]:
            curves.setdefault(run["method"], []).append((run["relative_rmse"], run["cpu_seconds"]))
    yield f"| method | at error % | CPU s over {against}'s | at error % | CPU s over {against}'s |"
    yield "|---|---|---|---|---|"
    for method, curve in curves.items():
        if method == against or against not in curves:
            continue
        errors = [[e for e, _ in c] for c in (curve, curves[against])]
        ends = max(map(min, errors)), min(map(max, errors))
        if min(errors[0]) > max(errors[1]):  # even the other's cheapest run is better
            best, seconds = min(curve)
            yield f"| `{method}` | {100 * best:.2f} | > {seconds / min(t for _, t in curves[against]):.2f} | | |"
            continue
        if ends[0] > ends[1]:
            yield f"| `{method}` | {100 * max(errors[0]):.2f} | not reached by `{against}` | | |"
            continue
        cells = [f"{100 * e:.2f} | {at_error(curve, e) / at_error(curves[against], e):.2f}" for e in ends]
        yield f"| `{method}` | {cells[0]} | {cells[1]} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench", type=pathlib.Path)
    parser.add_argument("--against", help="method that times at equal error are compared with")
    args = parser.parse_args()
    runs = [json.loads(line) for line in (args.bench / "runs.jsonl").read_text().splitlines()]
    for scene in dict.fromkeys(run["scene"] for run in runs):
        of_scene = [run for run in runs if run["scene"] == scene]
        lines = speedups(of_scene, args.against) if args.against else table(of_scene)
        print(f"### {scene}\n\n" + "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
