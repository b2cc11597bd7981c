"""The bytes of small textures, one for each thing that may decide them: they change only where somebody means it.

A texture is a promise: the same config gives the same bytes, on any machine, with any number of ranks and threads, and
with the next version of the program. So each config here stands beside the checksum of its /samples (with void and
cluster, of its /order too). Where a change of the program is meant to give other bytes, write the new table with

    python3 pinned_samples_test.py --print        (the environment is that of ctest; see tests/CMakeLists.txt)

look which configs have changed and why, and put the lines that it prints in the place of those below.

Whatever a config takes from a file is made by pinned_inputs.py.
"""

import concurrent.futures
import sys
import tomllib

from pinned_inputs import write_inputs
from support import PLAIN_CPU, THOROUGH, ProgramTest, main

ANNEAL = 'optimizer.method = "anneal"\noptimizer.stop = { iterations = 60 }\n'
FAST = 'optimizer.method = "fast"\noptimizer.stop = { iterations = 16 }\n'
CONSTRUCT = 'optimizer.method = "construct"\n'
ORDER = 'optimizer.method = "void-and-cluster"\n'

BOX_EMA = 'filter.groups = [{ axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "ema", alpha = 0.1 }]\n'
GAUSS_2D = 'filter.groups = [{ axes = "xy", kernel = "gauss", sigma = 0.8 }]\n'
BLUE_2D = 'filter.groups = [{ axes = "xy", kernel = "gauss-energy", sigma = 1.3 }]\n'

