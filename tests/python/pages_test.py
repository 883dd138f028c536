#!/usr/bin/env python3
"""Pages and FLIP: python/myrialux alone and as the program runs it.

    pages_test.py PROGRAM

Exit status: 77 the packages of python/requirements.txt are missing (skipped).
"""
import base64
import html.parser
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
try:
    import flip_evaluator
    import numpy as np
    import plotly  # noqa: F401
    from PIL import Image
except ImportError as missing:
    print(f"skipped: {missing}; tools/setup_python.sh installs it")
    sys.exit(77)
from myrialux import compare, flip
from myrialux.report import figures, pictures, tables
from myrialux.report.page import Page

PROGRAM = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 else ""


def noise(seed, height=24, width=32):
    return np.random.default_rng(seed).random((height, width, 3), np.float32)


class Tags(html.parser.HTMLParser):
    """Counts tags, and collects what a browser would fetch and the text that a reader sees."""

    def __init__(self, text):
        super().__init__()
        self.counts, self.fetched, self.seen, self._hidden = {}, [], "", 0
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.counts[tag] = self.counts.get(tag, 0) + 1
        self._hidden += tag in ("script", "style")
        for name, value in attributes:
            if name in ("src", "href", "srcset", "data", "action") or (name == "style" and "url(" in value):
                self.fetched.append(value)

    def handle_endtag(self, tag):
        self._hidden -= tag in ("script", "style")

    def handle_data(self, data):
        self.seen += "" if self._hidden else data


def embedded_pictures(text):
    """name -> data URL, as the sliders find them."""
    return json.loads(re.search(r"^<script>const pictures = (\{.*\});$", text, re.M)[1])


class Flip(unittest.TestCase):
    def test_of_equal_pictures_is_zero(self):
        for measure in (lambda a, b: flip.hdr_flip(a, b)[0], flip.ldr_flip):
            self.assertEqual(float(np.abs(measure(noise(1), noise(1))).max()), 0)

    def test_of_a_pair_is_the_packages_own_value(self):
        reference, picture = 5 * noise(1), 5 * noise(2)
        error, settings = flip.hdr_flip(reference, picture)
        _, mean, used = flip_evaluator.evaluate(reference, picture, "HDR")
        self.assertAlmostEqual(float(error.mean()), mean, places=6)
        self.assertEqual((settings.start_exposure, settings.exposures), (used["startExposure"], used["numExposures"]))
        shown = flip.ldr_flip(reference, picture, -2.0)
        _, mean, _ = flip_evaluator.evaluate(pictures.shown(reference, -2.0), pictures.shown(picture, -2.0), "LDR")
        self.assertAlmostEqual(float(shown.mean()), mean, places=6)
        self.assertGreater(mean, 0.05)

    def test_of_black_and_white_is_nearly_one(self):
        black, white = np.zeros((64, 64, 3), np.float32), np.ones((64, 64, 3), np.float32)
        self.assertGreater(float(flip.ldr_flip(black, white).min()), 0.9)

    def test_exposures_depend_on_the_reference_alone(self):
        _, one = flip.hdr_flip(noise(1), noise(2))
        _, other = flip.hdr_flip(noise(1), 100 * noise(3))
        self.assertEqual(one, other)
        self.assertEqual(float(flip.hdr_flip(noise(1), noise(2), one)[0].mean()),
                         float(flip.hdr_flip(noise(1), noise(2))[0].mean()))

    def test_of_a_reference_without_light_is_left_out(self):
        self.assertEqual(flip.hdr_flip(np.zeros((8, 8, 3)), noise(1)), (None, None))


