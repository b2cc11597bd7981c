#!/usr/bin/python3
"""Relative error R of textures in 8-bit images, by numpy alone: it shares no code with the library that it judges.

    R = ( m sum_d F(d)  -  sum_{d != 0} F(d) m_d ) / ( m F(0) )                                  white noise: 1

F is the autocorrelation of the filter on the torus, m_d the mean distance of samples d apart, m that of all ordered
pairs, a sample with itself included. A byte b stands for (b + 0.5) / 256; directions are 2 u - 1, normalised.

    independent_score.py a.png --space scalar --filter xy:box:5
    independent_score.py strip.png --slices 64 --space scalar --filter xy:gauss:1.3435 --filter t:ema:0.1,0.1
    independent_score.py slice_*.png --space vector2 --filter xy:gauss:1.0 --filter t:ema:0.1,0.1 --combine sum
"""

import argparse
import json
import math
import pathlib
import sys

import numpy as np
from PIL import Image

AXES = "xyt"


# The filter.

def taps_of(kernel, numbers):
    """Taps along one axis, adding up to 1."""
    if kernel == "box":
        taps = np.ones(int(numbers[0]))
    elif kernel == "binomial":
        order = int(numbers[0])
        taps = np.array([math.comb(order, k) for k in range(order + 1)], dtype=float)
    elif kernel == "gauss":
        def below(x):
            return 0.5 * math.erfc(-x / (numbers[0] * math.sqrt(2)))
        reach = 0
        while below(reach + 0.5) - below(-reach - 0.5) < 0.995:
            reach += 1
        taps = np.array([below(i + 0.5) - below(i - 0.5) for i in range(-reach, reach + 1)])
    else:
        raise SystemExit(f"{kernel}: unknown kernel; accepted: box N, binomial N, gauss SIGMA, ema ALPHA,REJECTION")
    return taps / taps.sum()


def ema_overlap(alpha, beta):
    """F(0), F(1), ... of FAST24 eq. 16 and 17, the sum over lengths of the history taken to infinity."""
    if beta == 0:
        count = 1 + int(math.log(1e-18) / math.log1p(-alpha)) if alpha < 1 else 1
        return alpha / (2 - alpha) * (1 - alpha) ** np.arange(count)
    longest = 1 + int(math.log(1e-18) / math.log1p(-beta)) if beta < 1 else 1
    overlap = np.zeros(longest)
    for m in range(1, longest + 1):
        history = alpha * (1 - alpha) ** np.arange(m)
        history[-1] = (1 - alpha) ** (m - 1)
        overlap[:m] += beta * (1 - beta) ** (m - 1) * np.correlate(history, history, "full")[m - 1:]
    return overlap


def axis_overlap(kernel, numbers, size):
    """F of one axis at offsets 0 .. size - 1 on the torus."""
    if kernel == "ema":
        half = ema_overlap(*numbers)
    else:
        taps = taps_of(kernel, numbers)
        half = np.correlate(taps, taps, "full")[taps.size - 1:]
    folded = np.zeros(size)
    np.add.at(folded, np.arange(half.size) % size, half)
    np.add.at(folded, -np.arange(1, half.size) % size, half[1:])
    return folded


def overlap_of(shape, groups, combine, weights=None):
    """F on the whole torus, [t, y, x]. groups: (axes, kernel, numbers); axes in no group couple offset zero alone."""
    sizes = dict(zip(AXES, reversed(shape)))

    def outer(members):
        along = {axis: np.eye(1, sizes[axis])[0] for axis in AXES}
        for axes, kernel, numbers in members:
            for axis in axes:
                along[axis] = axis_overlap(kernel, numbers, sizes[axis])
        return along["t"][:, None, None] * along["y"][:, None] * along["x"]

    if combine == "product":
        return outer(groups)
    weights = weights or [1 / len(groups)] * len(groups)
    return sum(weight * outer([group]) for weight, group in zip(weights, groups))


# Distances. Values are planar: [channel, ...].

def distance(space, a, b):
    if space == "sphere":
        cosine = sum(x * y for x, y in zip(a, b))
        return np.arccos(np.clip(cosine, -1, 1, out=cosine), out=cosine)
    if space in ("scalar", "circle"):
        d = np.abs(a[0] - b[0])
        return d if space == "scalar" else np.minimum(d, 1 - d)
    return np.sqrt(sum(np.square(x - y) for x, y in zip(a, b)))


def sum_of_all(space, a, b):
    """Sum of the distances of all pairs of two lists [channel, n], by matrix products of blocks that fit the cache."""
    total = 0.0
    for begin in range(0, a.shape[1], 64):
        block = a[:, begin:begin + 64]
        if space == "sphere":  # in float: a fifth of the time, and right to 1e-7 on the average
            part = np.clip(block.T.astype(np.float32) @ b.astype(np.float32), -1, 1)
            np.arccos(part, out=part)
        else:
            part = (block * block).sum(axis=0)[:, None] + (b * b).sum(axis=0) - 2 * (block.T @ b)
            np.sqrt(np.maximum(part, 0, out=part), out=part)
        total += part.sum(axis=1).sum(dtype=np.float64)
    return total


