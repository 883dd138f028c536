#!/usr/bin/env python3
"""CPU seconds of a frame that no second thread could take: samples of `perf` outside all parallel loops, by function.

    serial_time.py PROGRAM [more arguments of the program ...]     for example: serial_time.py P render S.xml -o x.exr

Runs the program with one thread under `perf record -e cpu-clock`. A sample is parallel if a loop over work items or a
pair of calls (base/parallel.h) is on its stack, or the compression of a picture. Prints the seconds of each kind, the
serial ones by the function of this program that they were spent below, and what Amdahl's law makes of them for 2, 16
and 64 threads.
"""
import collections
import pathlib
import re
import subprocess
import sys
import tempfile

RATE = 249  # samples a second
PARALLEL = ("split_range", "run_both", "compress")  # the last: OpenEXR's threads, which are none where one is allowed
BOTTOM = ("_start", "_dl_start_user")  # of stacks that were read to their end; those of Embree's code cannot be
FRAME = re.compile(r"^\s+[0-9a-f]+ (.*?)(?:\+0x[0-9a-f]+)? \(.*\)$")


def stacks(text):
    """Lists of functions, innermost first, one a sample."""
    for block in text.split("\n\n"):
        frames = [m[1] for m in map(FRAME.match, block.splitlines()) if m]
        if frames:
            yield frames


def short_name(function):
    """Without arguments and namespaces."""
    name = re.sub(r"\(anonymous namespace\)::|myrialux::|\[clone.*\]", "", function)
    return re.sub(r"[(<].*", "", name).strip() or function


def own_function(frames):
    """The innermost function of this program; else where the stack begins."""
    return next((short_name(f) for f in frames if "myrialux::" in f), short_name(frames[-1]))


def kind(frames):
    if frames[-1] not in BOTTOM:
        return "broken"
    return "parallel" if any(p in f for f in frames for p in PARALLEL) else "serial"


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        data = str(pathlib.Path(folder) / "perf.data")
        subprocess.run(["perf", "record", "-q", "-F", str(RATE), "-e", "cpu-clock", "--call-graph", "dwarf,65528", "-o",
                        data, *sys.argv[1:], "--threads", "1"], check=True, stdout=subprocess.DEVNULL)
        text = subprocess.run(["perf", "script", "--no-inline", "-i", data, "-F", "ip,sym,dso"], check=True,
                              capture_output=True, text=True).stdout
    serial, kinds = collections.Counter(), collections.Counter()
    for frames in stacks(text):
        kinds[kind(frames)] += 1
        if kind(frames) == "serial":
            serial[own_function(frames)] += 1
    n = sum(kinds.values())
    n_serial, n_broken = kinds["serial"], kinds["broken"]
    print(f"{n / RATE:.2f} s in all, {n_serial / RATE:.3f} s outside parallel loops, {n_broken / RATE:.2f} s in stacks "
          "that cannot be read (Embree's rays)\n")
    print("| serial, below | s |\n|---|---|")
    for function, count in serial.most_common(12):
        print(f"| {function} | {count / RATE:.3f} |")
    speedups = [f"{n / (n_serial + (n - n_serial) / threads):.1f} with {threads}" for threads in (2, 16, 64)]
    print(f"\nat most {', '.join(speedups)} threads")


if __name__ == "__main__":
    main()
