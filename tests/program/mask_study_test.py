"""Masks through the whole program: as blue as numpy finds them, and their point sets as h5py and PIL read them."""

import json
import pathlib
import sys

import support

try:
    import h5py
    import numpy
    from PIL import Image
except ImportError as missing:
    print(f"skipped: {missing}")
    raise SystemExit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "bench"))
import mask_quality  # noqa: E402

CONFIG = """
[texture]
size = { %s }
[filter]
combine = "sum"
groups = [ %s ]
[optimizer]
method = "void-and-cluster"
"""
PROGRESS = ("--progress", "none")


class MaskTest(support.ProgramTest):
    def generate(self, name, size, groups, *arguments, expect=0):
        listed = ", ".join(f'{{ axes = "{axes}", kernel = "gauss-energy", sigma = 1.9 }}' for axes in groups)
        config = self.write(f"{name}.toml", CONFIG % (size, listed))
        self.run_program("generate", config, "-o", f"{name}.h5", *PROGRESS, *arguments, expect=expect)
        return self.folder / f"{name}.h5"

    def order(self, run_file):
        with h5py.File(run_file) as file:
            return file["order"][...]


class QualityTest(MaskTest):
    def assert_same(self, own, independent):
        self.assertEqual(own["first_bins"].keys(), independent["first_bins"].keys())
        for axis, bins in independent["first_bins"].items():
            numpy.testing.assert_allclose(own["first_bins"][axis], bins, rtol=1e-6)
        self.assertEqual(own["low_frequency_power"].keys(), independent["low_frequency_power"].keys())
        for group, power in independent["low_frequency_power"].items():
            if power is None:
                self.assertIsNone(own["low_frequency_power"][group])
            else:
                self.assertAlmostEqual(own["low_frequency_power"][group] / power, 1, delta=1e-6)

    def test_masks_are_as_blue_as_they_must_be(self):
        for size, groups, bounds, bins in [("x = 256, y = 256", ["xy"], {"xy": 3e-5}, []),
                                           ("x = 64, y = 64, t = 16", ["xy", "t"], {"xy": 4.5e-4}, []),
                                           ("x = 128, y = 128, t = 32", ["xy", "t"], {"xy": 4.5e-4}, [0.017, 0.026, 0.05])]:
            with self.subTest(size):
                run_file = self.generate("mask", size, groups, "--overwrite")
                found = mask_quality.quality(mask_quality.load(run_file))
                own = json.loads(self.run_program("score", run_file, "--json").stdout)
                self.assert_same(own, found)
                for group, bound in bounds.items():
                    self.assertLess(found["low_frequency_power"][group], bound)
                for power, bound in zip(found["first_bins"].get("t", []), bins):
                    self.assertLess(power, bound)
                # The exact order and its samples in float tell the same.
                exact = mask_quality.quality(mask_quality.load(run_file, order=True))
                self.assertAlmostEqual(exact["low_frequency_power"]["xy"] / found["low_frequency_power"]["xy"], 1, delta=1e-3)

    def test_agrees_with_numpy_for_groups_of_slice_axes_and_for_exported_arrays(self):
        run_file = self.generate("mask", "x = 23, y = 26, t = 21, z = 22", ["xy", "tz"])
        self.run_program("export", run_file, "-o", "mask.npy")
        found = mask_quality.quality(mask_quality.load(self.folder / "mask.npy"), ["tz"])
        self.assertIsNotNone(found["low_frequency_power"]["tz"])
        self.assert_same(json.loads(self.run_program("score", run_file, "--json").stdout), found)

    def test_analyze_tells_what_score_tells(self):
        run_file = self.generate("mask", "x = 40, y = 40, t = 24", ["xy", "t"])
        own = json.loads(self.run_program("score", run_file, "--json").stdout)
        text = self.run_program("analyze", run_file, "-o", "report").stdout
        self.assertIn(f"xy {own['low_frequency_power']['xy']:.3g}", text)
        self.assertIn("along t: " + ", ".join(f"{power:#.3g}" for power in own["first_bins"]["t"]), text)
        names = {path.name for path in (self.folder / "report").iterdir()}
        self.assertLessEqual({"points_0.02.png", "points_0.5.png", "spectra.svg", "spectrum_t.csv"}, names)
        with Image.open(self.folder / "report" / "points_0.1.png") as image:
            factor = image.size[0] // 40
            self.assertEqual(image.size, (40 * factor, 40 * factor))
            shown = numpy.asarray(image)[::factor, ::factor, 0]
        numpy.testing.assert_array_equal(shown == 0, self.order(run_file)[0] < 3840)