# What is pinned: name, config. Sizes are odd or prime where nothing speaks against it.
CONFIGS = {
    # Annealing: sample spaces and kernels.
    "uniform, box":
        'texture.size = { x = 31, y = 29 }\n'
        'filter.groups = [{ axes = "xy", kernel = "box", size = 5 }]\noptimizer = { method = "anneal", stop = { iterations = 250 } }\n',
    "uniform, one pixel a slice":
        'texture.size = { x = 1, y = 1, t = 5 }\n' + BOX_EMA + ANNEAL,
    "tent, binomial, other seed and temperatures":
        'texture.size = { x = 24, y = 17 }\ntexture.samples = "tent"\ntexture.seed = 77\n'
        'filter.groups = [{ axes = "xy", kernel = "binomial", n = 2 }]\n'
        'optimizer.temperature = { start = 0.3, end = 0.001 }\n' + ANNEAL,
    "gauss, gauss x ema, product over a deep axis":
        'texture.size = { x = 15, y = 13, t = 23 }\ntexture.samples = "gauss"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss", sigma = 0.9 },\n'
        '                 { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.2 }]\n' + ANNEAL,
    "uniform, product over a deep axis without features":
        'texture.size = { x = 16, y = 11, t = 19 }\n' + BOX_EMA + 'optimizer.background_features = 0\n' + ANNEAL,
    "circle, product over a deep axis":
        'texture.size = { x = 16, y = 15, t = 17 }\ntexture.samples = "circle"\n' + BOX_EMA + ANNEAL,
    "circle, tiles":
        'texture.size = { x = 131, y = 97, t = 2 }\ntexture.samples = "circle"\n'
        'filter.groups = [{ axes = "xy", kernel = "box", size = 3 }]\n'
        'optimizer = { method = "anneal", stop = { iterations = 50 } }\n',
    "vector2, stbn, sum of two groups":
        'texture.size = { x = 16, y = 16, t = 7 }\ntexture.samples = "vector2"\n'
        'filter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss-energy", sigma = 1.34 },\n'
        '                 { axes = "t", kernel = "gauss-energy", sigma = 1.2 }]\n'
        'energy = { value_kernel = "stbn", sigma_s = 0.9 }\n' + ANNEAL,
    "vector2, stbn, product over a deep axis":
        'texture.size = { x = 14, y = 15, t = 17 }\ntexture.samples = "vector2"\n' + BOX_EMA +
        'energy.value_kernel = "stbn"\noptimizer.background_rank = 12\n' + ANNEAL,
    "vector3, product over a deep axis":
        'texture.size = { x = 14, y = 11, t = 17 }\ntexture.samples = "vector3"\n' + BOX_EMA + ANNEAL,
    "vector3, double precision":
        'texture.size = { x = 14, y = 15, t = 5 }\ntexture.samples = "vector3"\n' + BOX_EMA +
        'optimizer.precision = "double"\n' + ANNEAL,
    "vector4, sum with weights over two slice axes":
        'texture.size = { x = 9, y = 10, t = 5, z = 4 }\ntexture.samples = "vector4"\n'
        'filter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss", sigma = 0.7, weight = 0.5 },\n'
        '                 { axes = "t", kernel = "ema", alpha = 0.2, weight = 0.3 },\n'
        '                 { axes = "z", kernel = "box", size = 3, weight = 0.2 }]\n' + ANNEAL,
    "vector8, box":
        'texture.size = { x = 16, y = 13 }\ntexture.samples = "vector8"\n'
        'filter.groups = [{ axes = "xy", kernel = "box", size = 3 }]\n' + ANNEAL,
    "sphere, cutoff":
        'texture.size = { x = 16, y = 13, t = 4 }\ntexture.samples = "sphere"\n' + BOX_EMA +
        'optimizer.cutoff = 0.02\n' + ANNEAL,
    "vector3, sum of two groups, cutoff":
        'texture.size = { x = 16, y = 13, t = 9 }\ntexture.samples = "vector3"\nfilter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss", sigma = 0.9, weight = 0.99 },\n'
        '                 { axes = "t", kernel = "ema", alpha = 0.3, weight = 0.01 }]\n'
        'optimizer.cutoff = 0.05\n' + ANNEAL,
    "hemisphere, product over three slice axes":
        'texture.size = { x = 8, y = 7, t = 3, z = 3, w = 2 }\ntexture.samples = "hemisphere"\n'
        'filter.groups = [{ axes = "xy", kernel = "box", size = 3 }, { axes = "tzw", kernel = "binomial", n = 1 }]\n' +
        ANNEAL,
    "hemisphere-cosine, product over a deep axis":
        'texture.size = { x = 13, y = 11, t = 16 }\ntexture.samples = "hemisphere-cosine"\n' + BOX_EMA + ANNEAL,
    "disk, table of two dimensions":
        'texture.size = { x = 17, y = 19 }\ntexture.samples = "disk"\n'
        'filter.groups = [{ axes = "xy", kernel = "table", file = "taps-3x2.npy" }]\n' + ANNEAL,
    # Spaces with a density in closed form or with parameters, at hard ones too; axes.
    "exponential, annealed":
        'texture.size = { x = 23, y = 16 }\ntexture.samples = "exponential"\n' + GAUSS_2D + ANNEAL,
    "cone, a narrow one, product over a deep axis":
        'texture.size = { x = 13, y = 11, t = 16 }\ntexture.samples = { space = "cone", angle = 0.5 }\n' + BOX_EMA + ANNEAL,
    "ggx, product over a deep axis":
        'texture.size = { x = 14, y = 11, t = 16 }\ntexture.samples = "ggx"\n' + BOX_EMA + ANNEAL,
    "ggx, smooth and grazing, product over a deep axis":
        'texture.size = { x = 14, y = 11, t = 16 }\n'
        'texture.samples = { space = "ggx", roughness = 0.001, view = 89 }\n' + BOX_EMA + ANNEAL,
    "ring":
        'texture.size = { x = 17, y = 19 }\ntexture.samples = { space = "ring", inner = 0.9 }\n' + GAUSS_2D + ANNEAL,
    "hexagon":
        'texture.size = { x = 17, y = 19 }\ntexture.samples = "hexagon"\n' + GAUSS_2D + ANNEAL,
    "star of three points":
        'texture.size = { x = 17, y = 19 }\n'
        'texture.samples = { space = "star", points = 3, inner = 0.1 }\n' + GAUSS_2D + ANNEAL,
    "star of sixteen points":
        'texture.size = { x = 17, y = 19 }\n'
        'texture.samples = { space = "star", points = 16, inner = 0.5 }\n' + GAUSS_2D + ANNEAL,
    "gauss2":
        'texture.size = { x = 17, y = 19 }\ntexture.samples = "gauss2"\n' + GAUSS_2D + ANNEAL,
    "triangle":
        'texture.size = { x = 17, y = 19 }\ntexture.samples = "triangle"\n' + GAUSS_2D + ANNEAL,
    "axis, product over a deep axis":
        'texture.size = { x = 14, y = 11, t = 16 }\ntexture.samples = "axis"\n' + BOX_EMA + ANNEAL,
    "rotation, stbn":
        'texture.size = { x = 16, y = 13, t = 3 }\ntexture.samples = "rotation"\n' + BOX_EMA +
        'energy.value_kernel = "stbn"\n' + ANNEAL,
    "rotation, double precision":
        'texture.size = { x = 12, y = 13, t = 3 }\ntexture.samples = "rotation"\n' + BOX_EMA +
        'optimizer.precision = "double"\n' + ANNEAL,
    # Other distances.
    "vector2, sum of differences, stbn, sum of two groups":
        'texture.size = { x = 16, y = 16, t = 7 }\ntexture.samples = { space = "vector2", distance = "manhattan" }\n'
        'filter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss-energy", sigma = 1.9 },\n'
        '                 { axes = "t", kernel = "gauss-energy", sigma = 1.9 }]\n'
        'energy.value_kernel = "stbn"\n' + ANNEAL,
    "vector3, largest difference, product over a deep axis":
        'texture.size = { x = 13, y = 11, t = 16 }\n'
        'texture.samples = { space = "vector3", distance = "chebyshev" }\n' + BOX_EMA + ANNEAL,
    "sphere, cosine, product over a deep axis":
        'texture.size = { x = 13, y = 11, t = 16 }\ntexture.samples = { space = "sphere", distance = "cosine" }\n' +
        BOX_EMA + ANNEAL,
    "vector2, sum of differences, double precision":
        'texture.size = { x = 12, y = 13, t = 3 }\ntexture.samples = { space = "vector2", distance = "manhattan" }\n' +
        BOX_EMA + 'optimizer.precision = "double"\n' + ANNEAL,
    # The user's own samples.
    "list of scalars, table of one dimension":
        'texture.size = { x = 8, y = 5, t = 3 }\ntexture.samples = { file = "scalars.npy", distance = "absolute" }\n'
        'filter.groups = [{ axes = "xy", kernel = "table", file = "taps-4.npy" }]\n' + ANNEAL,
    "list on the circle":
        'texture.size = { x = 8, y = 5 }\ntexture.samples = { file = "circle.npy", distance = "circle" }\n' + GAUSS_2D +
        ANNEAL,
    "list of unit vectors":
        'texture.size = { x = 8, y = 5, t = 4 }\ntexture.samples = { file = "directions.npy", distance = "angle" }\n' +
        BOX_EMA + ANNEAL,
    "list of points for each slice":
        'texture.size = { x = 8, y = 5, t = 3 }\ntexture.samples = { file = "points-per-slice.npy" }\n' + GAUSS_2D +
        ANNEAL,
    # Other ends of a run.
    "stop by score":
        'texture.size = { x = 17, y = 16 }\n' + GAUSS_2D + 'optimizer = { method = "anneal", stop = { score = 0.3 } }\n',
    "stop by improvement":
        'texture.size = { x = 16, y = 9 }\n' + GAUSS_2D + 'optimizer = { method = "anneal", stop = { improvement = 0.2 } }\n',
    # The published algorithm.
    "fast, uniform, product":
        'texture.size = { x = 16, y = 15, t = 6 }\n' + BOX_EMA + FAST,
    "fast, sum of two groups, cutoff":
        'texture.size = { x = 16, y = 13, t = 9 }\nfilter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss", sigma = 0.9, weight = 0.99 },\n'
        '                 { axes = "t", kernel = "ema", alpha = 0.3, weight = 0.01 }]\n'
        'optimizer.cutoff = 0.05\n' + FAST,
    "fast, hemisphere-cosine, fraction that does not grow":
        'texture.size = { x = 12, y = 15 }\ntexture.samples = "hemisphere-cosine"\n' + GAUSS_2D +
        'optimizer.fraction = 0.2\noptimizer.grow_fraction = false\n' + FAST,
    # Void and cluster.
    "order in a plane":
        'texture.size = { x = 37, y = 31 }\n' + BLUE_2D + ORDER,
    "order, sum over one slice axis, bits, equal slices":
        'texture.size = { x = 16, y = 15, t = 9 }\nfilter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss-energy" }, { axes = "t", kernel = "gauss-energy" }]\n'
        'optimizer.bits = 6\noptimizer.equalize = "slice"\n' + ORDER,
    "order over two slice axes, bounded, other density":
        'texture.size = { x = 9, y = 8, z = 5, w = 4 }\ntexture.seed = 5\nfilter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss-energy", sigma = 1.2 },\n'
        '                 { axes = "zw", kernel = "gauss-energy", sigma = 1.0 }]\n'
        'optimizer.bounded = "xw"\noptimizer.density = 0.2\noptimizer.bits = 8\n' + ORDER,
    "order over one group of three axes":
        'texture.size = { x = 11, y = 13, t = 7 }\n'
        'filter.groups = [{ axes = "xyt", kernel = "gauss-energy", sigma = 1.5 }]\n' + ORDER,
    "order, vector3 along a Hilbert curve":
        'texture.size = { x = 14, y = 9, t = 5 }\ntexture.samples = "vector3"\nfilter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss-energy" }, { axes = "t", kernel = "gauss-energy" }]\n'
        'optimizer.curve = "hilbert"\noptimizer.equalize = "slice"\n' + ORDER,
    # Construction: every kernel, product and sum, slice axes, samples.
    "construct, uniform, gauss x ema":
        'texture.size = { x = 33, y = 29, t = 9 }\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss", sigma = 1.0 },\n'
        '                 { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 }]\n' + CONSTRUCT,
    "construct, tent, box in one slice":
        'texture.size = { x = 67, y = 64 }\ntexture.samples = "tent"\n'
        'filter.groups = [{ axes = "xy", kernel = "box", size = 5 }]\n' + CONSTRUCT,
    "construct, gauss, sum over two slice axes, other seed":
        'texture.size = { x = 17, y = 13, z = 3, w = 5 }\ntexture.samples = "gauss"\ntexture.seed = 5\n'
        'filter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "binomial", n = 3 }, { axes = "zw", kernel = "gauss-energy", sigma = 1.0 }]\n'
        + CONSTRUCT + 'optimizer.density = 0.1\n',
    "construct, a list, table, given sharpness":
        'texture.size = { x = 8, y = 5, t = 4 }\ntexture.samples = { file = "scalars.npy" }\n'
        'filter.groups = [{ axes = "xy", kernel = "table", file = "taps-4.npy" }, { axes = "t", kernel = "box", size = 2 }]\n'
        + CONSTRUCT + 'optimizer.sharpness = 1.25\n',
    "construct, exponential":
        'texture.size = { x = 23, y = 19, t = 3 }\ntexture.samples = "exponential"\n' + GAUSS_2D + CONSTRUCT,
    "construct, circle, box x ema":
        'texture.size = { x = 33, y = 27, t = 6 }\ntexture.samples = "circle"\n'
        'filter.groups = [{ axes = "xy", kernel = "box", size = 3 },\n'
        '                 { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 }]\n' + CONSTRUCT,
    "construct, circle, gauss in one slice":
        'texture.size = { x = 67, y = 63 }\ntexture.samples = "circle"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss", sigma = 1.0 }]\n' + CONSTRUCT,
    "construct, vector2 along a Hilbert curve":
        'texture.size = { x = 23, y = 19, t = 3 }\ntexture.samples = "vector2"\n' + BOX_EMA +
        CONSTRUCT + 'optimizer.curve = "hilbert"\n',
    "construct, vector4 along a Morton curve, the eye over time":
        'texture.size = { x = 16, y = 11, t = 24 }\ntexture.samples = "vector4"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss", sigma = 1.0 },\n'
        '                 { axes = "t", kernel = "eye", frames_per_second = 60, pixels_per_degree = 40 }]\n' +
        CONSTRUCT + 'optimizer.curve = "morton"\n',
    "construct, blue noise":
        'texture.size = { x = 23, y = 19, t = 4 }\nfilter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss-energy" }, { axes = "t", kernel = "gauss-energy" }]\n' + CONSTRUCT,
    # Construction that is annealed, by what auto stands for: in the cold, and where it joins the schedule.
    "densities of an image, onto the sphere":
        'texture.size = { x = 16, y = 13, t = 7 }\n'
        'texture.samples = { image = "light.npy", onto = "sphere", encoding = "linear" }\n' + BOX_EMA + ANNEAL,
    "densities of an image, onto the disk":
        'texture.size = { x = 17, y = 13 }\ntexture.samples = { image = "light.npy", onto = "disk", encoding = "srgb" }\n' +
        GAUSS_2D + ANNEAL,
    "order, the sum of three slices in a row":
        'texture.size = { x = 19, y = 16, t = 7 }\nfilter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss-energy", sigma = 1.5 },\n'
        '                 { axes = "xyt", kernel = "gauss-energy", sigma = 1.5, box = "t", box_size = 3 }]\n' + ORDER,
    "order, tiles":
        'texture.size = { x = 17, y = 14, k = 5 }\n'
        'filter.groups = [{ axes = "xyk", kernel = "gauss-energy", sigma = 1.5, tiles = "k" }]\n' + ORDER,
    "order, with a tail":
        'texture.size = { x = 21, y = 18, t = 3 }\nfilter.combine = "sum"\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss-energy", sigma = 1.5, tail = 1e-3 },\n'
        '                 { axes = "t", kernel = "gauss-energy", sigma = 0.8 }]\n' + ORDER,
    "nets":
        'texture.size = { x = 16, y = 8, t = 4 }\ntexture.samples = "sobol-owen"\n' + BOX_EMA + ANNEAL,
    "nets of scalars, constructed":
        'texture.size = { x = 16, y = 8, t = 4 }\ntexture.samples = { space = "sobol-owen", channels = 1 }\n' + BOX_EMA +
        CONSTRUCT,
    "strata over time":
        'texture.size = { x = 12, y = 10, t = 20 }\ntexture.stratify = "slice+time"\n' + GAUSS_2D + ANNEAL,
    "auto, constructed, annealed in the cold":
        'texture.size = { x = 24, y = 17, t = 5 }\n'
        'filter.groups = [{ axes = "xy", kernel = "gauss", sigma = 1.0 }, { axes = "t", kernel = "ema", alpha = 0.3 }]\n'
        'optimizer.stop = { iterations = 40 }\n',
    "auto, constructed, annealed":
        'texture.size = { x = 32, y = 31 }\n'
        'filter.groups = [{ axes = "xy", kernel = "box", size = 3 }]\noptimizer.stop = { iterations = 2000 }\n',
}

