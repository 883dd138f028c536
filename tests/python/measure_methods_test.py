#!/usr/bin/env python3
"""tools/measure_methods.py: curves are read right, and every subcommand of the papers' figures fills its table.

    measure_methods_test.py PROGRAM

Exit status: 77 NumPy or OpenEXR is missing (skipped).
"""
import os
import pathlib
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOL = ROOT / "tools" / "measure_methods.py"
sys.path.insert(0, str(TOOL.parent))
try:
    import measure_methods
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)

PROGRAM = os.path.abspath(sys.argv.pop(1))


class AtError(unittest.TestCase):
    def test_IsStraightOnLogarithmicAxes(self):
        curve = [(0.1, 1.0), (0.001, 100.0)]
        self.assertAlmostEqual(measure_methods.at_error(curve, 0.01), 10)
        self.assertAlmostEqual(measure_methods.at_error(curve, 0.001), 100)
        self.assertAlmostEqual(measure_methods.at_error(curve, 0.1), 1)

    def test_SlowerAndWorsePointsDoNotCount(self):
        curve = [(0.1, 1.0), (0.5, 2.0), (0.1, 3.0), (0.01, 10.0)]
        self.assertAlmostEqual(measure_methods.at_error(curve, 0.01), 10)
        self.assertAlmostEqual(measure_methods.at_error(curve, 0.05), 10 ** 0.30103, places=4)

    def test_ErrorsBelowTheLeastAreNotReached(self):
        self.assertIsNone(measure_methods.at_error([(0.1, 1.0)], 0.05))


class Tables(unittest.TestCase):
    def table(self, what, *options):
        """Rows without the two lines of each head; every row has the head's cells, all filled."""
        said = subprocess.run([sys.executable, str(TOOL), PROGRAM, what, str(ROOT / "scenes/cornell-box/scene.xml"),
                               "--size", "16x16", "--spp", "1", "--vpls", "200", "--clusters", "50", *options],
                              check=True, capture_output=True, text=True).stdout
        lines = [line.strip("|").split("|") for line in said.splitlines() if line.startswith("|")]
        rows = []
        for line in lines:
            if line[0].strip() == "cornell-box":
                self.assertEqual(len(line), len(lines[0]))
                self.assertTrue(all(cell.strip() for k, cell in enumerate(line) if k != 2), line)
                rows.append([cell.strip() for cell in line])
        return rows

    def test_Sampling(self):
        rows = self.table("sampling")
        self.assertEqual([row[1] for row in rows].count("bamc"), 12)
        self.assertEqual([row[3] for row in rows].count("adapted"), 2)

    def test_CompletionTime(self):
        self.assertEqual([row[1] for row in self.table("completion-time")], ["bamc", "gauss-jordan", "amc"] * 2)

    def test_Pairs(self):
        rows = {(row[1], row[2]): row for row in self.table("pairs")}
        coarse, fine = (rows["illumination-cut", e] for e in ("6 %", "0.15 %"))
        self.assertGreater(int(fine[3]), int(coarse[3]))
        self.assertLess(float(fine[7]), float(coarse[7]))

    def test_Lights(self):
        rows = self.table("lights", "--counts", "100,300")
        self.assertEqual(len(rows), 12)
        self.assertEqual([int(row[2]) < 200 for row in rows], [True, False] * 6)

    def test_Speedups(self):
        rows = {row[1]: row for row in self.table("speedups", "--budgets", "0.5,2", "--", "--repeats", "1")}
        self.assertEqual(rows["bamc"][3], "1.00")


if __name__ == "__main__":
    unittest.main()