def plane_power(values, axes):
    """Power over two axes of an array, of which white noise has 1 on average: the mean over all positions of the others."""
    values = numpy.moveaxis(values.astype(float), axes, (0, 1))
    values = (values - values.mean()) / values.std()
    power = numpy.abs(numpy.fft.fft2(values, axes=(0, 1))) ** 2 / (values.shape[0] * values.shape[1])
    return power.reshape(*power.shape[:2], -1).mean(axis=2)


def frequencies(shape):
    """Cycles a pixel along each of two axes."""
    return numpy.meshgrid(*(numpy.abs(numpy.fft.fftfreq(n)) for n in shape), indexing="ij")


def distance_of_points(points):
    """The mean distance to the nearest point, around the edges."""
    places = numpy.nonzero(points)
    apart = [numpy.abs(place[:, None] - place) for place in places]
    apart = numpy.hypot(*(numpy.minimum(one, size - one) for one, size in zip(apart, points.shape)))
    numpy.fill_diagonal(apart, numpy.inf)
    return apart.min(axis=1).mean()


class SupplementTest(MaskTest):
    """Figures of the supplement of STBN that show textures and no pictures, as numbers."""

    def assert_blue_in_plane(self, power, bound):
        a, b = frequencies(power.shape)
        radius = numpy.hypot(a, b)
        low = power[(radius > 0) & (radius < 0.1)].mean()
        self.assertLess(low, bound)
        self.assertGreater(power[radius > 0.3].mean(), 1)

    def assert_nearly_white(self, power):
        """Beside the axes: that each axis is blue leaves the corner where both frequencies are low a little darker."""
        a, b = frequencies(power.shape)
        self.assertAlmostEqual(power[(a > 0) & (b > 0)].mean(), 1, delta=0.2)
        self.assertGreater(power[(a > 0) & (b > 0) & (a < 0.2) & (b < 0.2)].mean(), 0.1)

    def test_figure_10_values_are_uncorrelated_but_for_near_ones(self):
        run_file = self.generate("mask", "x = 64, y = 64, t = 32", ["xy"], "--set", "optimizer.equalize=slice")
        self.run_program("analyze", run_file, "-o", "report")
        rings = numpy.genfromtxt(self.folder / "report/autocorrelation.csv", delimiter=",", names=True)
        with h5py.File(run_file) as file:
            slices = file["samples"][..., 0]
        power = numpy.mean([numpy.abs(numpy.fft.fft2(one - one.mean())) ** 2 for one in slices], axis=0)
        correlation = numpy.fft.ifft2(power).real
        correlation /= correlation[0, 0]
        y, x = (numpy.minimum(n, 64 - n) for n in numpy.indices((64, 64)))
        distance = numpy.rint(numpy.hypot(x, y))
        for ring in rings:
            self.assertAlmostEqual(ring["mean"], correlation[distance == ring["distance"]].mean(), delta=1e-5)
        # Neighbours differ, those behind them are alike, and that decays to what chance leaves of so many values.
        self.assertLess(rings["mean"][0], -0.1)
        self.assertGreater(rings["mean"][2], 0.01)
        chance = 1 / numpy.sqrt(slices.size)
        self.assertLess(numpy.abs(rings["mean"][12:]).max(), 3 * chance)
        self.assertLess(rings["largest_magnitude"][12:].max(), 6 * chance)

    def test_figure_11_each_group_of_axes_is_blue_and_no_other_plane(self):
        size = "x = 32, y = 32, z = 16, w = 16"
        for groups in (["xy", "z", "w"], ["xy", "zw"]):
            with self.subTest(groups):
                run_file = self.generate("mask", size, groups, "--overwrite")
                with h5py.File(run_file) as file:
                    values = file["samples"][..., 0]  # [w, z, y, x]
                self.assert_blue_in_plane(plane_power(values, (2, 3)), 0.05)
                for plane in ((0, 2), (0, 3), (1, 2), (1, 3)):
                    self.assert_nearly_white(plane_power(values, plane))
                along_zw = plane_power(values, (0, 1))
                if "zw" in groups:
                    self.assert_blue_in_plane(along_zw, 0.2)
                else:
                    self.assert_nearly_white(along_zw)
                    for axis in (0, 1):
                        line = numpy.abs(numpy.fft.fft(values - values.mean(), axis=axis)) ** 2
                        line = line.mean(axis=tuple(i for i in range(4) if i != axis)) / (16 * values.var())
                        self.assertLess(line[1], 0.15)
                        self.assertGreater(line[8], 1)

    def test_figures_13_and_14_point_sets_of_any_density_are_blue_over_space_and_over_time(self):
        run_file = self.generate("mask", "x = 64, y = 64, t = 32", ["xy", "t"])
        order = self.order(run_file)
        for density in (0.1, 0.25, 0.5):
            points = order < density * order.size
            counts = points.sum(axis=(1, 2))
            self.assertLessEqual(numpy.abs(counts - density * 4096).max(), 0.01 * 4096)  # each slice has its part
            self.assert_blue_in_plane(plane_power(points, (1, 2)), 0.1)
            self.assert_nearly_white(plane_power(points, (0, 1)))
            line = numpy.abs(numpy.fft.fft(points - points.mean(), axis=0)) ** 2
            line = line.mean(axis=(1, 2)) / (32 * points.var())
            self.assertLess(line[1], 0.4)
            self.assertGreater(line[16], 1)
            # Points keep apart from each other, as far as the pixels of so many let them.
            further = {0.1: 1.35, 0.25: 1.03, 0.5: 0}[density]
            chosen = numpy.random.default_rng(1).permutation(4096).reshape(64, 64) < density * 4096
            self.assertGreater(distance_of_points(points[0]), further * distance_of_points(chosen))


