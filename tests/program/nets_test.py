"""Nets: every elementary interval of every slice and of all slices holds its share, before and after optimisation."""

import numpy

from support import PLAIN_CPU, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 16, y = 8, t = 4, z = 2 }
samples = "sobol-owen"
seed    = 3
[filter]
groups  = [ { axes = "xy", kernel = "gauss", sigma = 0.9 }, { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 } ]
[optimizer]
stop = { iterations = 30 }
"""


def is_net(points):
    """Whether the points, 2^m of any number of columns, are a (0, m, s)-net: by counting, from the definition."""
    m = len(points).bit_length() - 1
    if points.shape[1] == 1:
        return len(set(numpy.floor(points[:, 0].astype(float) * 2**m))) == 2**m
    for a in range(m + 1):
        boxes = numpy.floor(points.astype(float) * (2**a, 2**(m - a)))
        if len({tuple(box) for box in boxes}) != 2**m:
            return False
    return True


class Nets(ProgramTest):
    def generate(self, text, output, *arguments, **options):
        self.run_program("generate", self.write("run.toml", text), "-o", output, "--overwrite", "--progress", "none", *arguments,
                         **options)
        import h5py

        with h5py.File(self.folder / output) as file:
            samples = file["samples"][...]
        return samples.reshape(8, 128, -1)

    def check(self, slices):
        for points in slices:
            self.assertTrue(is_net(points))
        self.assertTrue(is_net(slices.reshape(1024, -1)))

    def test_kept_by_swaps(self):
        few = self.generate(CONFIG.replace("30", "1"), "few.h5")
        many = self.generate(CONFIG, "many.h5")
        self.check(few)
        self.check(many)
        self.assertFalse(numpy.array_equal(few, many))
        for before, after in zip(few, many):
            self.assertEqual(sorted(map(tuple, before)), sorted(map(tuple, after)))
        self.assertFalse(is_net(self.generate(CONFIG.replace("sobol-owen", "vector2"), "plain.h5")[0]))

    def test_scalars_are_constructed(self):
        text = CONFIG.replace('"sobol-owen"', '{ space = "sobol-owen", channels = 1 }').replace("stop = { iterations = 30 }", "")
        slices = self.generate(text, "scalars.h5")
        self.check(slices)
        self.assertIn("construct", self.run_program("info", "scalars.h5").stdout)

    def test_same_bytes(self):
        one = self.generate(CONFIG, "one.h5", "--threads", 1)
        for options in ({"ranks": 3}, {"environment": PLAIN_CPU}):
            self.assertTrue(numpy.array_equal(self.generate(CONFIG, "other.h5", **options), one))

    def test_other_sizes_are_refused(self):
        done = self.run_program("plan", self.write("odd.toml", CONFIG.replace("x = 16", "x = 20").replace("t = 4", "t = 3")),
                                expect=2)
        self.assertIn("texture.size.x = 20: must be a power of two", done.stderr)
        self.assertIn("the nearest are 16 and 32", done.stderr)
        self.assertIn("texture.size.t = 3", done.stderr)


if __name__ == "__main__":
    main()
