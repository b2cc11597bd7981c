#!/usr/bin/env python3
"""What textures with an invariant cost and hold: tests/bench/invariants.py FOLDER [NAME...]

Of the programs on PATH, with configs/ beside it: strata over time, nets, stacks, inks, tiles, densities. FOLDER keeps what is made.
Powers are means over frequencies 0 < |f| < 0.05 cycles a pixel of black and white patterns, white noise being 1.
"""

import json
import pathlib
import subprocess
import sys

import h5py
import numpy

CONFIGS = pathlib.Path(__file__).resolve().parents[2] / "configs"


def made(folder, name, config, *changes):
    path = folder / f"{name}.h5"
    words = [word for change in changes for word in ("--set", change)]
    subprocess.run(["noiseloom", "generate", str(CONFIGS / config), "-o", str(path), "--resume", "--progress", "none", "--quiet", *words], check=True)
    return path


def score(path):
    return json.loads(subprocess.run(["noiseloom", "score", str(path), "--json"], check=True, capture_output=True).stdout)["relative_error"]


def samples(path):
    with h5py.File(path) as file:
        return file["samples"][...]


def power_below(patterns, limits=(0, 0.05)):
    f = numpy.fft.fftfreq(len(patterns[0]))
    radius = numpy.hypot(*numpy.meshgrid(f, f))
    band = (radius > limits[0]) & (radius < limits[1])
    centred = [pattern - pattern.mean() for pattern in patterns]
    return numpy.mean([(numpy.abs(numpy.fft.fft2(c))**2 / c.size / c.var())[band].mean() for c in centred])


def strata(folder):
    """R of strata over time beside strata of slices alone, and the error of the mean of all T frames."""
    cases = (("config", "stratified-time.toml", ()), ("vectors", "stratified-time.toml", ("texture.samples=vector2", "texture.size={x=64,y=64,t=16}", "optimizer.stop={iterations=400}")),
             ("short", "stratified-time.toml", ("texture.size={x=64,y=64,t=16}",)))
    for name, config, changes in cases:
        both = made(folder, f"strata-{name}", config, *changes)
        alone = made(folder, f"slices-{name}", config, *changes, "texture.stratify=slice")
        r, without = score(both), score(alone)
        values = samples(both)
        frames = len(values)
        error = values.mean(axis=0).std(axis=(0, 1)).mean()
        white = (1 / 12 / frames)**0.5
        print(f"strata, {name}: R {r:.4f} for {without:.4f} ({100 * (r / without - 1):+.1f} %); mean of {frames} frames: {error / white:.4f} of white noise")


def nets(folder):
    for channels in (2, 3, 4):
        changes = ("texture.size={x=64,y=64,t=8}", "optimizer.stop={iterations=400}")
        net = score(made(folder, f"nets-{channels}", "nets-vector2.toml", *changes, f'texture.samples={{space="sobol-owen",channels={channels}}}'))
        plain = score(made(folder, f"plain-{channels}", "nets-vector2.toml", *changes, f"texture.samples=vector{channels}"))
        print(f"nets, {channels} channels: R {net:.4f}, plain vectors {plain:.4f} ({100 * (net / plain - 1):+.1f} %)")


def masks(folder):
    order = ("optimizer.method=void-and-cluster",)
    planes = [samples(made(folder, f"plane-{seed}", "stack-4.toml", "texture.size={x=128,y=128}", f"texture.seed={seed}",
                           'filter.groups=[{axes="xy",kernel="gauss-energy",sigma=1.9}]', *order))[..., 0] for seed in (1, 2, 3, 4)]
    stack = samples(made(folder, "stack", "stack-4.toml"))[..., 0]
    inks = [samples(made(folder, f"inks-{seed}", "inks-4.toml", f"texture.seed={seed}"))[..., 0] for seed in (1, 2, 3, 4)]
    for level in (0.1, 0.2, 0.4):
        flat = power_below([plane < level for plane in planes])
        frames = len(stack)
        unions = [numpy.any([stack[(first + k) % frames] < level / 4 for k in range(4)], axis=0) for first in range(frames)]
        of_inks = power_below([(mask < level / 4).any(axis=0) for mask in inks])
        of_each = power_below([ink < level / 4 for mask in inks for ink in mask]) / power_below([plane < level / 4 for plane in planes])
        print(f"level {level}: union of four frames {power_below(unions) / flat:.2f} of a plane's {flat:.2e}, of four inks {of_inks / flat:.2f}; "
              f"each ink {of_each:.2f} of a plane at its level")
    tiles = samples(made(folder, "tiles", "tiles-16.toml"))[..., 0]
    plane = samples(made(folder, "plane-512", "stack-4.toml", "texture.size={x=512,y=512}",
                         'filter.groups=[{axes="xy",kernel="gauss-energy",sigma=1.9}]', *order))[..., 0]
    rng = numpy.random.default_rng(3)
    mosaics = [numpy.block([[tiles[k] for k in row] for row in rng.integers(0, len(tiles), (4, 4))]) for _ in range(8)]
    edges = numpy.linspace(0, 0.7, 15)
    for level in (0.1, 0.5):
        ratios = [power_below([m < level for m in mosaics], band) / power_below([plane < level], band) for band in zip(edges, edges[1:])]
        print(f"tiles, level {level}: {min(ratios):.2f} to {max(ratios):.2f} of one plane in 14 bands to 0.7 c/px")


def densities(folder):
    spaces = ("vector2", "disk", "hexagon", "gauss2", "ggx")
    errors = {}
    for space in spaces:
        path = made(folder, f"density-{space}", "quick.toml", "texture.size={x=64,y=64}", f"texture.samples={space}",
                    'filter.groups=[{axes="xy",kernel="gauss",sigma=1.0}]', "optimizer.stop={iterations=1000}")
        errors[space] = score(path)
    for space in spaces:
        print(f"density, {space}: 1 - R {1 - errors[space]:.3f}, {100 * ((1 - errors[space]) / (1 - errors['vector2']) - 1):+.1f} % of the square")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    parts = {"strata": strata, "nets": nets, "masks": masks, "densities": densities}
    for name in sys.argv[2:] or parts:
        parts[name](folder)


if __name__ == "__main__":
    main()
