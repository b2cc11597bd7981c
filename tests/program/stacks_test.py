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
  { axes = "xy", kernel = "gauss-energy", sigma = 1.9 },
  { axes = "xy%(axis)s", kernel = "gauss-energy", sigma = 1.9, box = "%(axis)s", box_size = 4 },
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


def power_below(patterns, limit=0.05):
    """Mean power of black and white patterns over frequencies 0 < |f| < limit; that of white noise is 1."""
    f = numpy.fft.fftfreq(SIZE)
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
        mask = self.mask(CONFIG % {"axis": "t", "frames": FRAMES})
        plane = [self.mask(PLANE, "--set", f"texture.seed={seed}") for seed in range(1, 5)]
        for level in (0.1, 0.2, 0.4):
            parts = mask < level / 4
            runs = [[parts[(first + k) % FRAMES] for k in range(4)] for first in range(FRAMES)]
            unions = [numpy.any(run, axis=0) for run in runs]
            overlap = max(numpy.sum(run, axis=0).max() for run in runs)
            self.assertEqual(overlap, 1, f"level {level}: a pixel is on in two frames of four")
            flat = power_below([values < level for values in plane])
            # Of all 4 of 8 frames at once: 1.4 to 2 times what one plane has (white noise: 1).
            self.assertLess(power_below(unions), 2.5 * flat, f"level {level}, plane {flat}")
            self.assertLess(power_below(parts), 0.2)

    def test_inks_keep_out_of_each_others_way(self):
        mask = self.mask(CONFIG % {"axis": "c", "frames": 4})
        for level in (0.05, 0.1, 0.2):
            dots = mask < level
            self.assertEqual(dots.sum(axis=0).max(), 1)
            self.assertLess(power_below([dots.any(axis=0)]), 0.02)
            self.assertLess(power_below(dots), 0.2)

    def test_same_bytes_on_ranks(self):
        text = CONFIG.replace("64", "24") % {"axis": "t", "frames": 6}
        one = self.mask(text)
        self.assertTrue(numpy.array_equal(one, self.mask(text, ranks=3)))


if __name__ == "__main__":
    main()
