"""compare: the figures of score, means and errors over seeds, and whether slices hold the same samples."""

import csv
import io
import json
import unittest

import support

try:
    import h5py
    import numpy
except ImportError as missing:
    print(f"skipped: {missing}")
    raise SystemExit(77)

CONFIG = """
[texture]
size = { x = 13, y = 11, t = 3 }
samples = "%s"
seed = %d
[filter]
groups = [ { axes = "xy", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 20 }
method = "anneal"
"""


class CompareTest(support.ProgramTest):
    def generate(self, name, samples="uniform", seed=1, *arguments):
        self.run_program("generate", self.write(f"{name}.toml", CONFIG % (samples, seed)), "-o", f"{name}.h5", *arguments)

    def test_figures_are_those_of_score(self):
        for seed in (1, 2, 3):
            self.generate(f"a{seed}", seed=seed)
        self.generate("b", "uniform", 1, "--set", "filter.groups[0].size=5")
        own = [json.loads(self.run_program("score", f"a{seed}.h5", "--json").stdout)["relative_error"] for seed in (1, 2, 3)]
        done = json.loads(self.run_program("compare", "seeds=a1.h5,a2.h5,a3.h5", "b.h5", "--json").stdout)["textures"]
        self.assertEqual([texture["name"] for texture in done], ["seeds", "b"])
        found = done[0]["measures"]["R, box 3 over xy"]
        self.assertAlmostEqual(found["mean"], numpy.mean(own), places=12)
        self.assertAlmostEqual(found["standard_error"], numpy.std(own, ddof=1) / 3**0.5, places=12)
        other = json.loads(self.run_program("score", "b.h5", "--json", "--set", "filter.groups[0].size=3").stdout)
        self.assertAlmostEqual(done[1]["measures"]["R, box 3 over xy"]["mean"], other["relative_error"], places=12)
        self.assertEqual(done[1]["measures"]["R, box 3 over xy"]["standard_error"], 0)
        self.assertIn("every slice holds the same samples", done[1]["beside_the_first"])

    def test_tables(self):
        self.generate("a")
        self.generate("b", seed=2)
        rows = list(csv.reader(io.StringIO(self.run_program("compare", "a.h5", "b.h5", "--table", "csv").stdout)))
        self.assertEqual(rows[0], ["measure", "a", "a standard error", "b", "b standard error"])
        self.assertTrue(all(len(row) == 5 for row in rows))
        markdown = self.run_program("compare", "a.h5", "b.h5").stdout
        self.assertTrue(markdown.startswith("|  | a | b |\n|---|---:|---:|\n"), markdown)
        self.assertIn("b beside a: no slice holds the same samples", markdown)
        latex = self.run_program("compare", "x=a.h5,b.h5", "b.h5", "--table", "latex").stdout
        self.assertTrue(latex.startswith("\\begin{tabular}{lrr}"))
        self.assertIn("$\\pm$", latex)
        self.assertIn("x\\_1\\%", self.run_program("compare", "x_1%=a.h5", "b.h5", "--table", "latex").stdout)
        self.assertIn("| x\\|y |", self.run_program("compare", "x|y=a.h5", "b.h5").stdout)
        self.assertIn("| a.h5 | ./a.h5 |", self.run_program("compare", "a.h5", "./a.h5").stdout)
        for word in ("=a.h5", "x=a.h5,", "x="):
            self.assertIn("must be NAME=FILE", self.run_program("compare", word, "b.h5", expect=2).stderr)

    def test_what_is_no_comparison_is_refused(self):
        self.generate("a")
        self.generate("v", "vector2")
        self.assertIn("two textures", self.run_program("compare", "a.h5", expect=2).stderr)
        self.assertIn("no comparison", self.run_program("compare", "a.h5", "v.h5", expect=2).stderr)
        self.run_program("compare", "a.h5", "none.h5", expect=2)
        other = CONFIG.replace('"%s"', '{ space = "vector2", distance = "manhattan" }') % 1
        self.run_program("generate", self.write("m.toml", other), "-o", "m.h5")
        self.assertIn('"vector2 by manhattan"', self.run_program("compare", "v.h5", "m.h5", expect=2).stderr)
        self.assertIn("samples vector2 by manhattan", self.run_program("score", "m.h5").stdout)


if __name__ == "__main__":
    support.main()
