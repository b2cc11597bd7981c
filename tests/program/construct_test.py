"""Construction as a whole program: what the run file holds, kill and resume in every phase, other tools on it."""

import json
import re
import signal

import numpy

from support import KILLER, THOROUGH, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 12, y = 7, t = 5 }
samples = "uniform"
[filter]
groups  = [ { axes = "xy", kernel = "gauss", sigma = 0.9 }, { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 } ]
[optimizer]
method  = "construct"
density = 0.2
"""
CIRCLE = CONFIG.replace('"uniform"', '"circle"').replace("density = 0.2\n", "").replace("x = 12", "x = 13")
CELLS = 12 * 7
PIXELS = CELLS * 5
POINTS = 16  # floor(0.2 * CELLS)
UNPLACED = 0xFFFFFFFE


class Construct(ProgramTest):
    def setUp(self):
        super().setUp()
        self.config = self.write("run.toml", CONFIG)

    def generate(self, output, *arguments, config=None, **options):
        return self.run_program("generate", config or self.config, "-o", output, "--progress", "none", *arguments, **options)

    def read(self, name):
        import h5py

        with h5py.File(self.folder / name) as file:
            return file["state/permutation"][...], file["samples"][..., 0], dict(file["state"].attrs)

    def test_run_file(self):
        done = self.generate("run.h5")
        places, samples, state = self.read("run.h5")
        for slice_places, slice_samples in zip(places, samples):
            order = slice_places.ravel()
            self.assertTrue(numpy.array_equal(numpy.sort(order), numpy.arange(CELLS)))
            by_place = slice_samples.ravel()[numpy.argsort(order)]
            self.assertTrue(numpy.array_equal(numpy.floor(by_place * CELLS), numpy.arange(CELLS)))  # one in each stratum
        self.assertEqual((state["phase"], state["finished"], state["start_points"]), (b"done", b"construction", POINTS))
        history = self.info("run.h5")["history"]
        self.assertEqual((history["ranked"][-1], history["phase"][-1]), (PIXELS, 5))
        self.assertEqual(len(history["seconds"]), len(history["ranked"]))

        shown = float(re.search(r"^R +(\S+)", done.stdout, re.M)[1])
        scored = json.loads(self.run_program("score", "run.h5", "--json").stdout)["relative_error"]
        told = float(re.search(r"^R (\S+)", self.run_program("info", "run.h5").stdout, re.M)[1])
        for figure in (shown, told):
            self.assertLess(abs(figure / scored - 1), 1e-3)
        self.assertAlmostEqual(state["relative_error"], scored, delta=1e-9)

    def test_only_the_arrangement_is_new(self):
        """The samples of every slice are those that annealing has, ties and all: of a space, of a density, of a file."""
        numpy.save(self.folder / "two.npy", numpy.array([0.25, 0.75] * (CELLS // 2), dtype=numpy.float32))
        numpy.save(self.folder / "own.npy", numpy.linspace(-3, 5, PIXELS).reshape(5, CELLS)[:, ::-1].copy())
        for samples in ('"uniform"', '"tent"', '"gauss"', '{ file = "two.npy" }', '{ file = "own.npy" }'):
            with self.subTest(samples):
                text = CONFIG.replace('"uniform"', samples)
                self.generate("construct.h5", "--overwrite", config=self.write("a.toml", text))
                annealed = re.sub(r'method .*\ndensity .*', 'method = "anneal"\nstop = { iterations = 3 }', text)
                self.generate("anneal.h5", "--overwrite", config=self.write("b.toml", annealed))
                constructed, expected = self.read("construct.h5")[1], self.read("anneal.h5")[1]
                self.assertFalse(numpy.array_equal(constructed, expected))
                sort = lambda values: numpy.sort(values.reshape(5, CELLS), axis=1)
                self.assertTrue(numpy.array_equal(sort(constructed), sort(expected)))

    def test_two_values_a_lonely_one_and_equal_ones(self):
        """Where values tie, places still decide; equal ones have no error to reduce, which score says."""
        lists = {"two": [0.25, 0.75] * (CELLS // 2), "lonely": [0.25] * (CELLS - 1) + [0.75], "equal": [0.25] * CELLS}
        for name, values in lists.items():
            with self.subTest(name):
                numpy.save(self.folder / "list.npy", numpy.array(values, dtype=numpy.float32))
                text = CONFIG.replace('"uniform"', '{ file = "list.npy" }')
                self.generate("run.h5", "--overwrite", config=self.write("a.toml", text))
                places, samples, state = self.read("run.h5")
                for slice_places, slice_samples in zip(places, samples):
                    self.assertTrue(numpy.array_equal(numpy.sort(slice_places.ravel()), numpy.arange(CELLS)))
                    self.assertTrue(numpy.array_equal(numpy.sort(slice_samples.ravel()), numpy.sort(numpy.float32(values))))
                if name == "equal":
                    self.assertEqual(state["relative_error"], 1)
                    self.assertIn("all values of the texture are equal", self.run_program("score", "run.h5", expect=2).stderr)
                    continue
                scored = json.loads(self.run_program("score", "run.h5", "--json").stdout)["relative_error"]
                self.assertAlmostEqual(state["relative_error"], scored, delta=1e-9)
                self.assertLess(scored, 0.2 if name == "two" else 0.9)

    def test_what_it_cannot_do_is_refused(self):
        numpy.save(self.folder / "one.npy", numpy.random.default_rng(1).random(CELLS, dtype=numpy.float32))
        numpy.save(self.folder / "pairs.npy", numpy.random.default_rng(1).random((CELLS, 2), dtype=numpy.float32))
        for change, words in ((('"uniform"', '"vector2"'), "texture.samples"), (('"uniform"', '"circle"'), "optimizer.density"),
                              (('"uniform"', '{ file = "one.npy", distance = "circle" }'), "texture.samples"),
                              (('"uniform"', '{ file = "pairs.npy" }'), "2 channels"),
                              (("density = 0.2", "fraction = 0.5"), "optimizer.fraction"),
                              (("density = 0.2", 'start = { file = "a.npy" }'), "optimizer.start"),
                              (("density = 0.2", "sharpness = 0"), "optimizer.sharpness"),
                              (("density = 0.2", "density = 0.6"), "optimizer.density"),
                              (("[optimizer]", '[energy]\nvalue_kernel = "stbn"\n[optimizer]'), "energy.value_kernel")):
            with self.subTest(change):
                self.assertIn(change[0], CONFIG)
                config = self.write("bad.toml", CONFIG.replace(*change))
                refused = self.generate("bad.h5", config=config, expect=2)
                self.assertIn(words, refused.stderr)
                self.assertFalse((self.folder / "bad.h5").exists())

    def test_plan_and_progress(self):
        plan = self.run_program("plan", self.config, "--ranks", 3).stdout
        for words in ("method     construct", "sharpening: on (power 1.", "rank    2", "memory", "time"):
            self.assertIn(words, plan)
        figures = json.loads(self.run_program("plan", self.config, "--json").stdout)
        self.assertEqual((figures["method"], figures["pixels"]), ("construct", PIXELS))
        given = self.run_program("plan", self.config, "--set", "optimizer.sharpness=1").stdout
        self.assertIn("sharpening: off (power 1 in space: as the config says)", given)
        done = self.run_program("generate", self.config, "-o", "run.h5", "--progress", "json")
        lines = [json.loads(line) for line in done.stderr.splitlines()]
        figures = [line for line in lines if "phase" in line]
        self.assertEqual((figures[-1]["phase"], figures[-1]["ranked"]), ("done", PIXELS))
        self.assertTrue(all(0 <= line["fraction"] <= 1 for line in figures))

    def test_other_commands_read_it(self):
        self.generate("run.h5", "--set", "texture.samples=tent")
        self.assertIn("/pdf", self.info("run.h5")["checksums"])
        self.run_program("export", "run.h5", "-o", "images")
        self.run_program("analyze", "run.h5", "-o", "report")
        self.assertTrue((self.folder / "report" / "report.html").exists())

    def test_score_on_ranks_counts_slices_that_construction_leaves_out(self):
        """A steep average over many slices: pairs far apart weigh too little to place by, but R counts them."""
        config = self.write("steep.toml", CONFIG.replace("t = 5", "t = 24").replace("alpha = 0.1", "alpha = 0.9"))
        states = []
        for ranks in (None, 4, 9, 24) if THOROUGH else (None, 4):
            self.generate("run.h5", "--overwrite", config=config, ranks=ranks)
            places, samples, state = self.read("run.h5")
            states.append((samples.tobytes(), state["relative_error"]))
        for state in states[1:]:
            self.assertEqual(state, states[0])

    def test_stop_and_resume_in_every_phase(self):
        self.stop_and_resume(CONFIG, {"relax", "drain", "fill", "done"})

    def test_stop_and_resume_in_every_phase_on_a_circle(self):
        self.stop_and_resume(CIRCLE, {"spread", "relax", "exchange", "done"})

    def stop_and_resume(self, text, expected_phases):
        config = self.write("small.toml", re.sub("x = [0-9]+, y = 7", "x = 9, y = 5", text))  # a part is one pick in each slice
        self.generate("straight.h5", config=config)
        expected = self.info("straight.h5")["checksums"]
        phases = set()
        for part in range(200):
            done = self.generate("parts.h5", "--resume", "--time-limit", "0.000001s", expect=None, config=config,
                                 ranks={1: 3, 4: 2, 20: 7}.get(part))
            places, samples, state = self.read("parts.h5")
            phases.add(state["phase"].decode())
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, 75, done.stderr)
            self.assertEqual(numpy.count_nonzero(~numpy.isnan(samples)), state["ranked"])
            self.assertEqual(numpy.count_nonzero(places < UNPLACED), state["ranked"])
            for command in (("score", "parts.h5"), ("export", "parts.h5", "-o", "images"))[: 2 if part == 2 else 0]:
                self.assertIn("not finished", self.run_program(*command, expect=2).stderr)
        self.assertEqual(phases, expected_phases)
        self.assertGreater(part, 20, "parts of all these numbers of ranks")
        self.assertEqual(self.info("parts.h5")["checksums"], expected)
        history = self.info("parts.h5")["history"]
        self.assertEqual([history[column] for column in ("phase", "swaps", "ranked")],
                         [self.info("straight.h5")["history"][column] for column in ("phase", "swaps", "ranked")])

    def test_a_circle_is_the_same_on_any_ranks_and_threads(self):
        config = self.write("circle.toml", CIRCLE)
        done = self.generate("one.h5", config=config)
        places, samples, state = self.read("one.h5")
        self.assertEqual((state["start_points"], state["ranked"]), (13 * 7 // 2, 13 * 7 * 5))
        for slice_places in places:
            self.assertTrue(numpy.array_equal(numpy.sort(slice_places.ravel()), numpy.arange(13 * 7)))
        scored = json.loads(self.run_program("score", "one.h5", "--json").stdout)["relative_error"]
        self.assertAlmostEqual(state["relative_error"], scored, delta=1e-9)
        self.assertIn("sharpness", done.stdout)
        for ranks, threads in ((1, 3), (2, 1), (3, 2), (5, 1)) if THOROUGH else ((3, 2),):
            self.generate("many.h5", "--overwrite", "--threads", threads, config=config, ranks=ranks)
            self.assertEqual(self.info("many.h5")["checksums"], self.info("one.h5")["checksums"], (ranks, threads))
        plan = self.run_program("plan", config).stdout
        for words in ("sharpening: on (power ", "start pattern: on (half of the pixels"):
            self.assertIn(words, plan)
        for change, words in (("state.phase=fill", "no such phase"), ("state.start_points=44", "start_points")):
            self.rewrite("one.h5", "changed.h5", change)
            self.assertIn(words, self.run_program("info", "changed.h5", expect=2).stderr)

    def test_kill_in_every_phase(self):
        self.generate("straight.h5")
        expected = self.info("straight.h5")["checksums"]
        phases = set()
        killed = 0
        at = 25
        while True:
            done = self.generate("out.h5", "--resume", "--checkpoint-every", "0.000001s", expect=None,
                                 environment={"LD_PRELOAD": KILLER, "KILL_AT": str(at), "KILL_PART": self.folder.name})
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
            killed += 1
            at += 9 if killed % 2 else -2
            existing = [name for name in ("out.h5", "out.h5.prev") if (self.folder / name).exists()]
            if existing:
                phases.add(self.read(existing[0])[2]["phase"].decode())
            self.assertLess(killed, 150)
        self.assertIn("fill", phases)
        self.assertGreater(killed, 3)
        self.assertEqual(self.info("out.h5")["checksums"], expected)

    def test_contents_that_no_run_has_are_refused(self):
        for part in range(30):
            self.generate("half.h5", "--resume", "--time-limit", "0.000001s", expect=75)
            if self.read("half.h5")[2]["phase"] == b"fill":
                break
        for changes, words in ((["state.phase=lunch"], "lunch"), (["state.phase=drain"], "/history/phase"),
                               (["state.start_points=15"], "start_points"), (["state.ranked=-5"], "ranked"),
                               (["state.ranked=101"], "ranked"), (["state.sharpness=nan"], "sharpness"),
                               (["state.finished=construction"], "finished"), (["state.rounds=-1"], "rounds"),
                               (["state.relative_error=nan"], "relative_error"), (["state.algorithm=0"], "algorithm"),
                               (["/state/permutation[2][3]=5000"], "slice 2"),
                               (["/state/permutation[4][0]=1", "/state/permutation[4][1]=1"], "slice 4"),
                               (["history.ranked[0]=nan"], "/history/ranked, row 0"), (["-state.swaps"], "swaps"),
                               (["config:method = \"construct\"=>method = \"anneal\""], "")):
            with self.subTest(changes):
                self.rewrite("half.h5", "changed.h5", *changes)
                for command in (("info", "changed.h5"), ("generate", self.config, "-o", "changed.h5", "--resume")):
                    refused = self.run_program(*command, expect=2)
                    self.assertIn(words, refused.stderr)
        self.rewrite("half.h5", "changed.h5", "state.algorithm=99")
        refused = self.generate("changed.h5", "--resume", expect=2)
        self.assertIn("begun with algorithm 99 of construct", refused.stderr)


if __name__ == "__main__":
    main()
