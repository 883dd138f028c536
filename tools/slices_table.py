#!/usr/bin/env python3
"""Tables of docs/visibility.md from `slices_bench --json` lines of bamc and of lbamc at several slacks.

    slices_table.py LINES.jsonl...   one table a file: speed and error at each slack, the best speed within 1 % error, and
                                     lbamc's speed over bamc's at bamc's error (straight lines in the logarithm of error)
"""
import json
import math
import sys


def slack_of(variant):
    return next((float(word[6:]) for word in variant.split() if word.startswith("slack=")), 1.0)


def speed_at(curve, error):
    """Speed of a curve of (error, speed) at an error; None outside it."""
    curve = sorted(curve)
    for (e0, s0), (e1, s1) in zip(curve, curve[1:]):
        if e0 <= error <= e1:
            return s0 + (s1 - s0) * math.log(error / e0) / math.log(e1 / e0) if e1 > e0 else s0
    return curve[-1][1] if error > curve[-1][0] else None


def cell(value):
    return "-" if value is None else f"{value:.2f}"


def table(lines):
    scenes = {}
    for line in lines:
        scenes.setdefault(line["scene"], []).append(line)
    slacks = sorted({slack_of(line["variant"]) for line in lines if line["variant"].startswith("lbamc")})
    with_bamc = any(line["variant"] == "bamc" for line in lines)
    head = ["scene", "full, ms a slice", *(f"slack {slack:g}" for slack in slacks), "within 1 %"]
    head += ["bamc", "lbamc over bamc at its error"] if with_bamc else []
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    bests, gains = [], []
    for scene, runs in scenes.items():
        points = {slack_of(r["variant"]): (r["rmse_percent"], r["speedup"]) for r in runs if r["variant"].startswith("lbamc")}
        best = max((speed for error, speed in points.values() if error <= 1), default=None)
        row = [scene, f"{runs[0]['full_ms_a_slice']:.1f}"]
        row += [f"{points[s][1]:.2f} ({points[s][0]:.2f} %)" for s in slacks] + [cell(best)]
        bests += [best] if best else []
        for bamc in (r for r in runs if r["variant"] == "bamc"):
            speed = speed_at(points.values(), bamc["rmse_percent"])
            gain = speed and speed / bamc["speedup"]
            gains += [gain] if gain else []
            row += [f"{bamc['speedup']:.2f} ({bamc['rmse_percent']:.2f} %)", cell(gain)]
        print("| " + " | ".join(row) + " |")

    def mean(values):
        return math.exp(sum(map(math.log, values)) / len(values))
    print(f"\nGeometric means: within 1 %, {mean(bests):.2f} ({len(bests)} of {len(scenes)} scenes)"
          + (f"; over bamc, {mean(gains):.2f} ({len(gains)} scenes)" if gains else ""))


for path in sys.argv[1:]:
    with open(path) as file:
        table([json.loads(line) for line in file])
