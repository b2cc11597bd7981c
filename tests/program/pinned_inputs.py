"""The files that the configs of pinned_samples_test.py name, made of integers, divisions and square roots alone: the same
bytes on every machine."""

import struct


def npy(values, shape):
    """A .npy file of float32."""
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': ({', '.join(map(str, shape))},), }}"
    header += " " * (63 - (10 + len(header)) % 64) + "\n"
    return (b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() +
            struct.pack(f"<{len(values)}f", *values))


def draws(count, seed):
    """Numbers in [0, 1) with 16 bits each: exact in float32."""
    state = seed
    for _ in range(count):
        state = (state * 1103515245 + 12345) % 2**31
        yield (state >> 8) % 65536 / 65536


def directions(count, seed):
    numbers = list(draws(3 * count, seed))
    for at in range(0, 3 * count, 3):
        x, y, z = (2 * n - 1 + 2**-18 for n in numbers[at:at + 3])
        length = (x * x + y * y + z * z)**0.5
        yield from (x / length, y / length, z / length)


def write_inputs(folder):
    """The files that the configs name."""
    files = {
        "scalars.npy": npy([4 * n - 1 for n in draws(40, 1)], [40]),
        "circle.npy": npy(list(draws(40, 2)), [40]),
        "directions.npy": npy(list(directions(40, 3)), [40, 3]),
        "points-per-slice.npy": npy(list(draws(3 * 40 * 2, 4)), [3, 40, 2]),
        "light.npy": npy([n if n > 0.2 else 0 for n in draws(9 * 14, 5)], [9, 14]),
        "taps-4.npy": npy([1, 3, 2, 0.5], [4]),
        "taps-3x2.npy": npy([1, 2, 4, 1, 3, 0.5], [3, 2]),
    }
    for name, data in files.items():
        (folder / name).write_bytes(data)
