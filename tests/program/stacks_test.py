"""Masks whose frames (or inks) are blue each and together: what a box inside a group of the energy makes."""

import numpy

from support import ProgramTest, main

SIZE, FRAMES = 64, 8
CONFIG = """
[texture]
size    = { x = 64, y = 64, %(axis)s = %(frames)d }
[filter]
combine = "sum"
groups  = [
  { axes = "xy", kernel = "gauss-energy", sigma = %(sigma)g },
  { axes = "xy%(axis)s", kernel = "gauss-energy", sigma = %(union)g, box = "%(axis)s", box_size = 4 },
]
[optimizer]
method   = "void-and-cluster"
equalize = "slice"
"""
PLANE = """
[texture]
size    = { x = 64, y = 64 }
[filter]
groups  = [ { axes = "xy", kernel = "gauss-energy", sigma = 1.9 } ]
[optimizer]
method  = "void-and-cluster"
"""
TILES = """
[texture]
size    = { x = 64, y = 64, k = 9 }
[filter]
groups  = [ { axes = "xyk", kernel = "gauss-energy", sigma = 1.9, tiles = "k" } ]
[optimizer]
method   = "void-and-cluster"
equalize = "slice"
"""


def power_below(patterns, limit=0.05):
    """Mean power of black and white patterns over frequencies 0 < |f| < limit; that of white noise is 1."""
    f = numpy.fft.fftfreq(len(patterns[0]))
    low = numpy.hypot(*numpy.meshgrid(f, f)) < limit
    low[0, 0] = False
    powers = []
    for pattern in patterns:
        centred = pattern - pattern.mean()
        powers.append((numpy.abs(numpy.fft.fft2(centred))**2 / centred.size / centred.var())[low].mean())
    return numpy.mean(powers)


class Stacks(ProgramTest):
    def mask(self, text, *arguments, **options):
        self.run_program("generate", self.write("run.toml", text), "-o", "run.h5", "--overwrite", "--progress", "none", *arguments,
                         **options)
        import h5py

        with h5py.File(self.folder / "run.h5") as file:
            return file["samples"][..., 0]

    def test_frames_in_a_row_are_disjoint_and_their_union_is_blue(self):
        mask = self.mask(CONFIG % {"axis": "t", "frames": FRAMES, "sigma": 3.8, "union": 2.0})
        plane = [self.mask(PLANE, "--set", f"texture.seed={seed}") for seed in range(1, 5)]
        for level in (0.1, 0.2, 0.4):
            parts = mask < level / 4
            runs = [[parts[(first + k) % FRAMES] for k in range(4)] for first in range(FRAMES)]
            unions = [numpy.any(run, axis=0) for run in runs]
            overlap = max(numpy.sum(run, axis=0).max() for run in runs)
            self.assertEqual(overlap, 1, f"level {level}: a pixel is on in two frames of four")
            flat = power_below([values < level for values in plane])
            # Where both groups have the same width, twice what one plane has (white noise: 1).
            self.assertLess(power_below(unions), 1.4 * flat, f"level {level}, plane {flat}")
            self.assertLess(power_below(parts), 0.2)

    def test_inks_keep_out_of_each_others_way(self):
        mask = self.mask(CONFIG % {"axis": "c", "frames": 4, "sigma": 1.9, "union": 1.9})
        for level in (0.05, 0.1, 0.2):
            dots = mask < level
            self.assertEqual(dots.sum(axis=0).max(), 1)
            self.assertLess(power_below([dots.any(axis=0)]), 0.02)
            self.assertLess(power_below(dots), 0.2)

    def test_same_bytes_on_ranks(self):
        text = CONFIG.replace("64", "24") % {"axis": "t", "frames": 6, "sigma": 1.9, "union": 1.9}
        one = self.mask(text)
        self.assertTrue(numpy.array_equal(one, self.mask(text, ranks=3)))

    def test_tiles_fit_one_another_at_every_edge(self):
        tiles = self.mask(TILES)
        apart = self.mask(TILES.replace('"xyk"', '"xy"').replace(', tiles = "k"', ""))
        self.assertTrue(all(numpy.array_equal(numpy.sort(tile, axis=None), numpy.sort(tiles[0], axis=None)) for tile in tiles))
        plane = self.mask(PLANE.replace("64", "256"))
        rng = numpy.random.default_rng(3)
        choices = [rng.integers(0, len(tiles), (4, 4)) for _ in range(4)]
        power = {name: power_below([numpy.block([[mask[k] for k in row] for row in choice]) for choice in choices])
                 for name, mask in (("fitting", tiles), ("apart", apart))}
        # Of the values themselves, of which a plane has next to nothing at low frequencies.
        self.assertLess(power["fitting"], 0.05 * power["apart"])
        for level in (0.1, 0.5):
            mosaics = [numpy.block([[tiles[k] < level for k in row] for row in choice]) for choice in choices]
            self.assertLess(power_below(mosaics), 1.3 * power_below([plane < level]), f"level {level}")
        self.assertTrue(numpy.array_equal(tiles, self.mask(TILES, ranks=3)))

    def test_a_tail_keeps_the_first_points_apart(self):
        def closest(mask, count):
            y, x = numpy.unravel_index(numpy.argsort(mask, axis=None)[:count], mask.shape)
            d = [numpy.abs(a[:, None] - a[None]) for a in (x, y)]
            d = numpy.hypot(*[numpy.minimum(a, SIZE - a) for a in d]) + SIZE * numpy.eye(count)
            return d.min() / (SIZE * numpy.sqrt(2 / (numpy.sqrt(3) * count)))  # of the densest packing

        with_tail = PLANE.replace("sigma = 1.9", "sigma = 1.9, tail = 1e-3")
        means = []
        for text in (PLANE, with_tail):
            masks = [self.mask(text, "--set", f"texture.seed={seed}") for seed in (1, 2, 3)]
            means.append(numpy.mean([closest(mask, count) for mask in masks for count in (4, 8, 16)]))
        self.assertLess(means[0], 0.65)
        self.assertGreater(means[1], 0.75)


if __name__ == "__main__":
    main()
