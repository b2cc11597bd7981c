#!/usr/bin/python3
"""How blue a scalar texture is, by numpy alone: it shares no code with the program that it judges.

Power is |FFT|^2 over what white noise of the same variance has (the number of values transformed times the variance of
the whole texture), averaged over all lines or planes.

    low-frequency power   mean over the frequencies 0 < |f| < 0.05 cycles a pixel
    first bins            power at the three lowest frequencies along a slice axis, averaged over all pixels

    mask_quality.py run.h5                  /samples of a run file (needs h5py)
    mask_quality.py samples.npy --json      [slice axes..., y, x, 1], as noiseloom export writes it
    mask_quality.py run.h5 --order          (order + 1/2) / N, whatever the samples are quantised to
    mask_quality.py run.h5 --points 0.1     the point set at that density instead
"""

import argparse
import json
import pathlib
import sys

import numpy as np

LIMIT = 0.05
NAMES = "xytzwvus"


def power(values, axes):
    """White = 1; frequencies along the axes first, in the order given, the mean over all others taken."""
    spectrum = np.abs(np.fft.fftn(values - values.mean(), axes=axes)) ** 2
    count = np.prod([values.shape[a] for a in axes])
    others = tuple(a for a in range(values.ndim) if a not in axes)
    return spectrum.mean(axis=others) / (count * values.var())


def power_below(spectrum, limit=LIMIT):
    f = np.sqrt(sum(np.square(grid) for grid in np.meshgrid(*map(np.fft.fftfreq, spectrum.shape), indexing="ij")))
    low = (f > 0) & (f < limit)
    return float(spectrum[low].mean()) if low.any() else None


def quality(values, groups=()):
    """Of values [slice axes..., y, x]: xy, every slice axis, and further groups, such as "zw"."""
    names = NAMES[:values.ndim][::-1]  # of the array's axes
    found = {"low_frequency_power": {}, "first_bins": {}}
    for group in ["xy", *NAMES[2:values.ndim], *groups]:
        axes = tuple(a for a in range(values.ndim) if names[a] in group and values.shape[a] > 1)
        if not axes or group in found["low_frequency_power"]:
            continue
        spectrum = power(values, axes)
        found["low_frequency_power"][group] = power_below(spectrum)
        if len(group) == 1:
            found["first_bins"][group] = [float(p) for p in spectrum[1:min(3, spectrum.size // 2) + 1]]
    return found


def load(path, order=False, density=None):
    """Values [slice axes..., y, x] in double."""
    if path.suffix == ".npy":
        values = np.load(path)
        return (values[..., 0] if values.shape[-1] == 1 else values).astype(np.float64)
    import h5py
    with h5py.File(path) as file:
        if order or density is not None:
            places = file["order"][...]
            if density is not None:
                return (places < int(density * places.size)).astype(np.float64)
            return (places + 0.5) / places.size
        return file["samples"][..., 0].astype(np.float64)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=pathlib.Path)
    parser.add_argument("--order", action="store_true", help="of /order instead of /samples")
    parser.add_argument("--points", type=float, metavar="DENSITY", help="of the points that come first instead")
    parser.add_argument("--group", action="append", default=[], metavar="AXES", help="further axes, such as zw")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    found = quality(load(given.file, given.order, given.points), given.group)
    if given.json:
        print(json.dumps(found))
        return
    for name, value in found["low_frequency_power"].items():
        print(f"{name}: power below {LIMIT} " + ("has no frequency" if value is None else f"{value:.4g}"))
    for name, values in found["first_bins"].items():
        print(f"{name}: first bins " + ", ".join(f"{v:.4g}" for v in values))


if __name__ == "__main__":
    sys.exit(main())