# The number of the algorithm of each method that the checksums below belong to.
ALGORITHMS = {
    "anneal": 10,  # anneal_algorithm in include/noiseloom/anneal/swap_optimizer.h
    "fast": 3,  # fast_algorithm, there too
    "void-and-cluster": 2,  # void_and_cluster_algorithm in include/noiseloom/construct/void_and_cluster.h
    "construct": 3,  # construct_algorithm in include/noiseloom/construct/slice_construction.h
}

# What they gave: name, combined checksum of /samples, and of /order where there is one.
CHECKSUMS = {
    "uniform, box": ("714e88fdc7ae8fbb",),
    "uniform, one pixel a slice": ("44e9b720b3ccbb48",),
    "tent, binomial, other seed and temperatures": ("ad597ec63dc7879b",),
    "gauss, gauss x ema, product over a deep axis": ("fec846f46ca9c434",),
    "uniform, product over a deep axis without features": ("de8c40148348021d",),
    "circle, product over a deep axis": ("737e0f6c6c0948e8",),
    "circle, tiles": ("95f1619a033e0c32",),
    "vector2, stbn, sum of two groups": ("7098813d2084d02a",),
    "vector2, stbn, product over a deep axis": ("e7256cfd0a2e1bec",),
    "vector3, product over a deep axis": ("ddd5d180432944ad",),
    "vector3, double precision": ("971f847ba8c525da",),
    "vector4, sum with weights over two slice axes": ("0a4157c7e0778e7a",),
    "vector8, box": ("8358c71c6e736746",),
    "sphere, cutoff": ("012aea78e5aa7b47",),
    "vector3, sum of two groups, cutoff": ("8b15028e7d74fe76",),
    "hemisphere, product over three slice axes": ("e54ae2b220447d9b",),
    "hemisphere-cosine, product over a deep axis": ("e702cdb4372fcf12",),
    "disk, table of two dimensions": ("f517e17668d4f0a0",),
    "exponential, annealed": ("f8055bfc92a975ce",),
    "cone, a narrow one, product over a deep axis": ("fd6174763b6c7e05",),
    "ggx, product over a deep axis": ("d92cc8d99f928cea",),
    "ggx, smooth and grazing, product over a deep axis": ("f844e4045710ec1c",),
    "ring": ("751ff36a413fe649",),
    "hexagon": ("ce35cd8c7ef239ae",),
    "star of three points": ("49cd6767d117223d",),
    "star of sixteen points": ("22502835daab53e9",),
    "gauss2": ("48d1f9223f8d4498",),
    "triangle": ("2fa1403edc4b67c7",),
    "axis, product over a deep axis": ("4f55f1f62415e32e",),
    "rotation, stbn": ("93a620a20b574b7e",),
    "rotation, double precision": ("961efadbdb2973c4",),
    "vector2, sum of differences, stbn, sum of two groups": ("7856e57e29bbc163",),
    "vector3, largest difference, product over a deep axis": ("7c351ba30a77465b",),
    "sphere, cosine, product over a deep axis": ("7ecb6f31e71bf50b",),
    "vector2, sum of differences, double precision": ("a247fbb1e7feb7c6",),
    "list of scalars, table of one dimension": ("f17f40a318d869a6",),
    "list on the circle": ("365f4960eee1b805",),
    "list of unit vectors": ("60a4d4c94ac5d292",),
    "list of points for each slice": ("adced8dc9b623257",),
    "stop by score": ("26fc42607bef7fe2",),
    "stop by improvement": ("61f046c4093cda3b",),
    "fast, uniform, product": ("875bc7bd2db4ba5c",),
    "fast, sum of two groups, cutoff": ("7afb56d7f153f2a4",),
    "fast, hemisphere-cosine, fraction that does not grow": ("2d7e91b92df27ebc",),
    "order in a plane": ("b927a5389907cf06", "1c4fd8fee0bd5296",),
    "order, sum over one slice axis, bits, equal slices": ("b3309b481c532874", "cb32a6c5524dc9db",),
    "order over two slice axes, bounded, other density": ("0473bd13bfcacc5d", "204e2af5001936e6",),
    "order over one group of three axes": ("e342ca25d9b9acb9", "0561dab2aaf109d7",),
    "order, vector3 along a Hilbert curve": ("36e8dae7537e3df7", "e157bd1a99f25ce3",),
    "construct, uniform, gauss x ema": ("3213c3850644ae2e",),
    "construct, tent, box in one slice": ("cdb79120bf909ee9",),
    "construct, gauss, sum over two slice axes, other seed": ("c7524501ea97233e",),
    "construct, a list, table, given sharpness": ("ae90f92e8f2f1fcb",),
    "construct, exponential": ("be719baf481bb689",),
    "construct, circle, box x ema": ("ac7b02f8e1073435",),
    "construct, circle, gauss in one slice": ("1d84dd44624a48f1",),
    "construct, vector2 along a Hilbert curve": ("206ea583665d29d4",),
    "construct, vector4 along a Morton curve, the eye over time": ("4f0e92e3e87736f0",),
    "construct, blue noise": ("f095fab96e96459e",),
    "densities of an image, onto the sphere": ("6bd4d7276bec34ed",),
    "densities of an image, onto the disk": ("0602e455cb33bfc0",),
    "order, the sum of three slices in a row": ("c24f3b2cff84520b", "87f3e75751555459",),
    "order, tiles": ("64f3e14da37fca17", "98eecc9c163ced50",),
    "order, with a tail": ("a0c6fbd699ccfabf", "8f2f0b182456ab8d",),
    "nets": ("d512cc70a12dd67e",),
    "nets of scalars, constructed": ("0ef759e60d7a76d6",),
    "strata over time": ("f972eefc52257740",),
    "auto, constructed, annealed in the cold": ("7633c1bda6e4503f",),
    "auto, constructed, annealed": ("92b4133d7850f555",),
}


