#!/usr/bin/env python3
"""How a frame's time falls with threads, stage by stage, and how much memory it takes at most; prints Markdown tables.

    measure_scaling.py PROGRAM SCENE.xml [--size 1280x720] [--runs 3] [-- more options of render]

Runs with 1 and 2 threads alternate, so that a drift of the machine's speed hits both; medians of the runs.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile


def main():
    own = sys.argv[1:]
    extra = own[own.index("--") + 1:] if "--" in own else []
    own = own[:own.index("--")] if "--" in own else own
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--runs", type=int, default=3)
    options = parser.parse_args(own)
    times, memory = {1: [], 2: []}, 0
    with tempfile.TemporaryDirectory() as name:
        stats_file = pathlib.Path(name) / "stats.json"
        for _ in range(options.runs):
            for threads in times:
                subprocess.run([options.program, "render", str(options.scene), "--size", options.size, "--threads",
                                str(threads), "--progress", "none", "-o", str(pathlib.Path(name) / "picture.exr"),
                                "--stats", str(stats_file), *extra], check=True)
                stats = json.loads(stats_file.read_text())
                times[threads].append(stats["time_s"])
                memory = max(memory, stats["memory_bytes"]["peak_rss"])
    print("| stage | 1 thread, s | 2 threads, s | ratio |\n|---|---|---|---|")
    for stage in times[1][0]:
        one, two = (statistics.median(run[stage] for run in times[n]) for n in (1, 2))
        if one >= 0.05:
            print(f"| {stage} | {one:.2f} | {two:.2f} | {one / two:.2f} |")
    print(f"\npeak memory {memory / 2**20:.0f} MiB")


if __name__ == "__main__":
    main()
