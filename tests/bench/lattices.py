#!/usr/bin/python3
"""R of regular patterns: of rank-1 lattices, the best for each of six filters, judged by all six. By numpy alone.

    lattices.py [--size 128] [--samples tent]

The pixel at (x, y) has the phase (a x + b y) / size mod 1, which wraps without a seam; samples go to pixels in the order
of their phases, equal ones by chance. Of all a and b those are taken for which the sum over harmonics k of
F^(k a, k b) / k^2 is least, F^ being the transform of the filter's overlap: it is in proportion to R of uniform samples
with these very phases. What a texture with as low an R could look like, and what its regularity costs under other filters.
"""

import argparse

import numpy as np

from independent_score import overlap_of, relative_error

FILTERS = [("box 3", "box", 3), ("box 5", "box", 5), ("binomial 2", "binomial", 2), ("binomial 3", "binomial", 3),
           ("gauss 0.7", "gauss", 0.7), ("gauss 1.0", "gauss", 1.0)]


def best_generator(overlap, harmonics=400):
    size = overlap.shape[-1]
    transform = np.fft.fft2(overlap[0]).real
    k = np.arange(1, harmonics)
    a = np.arange(size // 2 + 1)
    y = np.outer(np.arange(size), k) % size
    error = np.stack([(transform[y, np.outer([a_x], k) % size] / k ** 2).sum(axis=1) for a_x in a])
    return np.unravel_index(np.argmin(error), error.shape)


def lattice(generator, samples, size, rng):
    a, b = generator
    phase = (a * np.arange(size) + b * np.arange(size)[:, None]) % size
    values = np.empty(size * size, dtype=np.float32)
    values[np.lexsort((rng.random(size * size), phase.ravel()))] = samples
    return values.reshape(1, 1, size, size)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--samples", choices=["uniform", "tent"], default="uniform")
    given = parser.parse_args()
    rng = np.random.default_rng(1)
    num = given.size ** 2
    samples = (np.arange(num) + rng.random(num)) / num
    if given.samples == "tent":
        samples = np.where(samples < 0.5, np.sqrt(2 * samples) - 1, 1 - np.sqrt(2 - 2 * samples))
    shape = (1, given.size, given.size)
    overlaps = {name: overlap_of(shape, [("xy", kernel, [number])], "product") for name, kernel, number in FILTERS}
    print("| lattice for | a, b | " + " | ".join(overlaps) + " |")
    print("|---" * (len(overlaps) + 2) + "|")
    for name, overlap in overlaps.items():
        generator = best_generator(overlap)
        values = lattice(generator, samples, given.size, rng)
        errors = " | ".join(f"{relative_error('scalar', values, judge):.4f}" for judge in overlaps.values())
        print(f"| {name} | {generator[0]}, {generator[1]} | {errors} |", flush=True)


if __name__ == "__main__":
    main()