# Of what no other test asks for the same bytes on ranks.
ELSEWHERE_UNTRIED = ("vector3, double precision", "list of unit vectors", "stop by score")


class PinnedSamples(ProgramTest):
    maxDiff = None

    def setUp(self):
        super().setUp()
        write_inputs(self.folder)

    def checksums_of(self, name, number, *arguments, **options):
        config = self.write(f"{number}.toml", CONFIGS[name])
        run_file = f"{number}.h5"
        self.run_program("generate", config, "-o", run_file, "--overwrite", "--progress", "none", *arguments, **options)
        found = self.info(run_file)
        optimizer = tomllib.loads(found["config"])["optimizer"]
        # What was constructed and then annealed is, in the end, annealed.
        method = "anneal" if optimizer["method"] == "construct" and "stop" in optimizer else optimizer["method"]
        self.assertEqual(found["state"]["algorithm"], ALGORITHMS[method], f"{name}: the number of the algorithm {method}")
        return tuple(found["checksums"][dataset] for dataset in ("/samples", "/order") if dataset in found["checksums"])

    def all_checksums(self, *arguments, names=tuple(CONFIGS), **options):
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            found = pool.map(lambda number, name: self.checksums_of(name, number, *arguments, **options), range(len(names)), names)
            return dict(zip(names, found))

    def compare(self, found):
        changed = [f"{name}: {found[name]}, pinned {CHECKSUMS.get(name)}" for name in found if found[name] != CHECKSUMS.get(name)]
        self.assertEqual(changed, [], "textures have changed: unless they should not, raise the number of the algorithm; the head of this file says how")
        self.assertEqual(list(CHECKSUMS), list(CONFIGS), "a config without a checksum, or the other way round")

    def test_one_thread(self):
        self.compare(self.all_checksums("--threads", 1))

    def test_two_ranks_of_two_threads_without_fma(self):
        # Every fifth one: same_bytes_test.py and the tests of folders ask for the same bytes of ranks, and a launcher takes
        # longer than the texture.
        names = tuple(CONFIGS) if THOROUGH else tuple(dict.fromkeys(tuple(CONFIGS)[1::5] + ELSEWHERE_UNTRIED))
        self.compare(self.all_checksums("--threads", 2, ranks=2, environment=PLAIN_CPU, names=names))


def print_table():
    test = PinnedSamples()
    test.setUp()
    try:
        for name, checksums in test.all_checksums().items():
            print(f'    "{name}": (' + " ".join(f'"{checksum}",' for checksum in checksums) + "),")
    finally:
        test.doCleanups()


if __name__ == "__main__":
    if sys.argv[1:] == ["--print"]:
        print_table()
    else:
        main()