class Pictures(unittest.TestCase):
    def test_shown_is_exposure_cut_and_srgb_curve(self):
        linear = np.array([-1, 0, 0.001, 0.21404114, 1, 9])
        np.testing.assert_allclose(pictures.shown(linear), [0, 0, 0.01292, 0.5, 1, 1], atol=1e-6)
        np.testing.assert_allclose(pictures.shown(4 * linear, -2), pictures.shown(linear), atol=1e-6)

    def test_png_data_comes_back(self):
        data = pictures.png_data(noise(1))
        image = np.asarray(Image.open(io.BytesIO(base64.b64decode(data.removeprefix("data:image/png;base64,")))))
        np.testing.assert_array_equal(image, np.rint(255 * pictures.shown(noise(1))).astype(np.uint8))


class Figures(unittest.TestCase):
    def test_mean_square_of_the_error_map_is_relmse(self):
        reference, picture = noise(1), noise(2)
        y, x = pictures.luminance(reference), pictures.luminance(picture)
        error = figures.signed_relative_error(reference, picture, 0.01)
        self.assertAlmostEqual(float((error**2).mean()), float(((x - y) ** 2 / (y**2 + 0.01)).mean()), places=12)

    def test_maps_hold_every_pixel_and_name_it_as_in_the_whole_picture(self):
        error = np.array([[0.5, -0.25, 0], [1, 99, -99]])
        figure = figures.error_maps(error, np.array([[0, 0.5, 1], [0, 0, 0]]), 1.0, (10, 20))
        np.testing.assert_array_equal(figure.data[0].z, [[500, -250, 0], [1000, 32767, -32767]])
        np.testing.assert_array_equal(figure.data[1].z, [[0, 128, 255], [0, 0, 0]])
        self.assertEqual((figure.data[0].x0, figure.data[0].y0), (10, 20))
        self.assertEqual(list(figure.layout.yaxis.range), [21.5, 19.5], "the first row is at the top")
        self.assertEqual(len(figures.error_maps(error, None, 1.0).data), 1, "without FLIP")

    def test_histogram_counts_all_pixels(self):
        figure = figures.error_histogram({"a": np.array([-9, -0.001, 0.001, 0.5, 9])}, 1.0)
        self.assertAlmostEqual(float(np.nansum(figure.data[0].y)), 100)
        self.assertAlmostEqual(figure.data[0].y[0], 20, msg="what lies beyond stands at the edge")

    def test_limits_are_round(self):
        for value, expected in [(0.013, 0.02), (0.05, 0.05), (0.051, 0.1), (1, 1), (730, 1000)]:
            self.assertAlmostEqual(figures.round_up(value), expected)
        self.assertEqual(figures.error_limit([np.zeros(5)], 95), 0.01)

    def test_lines_have_logarithmic_axes_and_error_bars(self):
        line = figures.Line("bamc", [1, 10], [0.2, 0.1], low=[0.15, 0.05], high=[0.3, 0.2])
        figure = figures.lines_log_log([line, figures.Line("path", [1, 10], [0.4, 0.2])], "seconds", "error")
        self.assertEqual((figure.layout.xaxis.type, figure.layout.yaxis.type), ("log", "log"))
        np.testing.assert_allclose(figure.data[0].error_y.arrayminus, [0.05, 0.05])
        np.testing.assert_allclose(figure.data[0].error_y.array, [0.1, 0.1])


class Tables(unittest.TestCase):
    def test_numbers_have_three_digits_and_their_unit(self):
        for value, unit, text in [(0.16, "%", "16.0 %"), (1.0, "%", "100 %"), (0.000012345, "", "1.23e-05"), (28.871, "dB", "28.87 dB"),
                                  (None, "%", "–"), (12345, "", "12345"), (float("nan"), "", "–")]:
            self.assertEqual(tables.number(value, unit), text)

    def test_best_is_marked_in_each_column_that_has_one(self):
        values = [[1, 5, 3, None], [2, 6, 3, 4], [1, 7, 3, 2]]
        self.assertEqual(tables.best_cells(values, [True, False, True, None]), {(0, 0), (2, 0), (2, 1)})

    def test_text_is_escaped(self):
        for text in (tables.table([("<b>", "&")], [["<i>"]]), tables.text_table(["<b>"], [("<i>", "<u>")]),
                     tables.definitions([("<b>", "<i>")])):
            self.assertNotRegex(text, "<[biu]>")


