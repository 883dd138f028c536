#!/usr/bin/env python3
"""Runs all benchmarks of a build folder into one JSON file: tools/run_benchmarks.py BUILD [--quick] [-o FILE]

Ratios are taken inside one process and counters are exact; times are reported as median, least and most over
repetitions, and depend on the machine and what else runs on it. docs/benchmarks.md says what each entry means.
"""
import argparse
import datetime
import json
import os
import pathlib
import platform
import re
import resource
import statistics
import subprocess
import sys
import tempfile

import counters

ROOT = pathlib.Path(__file__).resolve().parents[1]
FORMAT = 1


class Program:
    """Options of Google Benchmark for one program: seconds a repetition, repetitions, which benchmarks; if quick."""

    def __init__(self, name, seconds, repetitions, only=".", quick_only=None):
        self.name, self.seconds, self.repetitions, self.only = name, seconds, repetitions, only
        self.quick_only = quick_only or only

    def options(self, quick):
        seconds, repetitions = (min(self.seconds, 0.02), 3) if quick else (self.seconds, self.repetitions)
        return [f"--benchmark_min_time={seconds}", f"--benchmark_repetitions={repetitions}",
                f"--benchmark_filter={self.quick_only if quick else self.only}"]


# Trees of ten million lights and long scaling series are left to the programs themselves.
PROGRAMS = (
    Program("limits_bench", 0.1, 5),
    Program("trace_bench", 0.2, 5),
    Program("visibility_bench", 0.5, 5),
    Program("stages_bench", 0.2, 5),
    Program("kernels_bench", 0.05, 5),
    Program("shading_bench", 0.1, 5),
    Program("completion_bench", 0.05, 3, only="^(completion|slice|draw_omega|match)/"),
    Program("clusters_bench", 0.1, 3, only="^(slices|light_tree|agglomerative_tree|cut)/(250|1000|2000|[0-9]{5,7})/",
            quick_only="^(slices|light_tree|cut)/(1000|[0-9]{5,6})/"),
)
FRAME_METHODS = {"cornell-box": ("slice-lightcuts", "bamc", "lbamc", "lightcuts", "illumination-cut", "path"),
                 "living-room": ("slice-lightcuts", "bamc", "lbamc", "lightcuts", "path")}
FRAME_OPTIONS = ("--size", "160x90", "--vpls", "20000", "--clusters", "500")


def spread(values):
    """Median, least and most of a list of numbers."""
    return {"median": statistics.median(values), "min": min(values), "max": max(values), "n": len(values)}


def is_counter(name):
    """Counters that are exact by their names: n_rays, bytes, bytes_nodes."""
    return name.startswith("n_") or name.split("_")[0] == "bytes"


def entry_of(repetitions):
    """One entry of the file, from the repetitions of one benchmark in Google Benchmark's JSON."""
    first = repetitions[0]
    errors = [r["error_message"] for r in repetitions if r.get("error_occurred")]
    if errors:
        return {"error": errors[0]}
    known = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions",
             "repetition_index", "threads", "iterations", "real_time", "cpu_time", "time_unit"}
    entry = {"unit": first["time_unit"], "cpu_time": spread([r["cpu_time"] for r in repetitions]),
             "real_time": spread([r["real_time"] for r in repetitions]), "measures": {}, "counters": {}}
    for name in first:
        if name in known or not isinstance(first[name], (int, float)):
            continue
        values = [r[name] for r in repetitions]
        if is_counter(name) and len(set(values)) == 1:
            entry["counters"][name] = round(values[0])
        else:
            entry["measures"][name] = spread(values)
    return entry


def entries_of(program, parsed):
    """All entries of one program's JSON, by name."""
    groups = {}
    for run in parsed["benchmarks"]:
        if run.get("run_type") != "aggregate":
            groups.setdefault(run.get("run_name", run["name"]), []).append(run)
    return {f"{program}/{name}": entry_of(runs) for name, runs in groups.items()}


