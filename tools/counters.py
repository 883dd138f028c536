#!/usr/bin/env python3
"""Counts that a render must repeat exactly: tools/counters.py PROGRAM [--renew]

Renders a small shipped scene by several methods and compares the counters of its statistics with tools/counters.json:
how many rays, entries, lights, and the bytes of slices. They do not depend on threads, instruction set or load, so that
a change of the work done is seen however small. --renew writes the file anew; commit it with the reason.

Exit status: 0 same (or renewed), 1 something differs.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
STORED = ROOT / "tools" / "counters.json"
METHODS = ("lbamc", "bamc", "amc", "gauss-jordan", "matrix-separation", "slice-lightcuts", "lightslice", "lightcuts",
           "illumination-cut", "illumination-cut-sampling")
OPTIONS = ("--size", "64x36", "--vpls", "2000", "--clusters", "200", "--seed", "0")
RUNS = [("cornell-box", method) for method in METHODS]
RUNS += [("living-room", method) for method in ("lbamc", "bamc", "slice-lightcuts", "illumination-cut")]
# Depend on the machine: the process's own memory, Embree's trees (wider ones for wider vectors), and what was foretold
# from the number of threads.
NOT_EXACT = {"memory_bytes.peak_rss", "memory_bytes.predicted", "memory_bytes.scene"}


def flat(value, name=""):
    """(dotted name, number) of all whole numbers within a parsed JSON value."""
    if isinstance(value, dict):
        for key in value:
            yield from flat(value[key], f"{name}.{key}" if name else key)
    elif isinstance(value, int) and not isinstance(value, bool):
        yield name, value


def of_stats(stats):
    """Counters of a stats.json: whole numbers but for what depends on the machine or was asked for."""
    skipped = ("parameters", "seed", "threads", "passes")
    return {name: value for name, value in flat({k: v for k, v in stats.items() if k not in skipped})
            if name not in NOT_EXACT}


def render(program, scene, method, options=OPTIONS, threads=0):
    """The parsed statistics of a render of a shipped scene."""
    with tempfile.TemporaryDirectory() as folder:
        stats = pathlib.Path(folder) / "stats.json"
        subprocess.run([program, "render", str(ROOT / "scenes" / scene / "scene.xml"), "-o", f"{folder}/a.exr",
                        "--method", method, "--threads", str(threads), "--progress", "none", "--stats", str(stats),
                        *options], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        return json.loads(stats.read_text())


def differences(before, after):
    """Lines that say which counter went from what to what; of nested {run: {counter: number}}."""
    for run in sorted(before.keys() | after.keys()):
        a, b = before.get(run, {}), after.get(run, {})
        for counter in sorted(a.keys() | b.keys()):
            if a.get(counter) != b.get(counter):
                old, new = a.get(counter), b.get(counter)
                share = f" ({100 * (new / old - 1):+.3g} %)" if old and new is not None else ""
                yield f"{run}: {counter}: {old} -> {new}{share}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--renew", action="store_true", help="write what this program counts")
    parser.add_argument("--stored", type=pathlib.Path, default=STORED, help="file to compare with or to write")
    args = parser.parse_args()
    measured, unsteady = {}, []
    for scene, method in RUNS:
        run = f"{scene}/{method}"
        measured[run] = of_stats(render(args.program, scene, method))
        if scene == "cornell-box":  # loads at once
            again = of_stats(render(args.program, scene, method, threads=1))
            unsteady += differences({run: measured[run]}, {run: again})
    if unsteady:
        print("Counters depend on the number of threads (all threads -> one):", *unsteady, sep="\n  ")
        return 1
    if args.renew:
        args.stored.write_text(json.dumps(measured, indent=1, sort_keys=True) + "\n")
        print(f"wrote {args.stored}: {sum(map(len, measured.values()))} counters of {len(measured)} renders")
        return 0
    stored = json.loads(args.stored.read_text()) if args.stored.exists() else {}
    changed = list(differences(stored, measured))
    if changed:
        print("Counters changed:", *changed, sep="\n  ")
        print(f"If this is meant: tools/counters.py {args.program} --renew, and say why in the commit.")
    return 1 if changed else 0


if __name__ == "__main__":
    sys.exit(main())
