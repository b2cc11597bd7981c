"""A run that has come to its end, gone on with to a later one: the bytes of a run that had that end from its start."""

from support import ProgramTest, main

CONFIG = """
[texture]
size    = { x = 16, y = 13, t = 3 }
[filter]
groups  = [ { axes = "xy", kernel = "gauss", sigma = 0.8 } ]
[optimizer]
"""


class Extension(ProgramTest):
    def generate(self, output, stop, *arguments, method="anneal", **options):
        config = self.write("run.toml", CONFIG + f'method = "{method}"\nstop = {{ {stop} }}\n')
        return self.run_program("generate", config, "-o", output, "--progress", "plain", *arguments, **options)

    def assert_same_history(self, one, other):
        """But for the clock; and R at the earlier end was found in double precision, in the straight run in single."""
        for column in ("sweep", "iterations", "temperature", "acceptance"):
            self.assertEqual(one["history"][column], other["history"][column], column)
        for a, b in zip(one["history"]["relative_error"], other["history"]["relative_error"]):
            self.assertAlmostEqual(a, b, delta=1e-4 * b)

    def extended(self, first, second, **options):
        """Checks that a run to `first` and on to `second` is one to `second`, and returns how far each went."""
        self.generate("straight.h5", second, "--overwrite", **options)
        self.generate("run.h5", first, "--overwrite", **options)
        before = self.info("run.h5")
        self.generate("run.h5", second, "--resume", ranks=2, **options)
        after = self.info("run.h5")
        self.assertEqual(after["checksums"]["/samples"], self.samples_checksum("straight.h5"))
        straight = self.info("straight.h5")
        self.assertEqual(after["state"]["finished"], straight["state"]["finished"])
        self.assert_same_history(after, straight)
        self.assertIn(second, after["config"].replace('"', ""))
        return before["state"]["sweep"], after["state"]["sweep"]

    def test_a_lower_score(self):
        before, after = self.extended("score = 0.4", "score = 0.25")
        self.assertLess(before, after)

    def test_a_lower_score_that_is_reached_already(self):
        self.generate("run.h5", "score = 0.5")
        reached = self.info("run.h5")["history"]["relative_error"][-1]
        before = self.samples_checksum("run.h5")
        self.generate("run.h5", f"score = {(0.5 + reached) / 2}", "--resume")
        self.assertEqual(self.samples_checksum("run.h5"), before)
        self.assertEqual(self.info("run.h5")["state"]["finished"], "score")

    def test_a_smaller_improvement(self):
        before, after = self.extended("improvement = 0.9", "improvement = 0.02")
        self.assertLess(before, after)

    def test_more_iterations_of_the_published_algorithm(self):
        for first, second in ((20, 150), (1, 2), (37, 150), (149, 150)):
            before, after = self.extended(f"iterations = {first}", f"iterations = {second}", method="fast")
            self.assertEqual((before, after), (first, second))

    def test_a_run_that_was_stopped_may_be_extended_too(self):
        self.generate("straight.h5", "score = 0.25")
        self.generate("run.h5", "score = 0.3", "--time-limit", "0.000001s", expect=75)
        self.generate("run.h5", "score = 0.25", "--resume")
        self.assertEqual(self.samples_checksum("run.h5"), self.samples_checksum("straight.h5"))

    def refused(self, first, second, words, **options):
        self.generate("run.h5", first, "--overwrite", **options)
        before = self.samples_checksum("run.h5")
        done = self.generate("run.h5", second, "--resume", expect=2, **options)
        self.assertIn("optimizer.stop", done.stderr)
        self.assertIn(words, done.stderr)
        self.assertEqual(self.samples_checksum("run.h5"), before)

    def test_what_depends_on_its_end_is_refused_with_the_reason(self):
        self.refused("iterations = 30", "iterations = 60", "cools from the first iteration to the last")
        self.refused("iterations = 30", "iterations = 20", "not shortened")
        self.refused("score = 0.4", "score = 0.5", "not shortened")
        self.refused("improvement = 0.5", "improvement = 0.6", "not shortened")
        self.refused("iterations = 30", "score = 0.4", "the rule itself")
        self.refused('time = "0.1s"', 'time = "0.2s"', "follows the clock")
        self.refused("iterations = 150", "iterations = 30000", "grows once in 100 sweeps of the one and in 300 of the other",
                     method="fast")

    def test_a_cutoff_that_says_what_is_so_anyway(self):
        """Older files say `cutoff = 0.0` where the config said nothing."""
        for method, same, other in (("fast", "0", "0.001"), ("anneal", "0.001", "0")):
            said = ("--set", f"optimizer.cutoff={same}")
            self.generate("run.h5", "iterations = 30", *said, "--overwrite", method=method)
            self.generate("run.h5", "iterations = 30", "--resume", method=method)
            done = self.generate("run.h5", "iterations = 30", "--resume", "--set", f"optimizer.cutoff={other}",
                                 method=method, expect=2)
            self.assertIn("optimizer.cutoff: ", done.stderr)
        config = self.write("constructed.toml", CONFIG.replace("[optimizer]", ""))
        self.run_program("generate", config, "-o", "constructed.h5", "--set", "optimizer.cutoff=0")
        self.run_program("generate", config, "-o", "constructed.h5", "--resume", "--set", "optimizer.stop.iterations=30")

    def test_other_differences_are_still_refused(self):
        self.generate("run.h5", "score = 0.4")
        done = self.generate("run.h5", "score = 0.3", "--resume", "--set", "texture.seed=2", expect=2)
        self.assertIn("texture.seed: 1 in the file, 2 here", done.stderr)


if __name__ == "__main__":
    main()
