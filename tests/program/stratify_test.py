"""Samples whose strata are spread over time as well: texture.stratify."""

import re

import numpy

from support import ProgramTest, main

CONFIG = """
[texture]
size     = { x = 16, y = 12, t = 8 }
samples  = "uniform"
stratify = "slice+time"
[filter]
groups   = [ { axes = "xy", kernel = "gauss", sigma = 1.0 } ]
[optimizer]
stop     = { iterations = 60 }
"""
COUPLED = CONFIG.replace("sigma = 1.0 } ]", 'sigma = 1.0 }, { axes = "t", kernel = "ema", alpha = 0.2, rejection = 0.1 } ]')
VECTORS = COUPLED.replace('"uniform"', '"vector2"')


class Stratify(ProgramTest):
    def generate(self, text, output, *arguments, **options):
        config = self.write("run.toml", text)
        return self.run_program("generate", config, "-o", output, "--progress", "none", *arguments, **options)

    def ids(self, name):
        import h5py

        with h5py.File(self.folder / name) as file:
            return file["state/permutation"][...], file["samples"][...]

    def expect_strata(self, ids, slices, cells):
        strata = ids.reshape(slices, cells) * slices // cells
        self.assertTrue((numpy.sort(strata, axis=0) == numpy.arange(slices)[:, None]).all())

    def test_every_pixel_visits_every_stratum_once(self):
        for text in (CONFIG, COUPLED, VECTORS, CONFIG.replace('"uniform"', '"sphere"'), CONFIG.replace('"uniform"', '"circle"'),
                     CONFIG.replace("t = 8", "t = 8, z = 2"), CONFIG.replace("t = 8", "z = 2, t = 8")):
            with self.subTest(text):
                self.generate(text, "run.h5", "--overwrite")
                ids, samples = self.ids("run.h5")
                stacks = ids.reshape(ids.shape[:-2] + (192,))
                if "z = 2" in text:
                    time = 1 if "t = 8, z" in text else 0  # slice axes are stored last named first
                    stacks = numpy.moveaxis(stacks, time, 1)
                else:
                    stacks = stacks[None]
                for stack in stacks:
                    self.expect_strata(stack, 8, 192)
                for slice in ids.reshape(-1, 192):
                    self.assertTrue((numpy.sort(slice) == numpy.arange(192)).all())
                if '"uniform"' in text and "z = 2" not in text:
                    values = numpy.sort(samples.reshape(8, 192), axis=0)
                    self.assertTrue((numpy.floor(values * 8) == numpy.arange(8)[:, None]).all())

    def test_means_over_all_frames_converge_as_stratified_samples_do(self):
        self.generate(CONFIG, "strata.h5")
        self.generate(CONFIG.replace("slice+time", "slice"), "plain.h5")

        def error(name):
            values = self.ids(name)[1].reshape(8, 192)
            thresholds = (numpy.arange(40) + 0.5) / 40
            means = (values[:, :, None] < thresholds).mean(axis=0)
            return ((means - thresholds) ** 2).mean()

        white = ((numpy.arange(40) + 0.5) / 40 * (1 - (numpy.arange(40) + 0.5) / 40)).mean() / 8
        self.assertLess(error("strata.h5"), 0.2 * white)  # 1 / 8 by theory
        self.assertGreater(error("plain.h5"), 0.7 * white)

    def test_same_bytes_on_any_ranks_threads_and_interruptions(self):
        for text in (COUPLED, VECTORS):
            text = text.replace("= 60", "= 3")
            self.generate(text, "one.h5", "--overwrite", "--threads", 1)
            expected = self.info("one.h5")["checksums"]
            self.assertGreater(max(self.info("one.h5")["history"]["acceptance"]), 0)
            self.generate(text, "many.h5", "--overwrite", "--threads", 2, ranks=3)
            self.assertEqual(self.info("many.h5")["checksums"], expected)
            (self.folder / "parts.h5").unlink(missing_ok=True)
            for part in range(100):
                done = self.generate(text, "parts.h5", "--resume", "--time-limit", "0.000001s", expect=None, ranks={1: 3}.get(part))
                if done.returncode == 0:
                    break
                self.assertEqual(done.returncode, 75, done.stderr)
            self.assertEqual(done.returncode, 0)
            self.assertGreater(part, 1)
            self.assertEqual(self.info("parts.h5")["checksums"], expected)

    def test_plan_names_it(self):
        config = self.write("run.toml", CONFIG)
        self.assertRegex(self.run_program("plan", config).stdout, "strata over time: on")

    def test_refused(self):
        for change, fault in (
            (("t = 8", "t = 7"), "t must divide the 192 pixels of a slice, but is 7; the nearest that do are 6 and 8"),
            (("t = 8", "t = 400"), "the longest that does is 192"),
            (("t = 8", "z = 8"), "needs a slice axis named t"),
            (("stop ", 'method = "fast"\nstop '), 'is for method = "auto" and "anneal"'),
            (("stop ", 'method = "construct"\nstop '), 'is for method = "auto" and "anneal"'),
            (("slice+time", "time"), 'did you mean "slice\\+time"'),
            (('x = 16, y = 12, t = 8 }\nsamples  = "uniform"', 'x = 16, y = 16, t = 8 }\nsamples  = "sobol-owen"'), "does not go with the nets"),
        ):
            with self.subTest(change):
                self.assertIn(change[0], CONFIG)
                done = self.generate(CONFIG.replace(*change), "run.h5", expect=2)
                self.assertRegex(done.stderr, fault)
                self.assertFalse((self.folder / "run.h5").exists())


if __name__ == "__main__":
    main()
