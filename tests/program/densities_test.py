"""Sample spaces with a density: what a renderer would find that divides by /pdf.

For each space ten integrands whose integrals over its support are known in closed form: the mean of f / pdf over all
samples of a texture must be the integral, to 4 standard errors (of independent samples: those of a texture are
stratified, and do better). The mean of 1 / pdf must be the measure of the support.
"""

import math

import h5py
import numpy

from support import SOURCE, ProgramTest, main

VIEW = 60


def exponential(x):
    return [(x[0] ** k * numpy.exp(-2 * x[0]), math.factorial(k) / 2 ** (k + 1)) for k in range(10)]


def tent(x):
    return [((x[0] * (1 - x[0])) ** k, math.gamma(k + 1) ** 2 / math.gamma(2 * k + 2)) for k in range(1, 11)]


def gauss(x):
    return [(abs(x[0]) ** k * numpy.exp(-x[0] ** 2), math.gamma((k + 1) / 2)) for k in range(10)]


PAIRS = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (2, 2), (3, 3)]


def gauss2(x):
    return [(abs(x[0]) ** a * abs(x[1]) ** b * numpy.exp(-x[0] ** 2 - x[1] ** 2),
             math.gamma((a + 1) / 2) * math.gamma((b + 1) / 2)) for a, b in PAIRS]


def triangle(x):
    def integral(a):
        return math.sqrt(math.pi) * math.gamma(a + 1) / math.gamma(a + 1.5)
    return [((1 - x[0] ** 2) ** (a + 1) * (1 - x[1] ** 2) ** (b + 1), integral(a + 1) * integral(b + 1)) for a, b in PAIRS]


def hemisphere(x):
    return [(x[2] ** k, 2 * math.pi / (k + 1)) for k in range(1, 11)]


def ggx(x):
    """y^2j z (v . h) over the half vectors above the horizon that the viewer sees: a lune around the axis y."""
    view = math.radians(VIEW)
    width = math.pi - view
    across = (math.sin(width) - width * math.cos(width)) / 2
    seen = math.sin(view) * x[0] + math.cos(view) * x[2]
    return [(x[1] ** (2 * j) * x[2] * seen, (2 / (2 * j + 1) - 2 / (2 * j + 3)) * across) for j in range(10)]


LUNE = 2 * (math.pi - math.radians(VIEW))

# What a config says, the integrands, the measure of the support.
SPACES = {
    '"exponential"': (exponential, None),
    '"tent"': (tent, 1),
    '"gauss"': (gauss, None),
    '"gauss2"': (gauss2, None),
    '"triangle"': (triangle, 4),
    '"hemisphere-cosine"': (hemisphere, 2 * math.pi),
    f'{{ space = "ggx", roughness = 0.5, view = {VIEW} }}': (ggx, LUNE),
    f'{{ space = "ggx", roughness = 1, view = {VIEW} }}': (ggx, LUNE),
}

CONFIG = """
[texture]
size    = { x = 64, y = 61, t = 5 }
samples = SPACE
[filter]
groups  = [ { axes = "xy", kernel = "gauss", sigma = 0.8 } ]
[optimizer]
method  = "anneal"
stop    = { iterations = 1 }
"""


class Densities(ProgramTest):
    def generate(self, config, output, *arguments):
        self.run_program("generate", config, "-o", output, "--overwrite", "--progress", "none", *arguments)
        with h5py.File(self.folder / output) as file:
            samples = numpy.moveaxis(file["samples"][...].astype(float), -1, 0).reshape(file["samples"].shape[-1], -1)
            return samples, (file["pdf"][...].astype(float).ravel() if "pdf" in file else None)

    def assert_mean(self, values, expected, what):
        error = values.std() / math.sqrt(len(values))
        self.assertLess(abs(values.mean() - expected), 4 * error, f"{what}: {values.mean()}, not {expected}")

    def test_means_over_the_density_are_integrals(self):
        for number, (space, (integrands, measure)) in enumerate(SPACES.items()):
            samples, pdf = self.generate(self.write(f"{number}.toml", CONFIG.replace("SPACE", space)), f"{number}.h5")
            found = integrands(samples)
            self.assertEqual(len(found), 10)
            for k, (values, integral) in enumerate(found):
                self.assert_mean(values / pdf, integral, f"{space}, integrand {k}")
            if measure is not None:
                self.assert_mean(1 / pdf, measure, f"{space}, 1 / pdf")

    def test_half_vectors_reflect_the_view_upwards_or_not_as_often_as_the_microsurface_does(self):
        """The share of reflections above the horizon, against a sum over a grid of the density that is written out here."""
        alpha, view = 0.5, math.radians(VIEW)
        samples, _ = self.generate(self.write("g.toml", CONFIG.replace("SPACE", list(SPACES)[-2])), "g.h5")
        v = numpy.array([math.sin(view), 0, math.cos(view)])
        self.assertGreater((v @ samples).min(), -1e-6)
        up = (2 * (v @ samples) * samples[2] - v[2] > 0).mean()
        cosines, turns = numpy.meshgrid((numpy.arange(2000) + 0.5) / 2000, (numpy.arange(2000) + 0.5) / 2000 * 2 * math.pi)
        sines = numpy.sqrt(1 - cosines ** 2)
        seen = numpy.maximum(0, v[0] * sines * numpy.cos(turns) + v[2] * cosines)
        slopes = (sines / alpha) ** 2 + cosines ** 2
        density = seen / (math.pi * alpha ** 2 * slopes ** 2)
        density /= density.sum()
        expected = density[2 * seen * cosines - v[2] > 0].sum()
        self.assertLess(abs(up - expected), 4 * math.sqrt(expected * (1 - expected) / samples.shape[1]) + 1e-3)

    def test_what_the_configs_make(self):
        for name, channels, has_density in (("lens-star", 2, False), ("ggx", 3, True)):
            small = ("--set", "texture.size={ x = 32, y = 31, t = 4 }", "--set", "optimizer.stop.iterations=100")
            samples, pdf = self.generate(SOURCE / f"configs/{name}.toml", f"{name}.h5", *small)
            self.assertEqual(samples.shape, (channels, 32 * 31 * 4))
            self.assertEqual(pdf is not None, has_density)
            scores = self.info(f"{name}.h5")["history"]["relative_error"]
            self.assertLess(scores[-1], 0.6)
            self.run_program("export", f"{name}.h5", "-o", name)
            self.assertEqual(len(list((self.folder / name).glob("*.png"))), 4)


if __name__ == "__main__":
    main()
