"""R is R wherever it is shown: progress, the message at a stop and after it, info, the summary and score agree."""

import json
import re

from support import THOROUGH, ProgramTest, main

EMA = '{ axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 }'

# Classes of one slice and of several coupled ones, sums, tiles, features and all taps, both methods.
CONFIGS = {
    "classes of coupled slices": ("x = 24, y = 24, t = 17", "uniform", '"product"',
                                  '{ axes = "xy", kernel = "box", size = 3 }, ' + EMA, 900, ""),
    "directions": ("x = 16, y = 18, t = 9", "sphere", '"product"',
                   '{ axes = "xy", kernel = "box", size = 3 }, ' + EMA, 400, ""),
    "sum": ("x = 20, y = 16, t = 8", "vector2", '"sum"',
            '{ axes = "xy", kernel = "gauss", sigma = 1.0 }, { axes = "t", kernel = "box", size = 5 }', 600, ""),
    "tiles": ("x = 131, y = 97, t = 2", "circle", '"product"', '{ axes = "xy", kernel = "box", size = 3 }', 120, ""),
    "no spatial filter": ("x = 16, y = 16, t = 12", "uniform", '"product"', EMA, 600, ""),
    "fast": ("x = 24, y = 24, t = 9", "uniform", '"product"',
             '{ axes = "xy", kernel = "box", size = 3 }, ' + EMA, 600, 'method = "fast"'),
    "cut off": ("x = 24, y = 24, t = 9", "uniform", '"product"',
                '{ axes = "xy", kernel = "gauss", sigma = 1.0 }, ' + EMA, 600, "cutoff = 0.05"),
}


class ShownError(ProgramTest):
    def config(self, name):
        size, samples, combine, groups, iterations, more = CONFIGS[name]
        return self.write("run.toml", f"""
[texture]
size    = {{ {size} }}
samples = "{samples}"
[filter]
combine = {combine}
groups  = [ {groups} ]
[optimizer]
{"" if "method" in more else 'method = "anneal"'}
stop = {{ iterations = {iterations} }}
{more}
""")

    def score(self, run_file):
        return json.loads(self.run_program("score", run_file, "--json").stdout)["relative_error"]

    def expect_same(self, shown, exact, what):
        # Texts have five decimals.
        self.assertLessEqual(abs(shown - exact), 1e-3 * exact + 0.6e-5, f"{what}: {shown} for {exact}")

    def test_at_every_stop_and_at_the_end(self):
        for number, name in enumerate(CONFIGS):
            with self.subTest(name):
                config = self.config(name)
                on_ranks = ((2, "0.01s"), (3, "0.000001s"))
                if not THOROUGH:
                    on_ranks = on_ranks[number % 2:][:1]
                self.run_program("generate", config, "-o", "straight.h5", "--overwrite", "--progress", "none")
                straight = self.info("straight.h5")
                stops = 0
                for ranks, limit in ((None, "0.03s"), *on_ranks, (None, "1h")):
                    done = self.run_program("generate", config, "-o", "run.h5", "--resume", "--time-limit", limit,
                                            "--progress", "json", ranks=ranks, expect=None)
                    self.assertIn(done.returncode, (0, 75), done.stderr)
                    exact = self.score("run.h5")
                    self.assertAlmostEqual(self.info("run.h5")["state"]["relative_error"], exact, delta=1e-9 + 1e-6 * exact)
                    text = self.run_program("info", "run.h5").stdout
                    self.expect_same(float(re.search(r"\bR (\d\.\d+)", text).group(1)), exact, "info")
                    if done.returncode == 0:
                        self.expect_same(float(re.search(r"^R +(\d\.\d+)", done.stdout, re.M).group(1)), exact, "summary")
                        continue
                    stops += 1
                    stopped = re.search(r"stopped by .* at iteration \d+, R (\d\.\d+);", done.stderr)
                    self.assertTrue(stopped, done.stderr)
                    self.expect_same(float(stopped.group(1)), exact, "at the stop")
                    again = self.run_program("generate", config, "-o", "run.h5", "--resume", "--time-limit", "0.000001s",
                                             "--progress", "json", expect=None).stderr
                    resumed = re.search(r"resumed at iteration \d+, R (\d\.\d+)", again)
                    self.assertTrue(resumed, again)
                    self.expect_same(float(resumed.group(1)), exact, "after the stop")
                self.assertGreaterEqual(stops, 1, "the run was too short to be stopped")
                finished = self.info("run.h5")
                for column in ("iterations", "relative_error", "acceptance", "temperature"):
                    self.assertEqual(finished["history"][column], straight["history"][column])
                self.assertEqual(finished["checksums"]["/samples"], straight["checksums"]["/samples"])
                (self.folder / "run.h5").unlink()

    def test_progress_says_what_it_shows(self):
        config = self.config("classes of coupled slices")
        done = self.run_program("generate", config, "-o", "run.h5", "--progress", "json")
        lines = [json.loads(line) for line in done.stderr.splitlines()]
        shown = [line for line in lines if line["event"] == "progress"]
        history = self.info("run.h5")["history"]
        rows = dict(zip(history["iterations"], history["relative_error"]))
        self.assertGreaterEqual(len(rows), 20)
        for line in shown:
            self.assertLessEqual(line["scored_at"], line["iterations"])
            if line["scored_at"] in rows:
                self.assertAlmostEqual(line["relative_error"], rows[line["scored_at"]], delta=1e-6)

    def test_scores_that_cannot_be_reached_end(self):
        for size, words in (("x = 1, y = 1", "no swap"), ("x = 1, y = 1, t = 5", "no swap"), ("x = 16, y = 16", "reach")):
            config = self.write("far.toml", f"""
texture.size     = {{ {size} }}
texture.samples  = "uniform"
filter.groups    = [ {{ axes = "xy", kernel = "box", size = 3 }} ]
optimizer.method = "anneal"
optimizer.stop   = {{ score = 0.0001 }}
""")
            done = self.run_program("generate", config, "-o", "far.h5", "--overwrite", "--progress", "plain", timeout=100)
            self.assertIn(words, done.stdout)
            self.assertIn(words, self.run_program("info", "far.h5").stdout)


if __name__ == "__main__":
    main()