class PointsTest(MaskTest):
    def test_points_are_the_first_of_the_sequence(self):
        run_file = self.generate("mask", "x = 24, y = 20, t = 8", ["xy", "t"])
        order = self.order(run_file)
        done = self.run_program("export", run_file, "-o", "points/", "--threshold", "0.29", "--format", "npy")
        count = 3840 * 29 // 100
        self.assertIn(f"{count} points", done.stdout)
        expected = numpy.argsort(order, axis=None)[:count]
        t, y, x = numpy.unravel_index(expected, order.shape)
        rows = numpy.stack([x, y, t, numpy.arange(count)], axis=1)
        table = numpy.genfromtxt(self.folder / "points/points_below0.29.csv", delimiter=",", names=True, dtype=int)
        self.assertEqual(table.dtype.names, ("x", "y", "t", "place"))
        numpy.testing.assert_array_equal(numpy.stack([table[name] for name in table.dtype.names], axis=1), rows)
        array = numpy.load(self.folder / "points/points_below0.29.npy")
        self.assertEqual(array.dtype, numpy.int64)
        numpy.testing.assert_array_equal(array, rows)
        mask = numpy.load(self.folder / "points/mask_below0.29.npy")
        numpy.testing.assert_array_equal(mask[..., 0], order < count)

    def test_images_are_black_and_white_and_every_density_is_progressive(self):
        run_file = self.generate("mask", "x = 24, y = 20, t = 8", ["xy", "t"])
        order = self.order(run_file)
        before = numpy.zeros_like(order, dtype=bool)
        for threshold, count in [("0.05", 192), ("0.5", 1920), ("1", 3840)]:
            self.run_program("export", run_file, "-o", "images/", "--threshold", threshold, "--naming", "nvidia", "--overwrite")
            for s in range(8):
                with Image.open(self.folder / "images" / f"stbn_scalar_2Dx1Dx1D_24x20x8x1_below{threshold}_{s}.png") as image:
                    self.assertEqual(image.mode, "L")
                    numpy.testing.assert_array_equal(numpy.asarray(image), numpy.where(order[s] < count, 255, 0))
            now = order < count
            self.assertTrue((now | ~before).all())
            before = now

    def test_refuses_what_holds_no_sequence_and_leaves_all_as_it_was(self):
        half = self.generate("half", "x = 64, y = 64, t = 8", ["xy", "t"], "--time-limit", "0.000001s", expect=75)
        plain = self.write("plain.toml", '[texture]\nsize = { x = 9, y = 7 }\n[filter]\ngroups = [ { axes = "xy", kernel = '
                           '"box", size = 3 } ]\n[optimizer]\nstop = { iterations = 1 }\n')
        self.run_program("generate", plain, "-o", "plain.h5", *PROGRESS)
        whole = self.generate("whole", "x = 9, y = 7", ["xy"])
        before = sorted(self.folder.iterdir())
        for file, threshold, words in [(half, "0.1", "not finished"), ("plain.h5", "0.1", "holds no /order"),
                                       (whole, "0.01", "no point of 63 pixels"), (whole, "1.5", "at most 1"),
                                       (whole, "0", "above 0"), (whole, "ten", "--threshold ten")]:
            self.assertIn(words, self.run_program("export", file, "-o", "out/", "--threshold", threshold, expect=2).stderr)
        for command in (("score", half), ("analyze", half, "-o", "out")):
            self.assertIn("not finished", self.run_program(*command, expect=2).stderr)
        self.assertEqual(sorted(self.folder.iterdir()), before)


if __name__ == "__main__":
    support.main()
