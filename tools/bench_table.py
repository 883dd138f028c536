#!/usr/bin/env python3
"""Prints the results of a `myrialux bench` as Markdown tables, one a scene: tools/bench_table.py BENCH

Reads runs.jsonl, so an unfinished bench will do. CPU seconds are those of all threads, medians of the repeats; errors are
of luminance over the mean of the light that virtual lights bring, against brute force on the same lights.
"""
import json
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


def main(folder):
    runs = [json.loads(line) for line in (pathlib.Path(folder) / "runs.jsonl").read_text().splitlines()]
    for scene in dict.fromkeys(run["scene"] for run in runs):
        print(f"### {scene}\n")
        print("\n".join(table([run for run in runs if run["scene"] == scene])), "\n")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
