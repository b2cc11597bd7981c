"""Vectors that are constructed as scalars are, along a space-filling curve: the samples, their order, ranks and resume."""

import json

import h5py
import numpy

from support import ProgramTest, main

CONFIG = """
[texture]
size    = { x = 16, y = 16, t = 3 }
samples = "SAMPLES"
[filter]
groups  = [ { axes = "xy", kernel = "gauss", sigma = 0.9 }, { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 } ]
[optimizer]
curve   = "CURVE"
density = 0.2
"""
CELLS = 256


def cells_of(samples, side):
    return numpy.floor(samples.astype(float) * side).astype(int)


class CurveTest(ProgramTest):
    def generate(self, output, *arguments, samples="vector2", curve="hilbert", **options):
        config = self.write("run.toml", CONFIG.replace("SAMPLES", samples).replace("CURVE", curve))
        return self.run_program("generate", config, "-o", output, "--progress", "none", *arguments, **options)

    def read(self, name):
        with h5py.File(self.folder / name) as file:
            samples = file["samples"][...]
            return file["state/permutation"][...].reshape(3, -1), samples.reshape(3, CELLS, samples.shape[-1])

    def test_places_are_those_along_the_curve(self):
        for samples, side in (("vector2", 16), ("vector4", 4)):
            self.generate("run.h5", "--overwrite", samples=samples)
            for places, values in zip(*self.read("run.h5")):
                cells = cells_of(values, side)
                self.assertEqual(len(set(map(tuple, cells))), CELLS, "one sample in each stratum")
                steps = numpy.abs(numpy.diff(cells[numpy.argsort(places)], axis=0)).sum(axis=1)
                self.assertTrue((steps == 1).all(), "a Hilbert curve steps to a neighbour")

    def test_the_pixels_are_placed_as_those_of_scalars(self):
        self.generate("curve.h5")
        scalar = self.write("scalar.toml", CONFIG.replace("SAMPLES", "uniform").replace('curve   = "CURVE"', ""))
        self.run_program("generate", scalar, "-o", "scalar.h5", "--progress", "none")
        self.assertTrue(numpy.array_equal(self.read("curve.h5")[0], self.read("scalar.h5")[0]))

    def test_the_error_is_that_of_its_samples(self):
        errors = {}
        for curve in ("hilbert", "morton"):
            self.generate(f"{curve}.h5", curve=curve)
            scored = json.loads(self.run_program("score", f"{curve}.h5", "--json").stdout)["relative_error"]
            with h5py.File(self.folder / f"{curve}.h5") as file:
                self.assertAlmostEqual(file["state"].attrs["relative_error"], scored, delta=1e-9)
            errors[curve] = scored
        self.assertLess(errors["hilbert"], errors["morton"])
        self.assertLess(errors["morton"], 0.9)

    def test_stop_resume_and_ranks_give_the_same_bytes(self):
        small = ("--set", "texture.size={ x = 7, y = 5, t = 3 }")
        self.generate("straight.h5", *small, samples="vector3")
        for part in range(200):
            done = self.generate("parts.h5", *small, "--resume", "--time-limit", "0.000001s", samples="vector3", expect=None,
                                 ranks={1: 3, 4: 2}.get(part))
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, 75, done.stderr)
        self.assertEqual(done.returncode, 0)
        self.assertGreater(part, 5)
        self.assertEqual(self.info("parts.h5")["checksums"], self.info("straight.h5")["checksums"])

    def test_what_was_constructed_can_be_annealed(self):
        self.generate("constructed.h5")
        done = self.generate("annealed.h5", "--set", "optimizer.stop.iterations=200")
        before = sorted(map(tuple, self.read("constructed.h5")[1][0]))
        after = sorted(map(tuple, self.read("annealed.h5")[1][0]))
        self.assertEqual(before, after)
        errors = [json.loads(self.run_program("score", name, "--json").stdout)["relative_error"]
                  for name in ("constructed.h5", "annealed.h5")]
        self.assertLess(errors[1], errors[0], done.stdout)

    def test_plan_knows_it(self):
        config = self.write("run.toml", CONFIG.replace("SAMPLES", "vector2").replace("CURVE", "morton"))
        self.assertIn("construct", self.run_program("plan", config).stdout)


if __name__ == "__main__":
    main()