class PageFile(unittest.TestCase):
    def test_names_cannot_break_out(self):
        name = '</script><img src=x onerror=alert(1)>"'
        page = Page(name)
        page.picture(name, "data:,")
        page.slider(name, name, 4, 3)
        page.heading(name)
        tags = Tags(page.text())
        self.assertEqual(tags.counts["script"], 2)
        self.assertEqual(tags.counts["img"], 2, "those of the slider")
        self.assertEqual(embedded_pictures(page.text()), {name: "data:,"})


@unittest.skipUnless(PROGRAM, "no program was named")
class Program(unittest.TestCase):
    """myrialux compare -o, on two small renders."""

    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls._folder.name)
        cls.environment = {**os.environ, "MYRIALUX_PYTHON": sys.executable}
        scene = ROOT / "scenes" / "cornell-box" / "scene.xml"
        for name, options in {"truth": ["--method", "path", "--spp", "16"], "a": ["--seed", "1"], "b<&>": ["--seed", "2"]}.items():
            cls.run_program("render", scene, "-o", cls.folder / f"{name}.exr", "--size", "40x24", "--vpls", "500",
                            "--progress", "none", *options)
        cls.images = [cls.folder / "truth.exr", cls.folder / "a.exr", cls.folder / "b<&>.exr"]
        cls.page = cls.folder / "page.html"
        cls.json = json.loads(cls.run_program("compare", *cls.images, "-o", cls.page, "--json", "--exposure", "1"))
        cls.text = cls.page.read_text()
        cls.tags = Tags(cls.text)
        cls.n_figures = cls.text[cls.text.index("<main>"):].count("Plotly.newPlot(")

    @classmethod
    def tearDownClass(cls):
        cls._folder.cleanup()

    @classmethod
    def run_program(cls, *words):
        done = subprocess.run([PROGRAM, *map(str, words)], env=cls.environment, cwd=cls.folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def test_page_needs_nothing_but_itself(self):
        self.assertEqual(self.tags.fetched, [], "pictures come from the script, styles and scripts are inside")
        self.assertIn("default-src 'none'", self.text)
        for url in embedded_pictures(self.text).values():
            self.assertTrue(url.startswith("data:image/png;base64,"))
        self.assertEqual(self.text.count('"showSendToCloud": false'), self.n_figures, "no button uploads a figure")

    def test_page_shows_every_picture(self):
        found = embedded_pictures(self.text)
        self.assertEqual(set(found), {"reference", "a", "b<&>"})
        for url in found.values():
            self.assertEqual(Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))).size, (40, 24))
        self.assertEqual(self.text.count('<figure class="slider"'), 2)
        self.assertEqual(self.n_figures, 5, "maps and histogram of each, and one histogram of both")

    def test_page_explains_every_measure_and_names_the_parameters(self):
        help_text = " ".join(self.run_program("compare", "--help").split())
        for term in ("relative RMSE", "relMSE", "PSNR", "bias", "MAE"):
            self.assertIn(term, self.tags.seen)
        for sentence in re.findall(r"Mean absolute difference[^.]*\.|Share of the pixels[^.]*\.", help_text):
            self.assertIn(sentence, self.tags.seen)
        for word in ("method", "bamc", "path", "seed", "vpls", "b<&>"):
            self.assertIn(word, self.tags.seen)

    def test_flip_in_json_is_the_packages_own(self):
        import OpenEXR

        def read(path):
            channels = OpenEXR.File(str(path), separate_channels=True).channels()
            return np.stack([channels[c].pixels for c in "RGB"], axis=-1).astype(np.float32)

        reference = read(self.images[0])
        for image, path in zip(self.json["images"], self.images[1:]):
            _, hdr, used = flip_evaluator.evaluate(reference, read(path), "HDR")
            self.assertAlmostEqual(image["flip"], hdr, places=5)
            self.assertEqual(self.json["flip_settings"]["exposures"], used["numExposures"])
            _, ldr, _ = flip_evaluator.evaluate(pictures.shown(reference, 1), pictures.shown(read(path), 1), "LDR")
            self.assertAlmostEqual(image["flip_shown"], ldr, places=5)

    def test_flip_of_the_reference_itself_is_zero(self):
        found = json.loads(self.run_program("compare", self.images[0], self.images[0], "--json", "--flip"))
        self.assertEqual((found["images"][0]["flip"], found["images"][0]["flip_shown"]), (0, 0))

    def test_same_command_writes_the_same_page(self):
        again = self.folder / "again.html"
        self.run_program("compare", *self.images, "-o", again, "--exposure", "1")
        self.assertEqual(again.read_text(), self.text)

    def test_region_is_shown_alone(self):
        part = self.folder / "part.html"
        self.run_program("compare", *self.images[:2], "-o", part, "--region", "8,4,16,12")
        url = embedded_pictures(part.read_text())["a"]
        self.assertEqual(Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))).size, (16, 12))
        self.assertIn("region 16 x 12 at 8,4", part.read_text())

    def test_black_pictures_make_a_page(self):
        Image.new("RGB", (8, 8)).save(self.folder / "black.png")
        Image.new("RGB", (8, 8), (9, 9, 9)).save(self.folder / "dark.png")
        page = self.folder / "black.html"
        self.run_program("compare", self.folder / "black.png", self.folder / "dark.png", "-o", page)
        self.assertEqual(page.read_text().count('<figure class="slider"'), 1)

    def test_browser_draws_it_without_a_network(self):
        browser = shutil.which("chromium") or shutil.which("google-chrome")
        if not browser:
            self.skipTest("no chromium to look at the page with")
        done = subprocess.run(
            [browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=8000", "--dump-dom",
             "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={self.folder / 'browser'}", self.page.as_uri()],
            capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.count('class="hm"'), 4, "error map and FLIP of two pictures")
        self.assertEqual(len(re.findall(r'<img [^>]*src="data:image/png', done.stdout)), 4)


