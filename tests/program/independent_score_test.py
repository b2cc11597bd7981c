"""The independent scorer and the program's own score agree, and both with the published figures."""

import json
import os
import pathlib
import subprocess
import sys

import numpy as np
from PIL import Image

import support

BENCH = support.SOURCE / "tests" / "bench"
sys.path.insert(0, str(BENCH))
import independent_score  # noqa: E402
PUBLISHED = pathlib.Path(os.environ.get("NOISELOOM_PUBLISHED", support.SOURCE / ".." / "shared" / "published"))


class IndependentScoreTest(support.ProgramTest):
    def independent(self, *arguments):
        done = subprocess.run([sys.executable, "-B", BENCH / "independent_score.py", "--json", *map(str, arguments)],
                              capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)["relative_error"]

    def test_published_single_slices_have_the_known_scores(self):
        if not PUBLISHED.is_dir():
            self.skipTest("the published textures are not there (NOISELOOM_PUBLISHED names their folder)")
        for name, space, kernel, expected in [("real_uniform_box_5", "scalar", "box:5", 0.1110),
                                              ("real_uniform_gauss_1.0", "scalar", "gauss:1.0", 0.1221),
                                              ("vector2_uniform_gauss_1.0", "vector2", "gauss:1.0", 0.2263),
                                              ("sphere_cosine_box_5", "sphere", "box:5", 0.3150)]:
            with self.subTest(name):
                r = self.independent(PUBLISHED / f"{name}.png", "--space", space, "--filter", f"xy:{kernel}")
                self.assertAlmostEqual(r, expected, delta=5.1e-5)

    def test_agrees_with_the_program_for_every_space_and_kernel(self):
        cases = [("uniform", "scalar", [("xy", "binomial", {"n": 3}), ("t", "ema", {"alpha": 0.2, "rejection": 0.3})], "product"),
                 ("circle", "circle", [("xy", "gauss", {"sigma": 0.7}), ("t", "ema", {"alpha": 0.3, "rejection": 0})], "sum"),
                 ("vector2", "vector2", [("xy", "box", {"size": 3}), ("t", "gauss", {"sigma": 1.5})], "sum"),
                 ("vector4", "vector4", [("xyt", "box", {"size": 2})], "product"),
                 ("hemisphere-cosine", "sphere", [("x", "box", {"size": 19}), ("y", "binomial", {"n": 1})], "product"),
                 ("sphere", "sphere", [("xy", "gauss", {"sigma": 1}), ("t", "ema", {"alpha": 1, "rejection": 1})], "product")]
        for samples, space, groups, combine in cases:
            with self.subTest(samples=samples, groups=groups):
                listed = ", ".join(f'{{ axes = "{axes}", kernel = "{kernel}", '
                                   + ", ".join(f"{key} = {value}" for key, value in keys.items()) + " }"
                                   for axes, kernel, keys in groups)
                config = self.write("c.toml", f'[texture]\nsize = {{ x = 13, y = 16, t = 5 }}\nsamples = "{samples}"\n'
                                    f'[filter]\ncombine = "{combine}"\ngroups = [ {listed} ]\n'
                                    "[optimizer]\nstop = { iterations = 4 }\n")
                self.run_program("generate", config, "-o", "c.h5", "--overwrite")
                self.run_program("export", "c.h5", "-o", "c.png", "--layout", "strip", "--overwrite")
                own = self.run_program("score", "c.png", "--config", config, "--json").stdout
                filters = [f"--filter={axes}:{kernel}:{','.join(map(str, keys.values()))}" for axes, kernel, keys in groups]
                r = self.independent(self.folder / "c.png", "--slices", 5, "--space", space, "--combine", combine, *filters)
                self.assertAlmostEqual(r, json.loads(own)["relative_error"], delta=2e-5)

    # The one thing that the independent scorer does not take from all pairs.
    def test_mean_distance_from_few_pairs_of_slices_is_that_of_all(self):
        config = self.write("c.toml", '[texture]\nsize = { x = 64, y = 64, t = 4 }\nsamples = "hemisphere-cosine"\n[filter]\n'
                            'groups = [ { axes = "xy", kernel = "box", size = 3 } ]\n[optimizer]\nstop = { iterations = 1 }\n')
        self.run_program("generate", config, "-o", "c.h5")
        self.run_program("export", "c.h5", "-o", "c.png", "--layout", "strip")
        with Image.open(self.folder / "c.png") as image:
            values = independent_score.decode([np.asarray(image)], "sphere", slices=4)
        exact = independent_score.mean_distance("sphere", values)
        self.assertAlmostEqual(independent_score.mean_distance("sphere", values, largest_exact=0) / exact, 1, delta=2e-6)

    def test_quality_table_keeps_what_it_has_measured(self):
        command = [sys.executable, "-B", BENCH / "quality_table.py", support.BIN, "-o", self.folder / "table", "--seconds", "0.1",
                   "--only", "^circle 128x128x1 box 3$", "--fast-iterations", "1"]
        first = subprocess.run(command, capture_output=True, text=True, timeout=300)
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertEqual(len(first.stderr.splitlines()), 2)
        self.assertIn("| circle 128x128x1 box 3 | - | ", first.stdout)
        again = subprocess.run(command, capture_output=True, text=True, timeout=300)
        self.assertEqual((again.stdout, again.stderr), (first.stdout, ""))


if __name__ == "__main__":
    support.main()
