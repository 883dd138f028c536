#!/usr/bin/env python3
"""tools/run_benchmarks.py, compare_bench and counters.py: entries from Google Benchmark's JSON, pairs, verdicts, counters.

    benchmarks_test.py PROGRAM
"""
import contextlib
import copy
import importlib.machinery
import importlib.util
import io
import json
import os
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"
sys.dont_write_bytecode = True
sys.path.insert(0, str(TOOLS))
import counters  # noqa: E402
import run_benchmarks  # noqa: E402


def load_script(name):
    loader = importlib.machinery.SourceFileLoader(name, str(TOOLS / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


compare_bench = load_script("compare_bench")
PROGRAM = os.path.abspath(sys.argv.pop(1))


def repetition(name, time, **more):
    return {"name": name, "run_name": name, "run_type": "iteration", "repetitions": 3, "repetition_index": 0,
            "threads": 1, "iterations": 7, "real_time": 2 * time, "cpu_time": time, "time_unit": "ms", **more}


def result(entries):
    return {"format": 1, "context": {}, "entries": entries}


def entry(times, counts=None, measures=None):
    return {"unit": "ms", "cpu_time": run_benchmarks.spread(times), "real_time": run_benchmarks.spread(times),
            "measures": {k: run_benchmarks.spread(v) for k, v in (measures or {}).items()}, "counters": counts or {}}


class Entries(unittest.TestCase):
    def test_RepetitionsAreSummedUp(self):
        runs = [repetition("a/1", t, ratio=r, n_rays=10.0) for t, r in ((3.0, 0.9), (1.0, 0.8), (2.0, 1.0))]
        mean = {**repetition("a/1", 9.0), "run_type": "aggregate"}
        found = run_benchmarks.entries_of("x_bench", {"benchmarks": runs + [mean]})
        self.assertEqual(list(found), ["x_bench/a/1"])
        self.assertEqual(found["x_bench/a/1"]["cpu_time"], {"median": 2.0, "min": 1.0, "max": 3.0, "n": 3})
        self.assertEqual(found["x_bench/a/1"]["measures"]["ratio"]["median"], 0.9)
        self.assertEqual(found["x_bench/a/1"]["counters"], {"n_rays": 10})

    def test_CountersThatWaverAreNotExact(self):
        runs = [repetition("a", 1.0, n_rays=n) for n in (1.0, 2.0)]
        found = run_benchmarks.entries_of("x", {"benchmarks": runs})["x/a"]
        self.assertEqual(found["counters"], {})
        self.assertEqual(found["measures"]["n_rays"]["max"], 2.0)

    def test_ErrorsAreKept(self):
        runs = [repetition("a", 1.0, error_occurred=True, error_message="no scene")]
        found = run_benchmarks.entries_of("x", {"benchmarks": runs})
        self.assertEqual(found["x/a"], {"error": "no scene"})
        self.assertIn("no scene", next(run_benchmarks.summary(result(found))))


class Verdicts(unittest.TestCase):
    def test_OnlyMoreThanTheSpreadCounts(self):
        spread = run_benchmarks.spread
        self.assertEqual(compare_bench.verdict(spread([9, 10, 11]), spread([10, 11, 12])), "same")
        self.assertEqual(compare_bench.verdict(spread([9, 10, 11]), spread([12, 13, 14])), "more")
        self.assertEqual(compare_bench.verdict(spread([9, 10, 11]), spread([6, 7, 7])), "less")
        self.assertEqual(compare_bench.verdict(spread([9]), spread([6])), "one run")


class Comparison(unittest.TestCase):
    parent = result({"a": entry([10, 11, 12], {"n_rays": 100, "bytes": 8}, {"ratio": [0.9, 0.91, 0.9]}),
                     "gone": entry([1, 1]), "broken": {"error": "no scene"}})

    def run_tool(self, change, *options):
        with tempfile.TemporaryDirectory() as folder:
            paths = [pathlib.Path(folder) / name for name in ("parent.json", "change.json")]
            for path, content in zip(paths, (self.parent, change)):
                path.write_text(json.dumps(content))
            said = io.StringIO()
            with contextlib.redirect_stdout(said), \
                    mock.patch.object(sys, "argv", ["compare_bench", *map(str, paths), *options]):
                code = compare_bench.main()
        return code, said.getvalue()

    def test_SameIsSaidSo(self):
        code, said = self.run_tool(self.parent, "--counters")
        self.assertEqual(code, 0)
        self.assertIn("no counter changed", said)
        self.assertRegex(said, r"a +11 .* 11 .* 1\.000  same")
        self.assertIn("failed in parent: broken: no scene", said)

    def test_ChangesAreTold(self):
        change = copy.deepcopy(self.parent)
        change["entries"]["a"] = entry([20, 22, 24], {"n_rays": 110, "bytes": 8}, {"ratio": [0.7, 0.71, 0.7]})
        change["entries"]["new"] = change["entries"].pop("gone")
        code, said = self.run_tool(change)
        self.assertEqual(code, 0, "changed counters fail only where asked for")
        self.assertRegex(said, r"2\.000  more")
        self.assertRegex(said, r"    ratio .* 0\.778  less")
        self.assertIn("a: n_rays: 100 -> 110 (+10 %)", said)
        self.assertIn("only in parent: gone", said)
        self.assertIn("only in change: new", said)
        self.assertEqual(self.run_tool(change, "--counters")[0], 1)

    def test_RoundsAreJoined(self):
        joined = compare_bench.joined([result({"a": entry([1, 2, 3])}), result({"a": entry([5, 6, 7])}),
                                       result({"a": entry([3, 4, 5])})])
        self.assertEqual(joined["entries"]["a"]["cpu_time"], {"median": 4, "min": 1, "max": 7, "n": 9})

    def test_RunsBothBuildsInTurn(self):
        order = []

        def measure(build, quick, only):
            order.append((build, only))
            return result({only: entry([1, 2])})
        with mock.patch.object(run_benchmarks, "measure", measure):
            results = compare_bench.run_both(("A", "B"), True, 2, "trace|frames")
        self.assertEqual([b for b, _ in order], ["A", "B"] * 4)
        self.assertEqual([sorted(r["entries"]) for r in results], [["^frames$", "^trace_bench$"]] * 2)


class Counters(unittest.TestCase):
    def test_WholeNumbersOfStatisticsButThoseOfTheMachine(self):
        stats = {"seed": 3, "threads": 2, "passes": 1, "receivers": 5, "rays": {"shadow": 7}, "time_s": {"total": 0.5},
                 "memory_bytes": {"peak_rss": 9, "slices_peak": 8}, "warnings": [], "ok": True}
        self.assertEqual(counters.of_stats(stats), {"receivers": 5, "rays.shadow": 7, "memory_bytes.slices_peak": 8})

    def test_DifferencesSayFromWhatToWhat(self):
        lines = list(counters.differences({"r": {"a": 4, "b": 1}}, {"r": {"a": 5, "c": 2}}))
        self.assertEqual(lines, ["r: a: 4 -> 5 (+25 %)", "r: b: 1 -> None", "r: c: None -> 2"])

    def test_AChangeFailsAndSaysHowToRenew(self):
        with tempfile.TemporaryDirectory() as folder:
            stored = pathlib.Path(folder) / "counters.json"

            def run(*options):
                said = io.StringIO()
                with contextlib.redirect_stdout(said), mock.patch.object(counters, "RUNS", [("cornell-box", "bamc")]), \
                        mock.patch.object(sys, "argv", ["counters", PROGRAM, "--stored", str(stored), *options]):
                    return counters.main(), said.getvalue()
            self.assertEqual(run("--renew")[0], 0)
            self.assertEqual(run(), (0, ""))
            content = json.loads(stored.read_text())
            shadow = content["cornell-box/bamc"]["rays.shadow"]
            content["cornell-box/bamc"]["rays.shadow"] = shadow + 1
            stored.write_text(json.dumps(content))
            code, said = run()
            self.assertEqual(code, 1)
            self.assertIn(f"rays.shadow: {shadow + 1} -> {shadow}", said)
            self.assertIn("--renew", said)


if __name__ == "__main__":
    unittest.main()
