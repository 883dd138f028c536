#!/usr/bin/env python3
"""Scenes of tools/make_scene.py: same bytes each time, nothing to complain about, as many triangles as promised.

    make_scene_test.py PROGRAM
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import make_scene

PROGRAM = os.path.abspath(sys.argv.pop(1))


def make(kind, folder, *options):
    said = subprocess.run([sys.executable, str(ROOT / "tools" / "make_scene.py"), kind, str(folder), *options],
                          check=True, capture_output=True, text=True).stdout
    return int(re.search(r"(\d+) triangles", said)[1])


def files(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def faces(contents):
    """Triangles by the headers of the PLY files; every record of a file must be there."""
    total = 0
    for name, data in contents.items():
        if name.endswith(".ply"):
            header, body = data.split(b"end_header\n", 1)
            vertices, triangles = (int(re.search(rb"element %s (\d+)" % what, header)[1]) for what in (b"vertex", b"face"))
            assert len(body) == 12 * vertices + 13 * triangles, name
            total += triangles
    return total


class MadeScenes(unittest.TestCase):
    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.folder = pathlib.Path(made.name)

    def test_SameArgumentsWriteTheSameBytes(self):
        for kind in make_scene.MAKERS:
            for again in ("a", "b"):
                make(kind, self.folder / kind / again, "--detail", "0.01")
            self.assertEqual(files(self.folder / kind / "a"), files(self.folder / kind / "b"), kind)

    def test_ReadWithoutAWarning(self):
        for kind in make_scene.MAKERS:
            make(kind, self.folder / kind, "--detail", "0.01", "--size", "64x36")
            check = subprocess.run([PROGRAM, "check", str(self.folder / kind / "scene.xml"), "--strict"],
                                   capture_output=True, text=True)
            self.assertEqual(check.returncode, 0, check.stdout + check.stderr)
            self.assertIn("no errors, 0 warnings, 0 things that cannot be rendered", check.stdout + check.stderr)

    def test_TrianglesAsPromised(self):
        for kind, promised in make_scene.TRIANGLES.items():
            for detail, within in ((0.02, 0.25), (1.0, 0.01)):
                if detail == 1.0 and kind == "hair-ball":
                    continue  # seconds; its count is exact at every size
                with self.subTest(kind=kind, detail=detail):
                    told = make(kind, self.folder / kind, "--detail", str(detail))
                    self.assertEqual(told, faces(files(self.folder / kind)))
                    self.assertAlmostEqual(told / (detail * promised), 1, delta=within)

    def test_BadArgumentsAreRefused(self):
        with self.assertRaises(subprocess.CalledProcessError):
            make("foliage", self.folder, "--detail", "0")
        with self.assertRaises(subprocess.CalledProcessError):
            make("foliage", self.folder, "--size", "64")


if __name__ == "__main__":
    unittest.main()
