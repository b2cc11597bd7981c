"""How far apart the first points of an order are, and what its mask has at low frequencies, with and without a tail.
Usage: first_points.py PATH/TO/noiseloom"""

import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy

SIZE = 128
CONFIG = """
[texture]
size   = { x = 128, y = 128 }
[filter]
groups = [ { axes = "xy", kernel = "gauss-energy", sigma = 1.9%s } ]
[optimizer]
method = "void-and-cluster"
"""


def closest(mask, count):
    """The distance of the closest two of the first points, over that of the densest packing of as many on the torus."""
    y, x = numpy.unravel_index(numpy.argsort(mask, axis=None)[:count], mask.shape)
    d = [numpy.abs(a[:, None] - a[None]) for a in (x, y)]
    d = numpy.hypot(*[numpy.minimum(a, SIZE - a) for a in d]) + SIZE * numpy.eye(count)
    return d.min() / (SIZE * numpy.sqrt(2 / (numpy.sqrt(3) * count)))


def power_below(mask, limit=0.05):
    f = numpy.fft.fftfreq(SIZE)
    low = numpy.hypot(*numpy.meshgrid(f, f)) < limit
    low[0, 0] = False
    return (numpy.abs(numpy.fft.fft2(mask - mask.mean()))**2 / mask.size / mask.var())[low].mean()


with tempfile.TemporaryDirectory() as folder:
    for keys in ("", ", tail = 1e-2", ", tail = 1e-3", ", tail = 1e-4", ", tail = 1e-2, tail_power = 2"):
        config, run = pathlib.Path(folder, "run.toml"), pathlib.Path(folder, "run.h5")
        config.write_text(CONFIG % keys)
        masks = []
        for seed in (1, 2, 3):
            subprocess.run([sys.argv[1], "generate", config, "-o", run, "--overwrite", "--quiet", "--set", f"texture.seed={seed}"],
                           check=True)
            with h5py.File(run) as file:
                masks.append(file["samples"][...].reshape(SIZE, SIZE))
        distances = "  ".join(f"{n}: {numpy.mean([closest(m, n) for m in masks]):.2f}" for n in (4, 16, 64, 256, 1024))
        print(f"{keys[2:] or 'no tail':32} {distances}  power below 0.05: {numpy.mean([power_below(m) for m in masks]):.2e}")