def run_program(path, options):
    """Parsed JSON of one run of a benchmark program."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.json"
        subprocess.run([path, f"--benchmark_out={out}", "--benchmark_out_format=json", *options], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return json.loads(out.read_text())


def render(program, scene, method):
    """Statistics of one frame, and CPU seconds of all its threads."""
    def used():
        u = resource.getrusage(resource.RUSAGE_CHILDREN)
        return u.ru_utime + u.ru_stime
    before = used()
    few = ("--spp", "8") if method == "path" else ()
    stats = counters.render(program, scene, method, FRAME_OPTIONS + few)
    return stats, used() - before


def frames(program, rounds, quick):
    """Entries of whole frames, methods in turn within a round. `over_slice_lightcuts`: CPU time over that of the same
    round's slice-lightcuts."""
    entries = {}
    for scene, methods in FRAME_METHODS.items():
        if quick and scene != "cornell-box":
            continue
        runs = {method: [] for method in methods}
        for _ in range(rounds):
            for method in methods:
                runs[method].append(render(program, scene, method))
        for method, results in runs.items():
            entry = {"unit": "s", "cpu_time": spread([cpu for _, cpu in results]),
                     "real_time": spread([stats["time_s"]["total"] for stats, _ in results]),
                     "counters": counters.of_stats(results[0][0])}
            ratios = [cpu / base for (_, cpu), (_, base) in zip(results, runs["slice-lightcuts"])]
            entry["measures"] = {"over_slice_lightcuts": spread(ratios)}
            for stage, taken in results[0][0]["time_s"].items():
                if stage != "total" and taken is not None:
                    shares = [stats["time_s"][stage] / stats["time_s"]["total"] for stats, _ in results]
                    entry["measures"][f"share_{stage}"] = spread(shares)
            entries[f"frames/{scene}/{method}"] = entry
    return entries


def commit():
    """Of the source folder, with + if it has changes; empty where git does not know."""
    said = subprocess.run(["git", "-C", str(ROOT), "describe", "--always", "--dirty=+"], capture_output=True, text=True)
    return said.stdout.strip()


def measure(build, quick=False, only=".", tell=lambda line: None):
    """The whole file's content. `only`: expression that a program's name must hold ("frames" for whole frames)."""
    build = pathlib.Path(build)
    result = {"format": FORMAT, "context": {
        "date": datetime.datetime.now().isoformat(timespec="seconds"), "commit": commit(), "quick": quick,
        "cpus": os.cpu_count(), "machine": platform.machine(), "load_before": os.getloadavg()[0]}, "entries": {}}
    for program in PROGRAMS:
        path = build / "bench" / program.name
        if not re.search(only, program.name):
            continue
        if not path.exists():
            tell(f"{program.name}: not built")
            continue
        parsed = run_program(path, program.options(quick))
        result["context"].setdefault("mhz", parsed["context"].get("mhz_per_cpu"))
        found = entries_of(program.name, parsed)
        result["entries"].update(found)
        tell(f"{program.name}: {len(found)} entries")
    if re.search(only, "frames"):
        found = frames(build / "myrialux", 1 if quick else 3, quick)
        result["entries"].update(found)
        tell(f"frames: {len(found)} entries")
    result["context"]["load_after"] = os.getloadavg()[0]
    return result


# What the summary shows, where an entry has it: ratios inside one process first.
SHOWN = ("ratio_to_embree16", "ratio_to_embree", "ratio_to_plain", "over_slice_lightcuts", "copies", "active_over_raw",
         "cut_over_raw", "energies_over_raw", "trace_over_raw", "shade_over_raw", "GB/s", "Mrays/s", "pairs", "traced")


def summary(result):
    """Short lines for the terminal."""
    for name, entry in result["entries"].items():
        if "error" in entry:
            yield f"{name:58} {entry['error']}"
            continue
        t = entry["cpu_time"]
        cells = [f"{key} {entry['measures'][key]['median']:.4g}" for key in SHOWN if key in entry["measures"]]
        yield f"{name:58} {t['median']:9.4g} {entry['unit']:2} [{t['min']:.4g}, {t['max']:.4g}]  {'  '.join(cells)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, help="default: BUILD/bench.json")
    parser.add_argument("--quick", action="store_true", help="shipped scenes only, few repetitions")
    parser.add_argument("--only", default=".", help="programs whose names hold this expression")
    args = parser.parse_args()
    if args.quick:
        os.environ["MYRIALUX_SCENES"] = os.environ["MYRIALUX_SCENES_UNPACKED"] = ""
    else:
        os.environ.setdefault("MYRIALUX_SCENES", str(ROOT.parent / "shared" / "scenes"))
    result = measure(args.build, args.quick, args.only, lambda line: print(line, file=sys.stderr, flush=True))
    output = args.output or args.build / "bench.json"
    output.write_text(json.dumps(result, indent=1) + "\n")
    print(*summary(result), sep="\n")
    print(f"wrote {output}: {len(result['entries'])} entries; CPU time: median [least, most]")


if __name__ == "__main__":
    main()