class Missing(unittest.TestCase):
    def test_packages_are_named(self):
        done = subprocess.run([sys.executable, "-S", "-m", "myrialux.compare", "."], cwd=ROOT / "python", text=True,
                              capture_output=True, env={**os.environ, "PYTHONPATH": ""})
        self.assertEqual((done.returncode, done.stdout.strip()), (69, ", ".join(compare.PACKAGES.values())))


class Bench(unittest.TestCase):
    def test_page_of_a_small_bench_is_whole_and_fetches_nothing(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            scene = ROOT / "scenes/cornell-box/scene.xml"
            subprocess.run([PROGRAM, "bench", scene, "-o", folder, "--size", "32x32", "--spp", "1", "--vpls", "400",
                            "--clusters", "40", "--budgets", "0.5,1", "--repeats", "1", "--progress", "none"],
                           check=True, env={**os.environ, "MYRIALUX_PYTHON": sys.executable})
            tags = Tags((folder / "index.html").read_text())
            self.assertTrue(all(f.startswith("data:") for f in tags.fetched), tags.fetched[:3])
            self.assertIn("slice-lightcuts", tags.seen)
            self.assertIn("cornell-box", tags.seen)
            results = json.loads((folder / "results.json").read_text())["results"]
            flips = {(r["method"], r["budget"]): r["flip"] for r in results}
            self.assertIsNone(flips["brute-force", 1])
            self.assertGreater(flips["slice-lightcuts", 0.5], flips["slice-lightcuts", 1])


if __name__ == "__main__":
    unittest.main()