def mean_distance(space, values, largest_exact=1 << 15):
    """m. Exact for scalars, and for vectors up to that many samples or in one slice. Else: all pairs inside each slice,
    and of four pairs of slices that stand half the texture apart, from which the others differ in second order only, as
    every slice is a stratified list of one distribution."""
    if space in ("scalar", "circle"):
        levels, counts = np.unique(values, return_counts=True)
        share = counts / counts.sum()
        return float(share @ distance(space, levels[None, :, None], levels[None, None, :]) @ share)
    lists = values.reshape(values.shape[0], values.shape[1], -1)
    slices, cells = lists.shape[1:]
    if slices == 1 or slices * cells <= largest_exact:
        whole = lists.reshape(lists.shape[0], -1)
        return sum_of_all(space, whole, whole) / (slices * cells) ** 2
    inside = np.array([sum_of_all(space, lists[:, s], lists[:, s]) for s in range(slices)]) / cells ** 2
    pairs = [(s, (s + max(1, slices // 2)) % slices) for s in range(0, slices, max(1, slices // 4))]
    apart = [sum_of_all(space, lists[:, s], lists[:, r]) / cells ** 2 - (inside[s] + inside[r]) / 2 for s, r in pairs]
    return float(inside.mean() + (1 - 1 / slices) * np.mean(apart))


def coupled_distance(space, values, overlap):
    """sum over d != 0 of F(d) m_d, from one of each d, -d."""
    slices, height, width = overlap.shape
    flat = np.arange(overlap.size).reshape(overlap.shape)
    mirror = np.roll(flat[::-1, ::-1, ::-1], 1, axis=(0, 1, 2))
    weights = np.where(flat < mirror, 2.0, 1.0) * overlap * (flat <= mirror)
    weights[0, 0, 0] = 0
    total = 0.0
    for dt in range(slices):
        used = np.argwhere(weights[dt] != 0)
        if not used.size:
            continue
        other = np.roll(values, -dt, axis=1)
        other = np.concatenate([other, other], axis=2)
        other = np.concatenate([other, other[..., :width]], axis=3)  # a shift is a view, not a copy
        for dy, dx in used:
            shifted = other[:, :, dy:dy + height, dx:dx + width]
            d = sum(distance(space, values[:, s], shifted[:, s]).sum(dtype=np.float64) for s in range(slices))
            total += weights[dt, dy, dx] * d / overlap.size
    return total


def relative_error(space, values, overlap):
    """R of values [channel, t, y, x]."""
    m = mean_distance(space, values)
    coupled = coupled_distance(space, values, overlap)
    return (m * overlap.sum() - coupled) / (m * overlap[0, 0, 0])


# Images and the command line.

def decode(images, space, slices=1):
    """Values [channel, t, y, x] of arrays of bytes [y, x] or [y, x, channel], `slices` of them in each, downward."""
    channels = {"scalar": 1, "circle": 1, "sphere": 3}.get(space) or int(space.removeprefix("vector"))
    planes = []
    for image in images:
        image = image.reshape(*image.shape[:2], -1)
        if image.shape[2] < channels or image.shape[0] % slices:
            raise SystemExit(f"an image of shape {image.shape} holds no {slices} slices of {space}")
        planes += np.split(np.moveaxis(image[..., :channels], -1, 0), slices, axis=1)
    u = (np.stack(planes, axis=1).astype(np.float64) + 0.5) / 256
    if space == "sphere":
        v = 2 * u - 1
        return v / np.sqrt((v * v).sum(axis=0))
    return u.astype(np.float32) if channels == 1 else u  # differences of bytes are exact in float32


def parse_group(text):
    axes, kernel, numbers = text.split(":")
    if not axes or set(axes) - set(AXES):
        raise argparse.ArgumentTypeError(f"{text}: axes are letters of {AXES}")
    numbers = [float(number) for number in numbers.split(",")]
    if len(numbers) != (2 if kernel == "ema" else 1):
        raise argparse.ArgumentTypeError(f"{text}: {len(numbers)} numbers")
    return axes, kernel, numbers


def score_images(paths, space, groups, combine="product", slices=1, weights=None):
    images = [np.asarray(Image.open(path)) for path in paths]
    if any(image.dtype != np.uint8 for image in images):
        raise SystemExit("only images of 8 bits are read")
    values = decode(images, space, slices)
    return relative_error(space, values, overlap_of(values.shape[1:], groups, combine, weights))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("images", nargs="+", type=pathlib.Path, help="one image a slice, or strips (--slices)")
    parser.add_argument("--space", required=True, help="scalar, circle, vectorN, sphere (any directions)")
    parser.add_argument("--filter", action="append", required=True, type=parse_group, metavar="AXES:KERNEL:NUMBERS",
                        help="box:N, binomial:N, gauss:SIGMA, ema:ALPHA,REJECTION; one for each group")
    parser.add_argument("--combine", choices=["product", "sum"], default="product")
    parser.add_argument("--weights", type=lambda text: [float(w) for w in text.split(",")], help="of a sum; else equal")
    parser.add_argument("--slices", type=int, default=1, help="slices in each image, one under the other")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    r = score_images(given.images, given.space, given.filter, given.combine, given.slices, given.weights)
    print(json.dumps({"relative_error": r}) if given.json else f"R = {r:.5f}")


if __name__ == "__main__":
    sys.exit(main())
