"""Method auto, construction that is annealed, and annealing from an arrangement of the user's."""

import re
import signal
import time

import numpy

from support import KILLER, THOROUGH, ProgramTest, main

SCALARS = """
[texture]
size    = { x = 24, y = 17, t = 5 }
samples = "uniform"
[filter]
groups  = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "ema", alpha = 0.3, rejection = 0.1 } ]
[optimizer]
"""
# A construction that annealing goes on from in the cold, one that it joins, and one that it begins anew.
COLD = SCALARS.replace('kernel = "box", size = 3', 'kernel = "gauss", sigma = 1.0') + "stop = { iterations = 40 }\n"
JOINED = COLD.replace("{ x = 24, y = 17, t = 5 }", "{ x = 32, y = 31 }").replace(", { axes = \"t\", kernel = \"ema\", alpha = 0.3, rejection = 0.1 }", "") \
             .replace("sigma = 1.0", "sigma = 0.7").replace("= 40", "= 3000")


class Auto(ProgramTest):
    def generate(self, text, output, *arguments, **options):
        config = self.write("run.toml", text)
        return self.run_program("generate", config, "-o", output, "--progress", "none", *arguments, **options)

    def read(self, name):
        import h5py

        with h5py.File(self.folder / name) as file:
            return file["samples"][...], dict(file["state"].attrs)

    def stored_method(self, name):
        return re.search(r'^method = "(.*)"', self.info(name)["config"], re.M)[1]

    def test_what_it_stands_for(self):
        self.generate(SCALARS, "auto.h5")
        self.generate(SCALARS + 'method = "construct"\n', "construct.h5")
        self.assertEqual(self.info("auto.h5")["checksums"], self.info("construct.h5")["checksums"])
        vectors = SCALARS.replace('"uniform"', '"vector2"') + "stop = { iterations = 30 }\n"
        self.generate(vectors, "vectors.h5")
        self.assertEqual(self.stored_method("vectors.h5"), "anneal")
        rng = numpy.random.default_rng(1)
        for channels, method in ((1, "construct"), (2, "anneal")):
            numpy.save(self.folder / "list.npy", rng.random((24 * 17, channels), dtype=numpy.float32))
            text = SCALARS.replace('"uniform"', '{ file = "list.npy" }') + "stop = { iterations = 30 }\n"
            name = f"list{channels}.h5"
            self.generate(text, name, "--time-limit", "0.000001s", expect=75)
            self.assertEqual(self.stored_method(name), method)
            self.generate(text, "straight.h5", "--overwrite")
            (self.folder / "list.npy").unlink()  # what the run was made from is in its file
            self.generate(text, name, "--resume")
            self.assertEqual(self.samples_checksum(name), self.samples_checksum("straight.h5"))
            self.assertEqual(self.stored_method(name), method)

    def test_annealing_only_rearranges_and_never_makes_it_worse(self):
        for text in (COLD, JOINED):
            with self.subTest(text):
                done = self.generate(text, "annealed.h5", "--overwrite")
                self.generate(re.sub("stop.*", "", text), "constructed.h5", "--overwrite")
                (annealed, state), (constructed, before) = self.read("annealed.h5"), self.read("constructed.h5")
                slices = -1, 24 * 17 if annealed.ndim == 4 else 32 * 31
                self.assertTrue(numpy.array_equal(numpy.sort(annealed.reshape(slices)), numpy.sort(constructed.reshape(slices))))
                self.assertFalse(numpy.array_equal(annealed, constructed))
                self.assertLess(state["relative_error"], 0.999 * before["relative_error"])
                self.assertAlmostEqual(state["given_error"], before["relative_error"], delta=1e-12)
                shown = re.search(r"^R +(\S+) .*before (\S+)\)", done.stdout, re.M)
                self.assertAlmostEqual(float(shown[1]), state["relative_error"], delta=1e-5)
                self.assertAlmostEqual(float(shown[2]), before["relative_error"], delta=1e-5)
                self.assertEqual(bool(state["is_cold"]), text is COLD)
        hot = COLD.replace("stop", "temperature = { start = 9, end = 5 }\nstop")
        self.assertIn("which annealing did not improve", self.generate(hot, "hot.h5").stdout)
        self.generate(re.sub("stop.*", "", COLD), "constructed.h5", "--overwrite")
        self.assertEqual(self.samples_checksum("hot.h5"), self.samples_checksum("constructed.h5"))
        self.assertEqual(self.read("hot.h5")[1]["relative_error"], self.read("constructed.h5")[1]["relative_error"])

    def test_same_bytes_on_any_ranks_and_threads(self):
        for text in (COLD, JOINED):
            self.generate(text, "one.h5", "--overwrite", "--threads", 1)
            expected = self.info("one.h5")["checksums"]
            for ranks, threads in ((1, 3), (2, 1), (3, 2), (5, 1)) if THOROUGH else ((3, 2),):
                self.generate(text, "many.h5", "--overwrite", "--threads", threads, ranks=ranks)
                self.assertEqual(self.info("many.h5")["checksums"], expected, (ranks, threads))

    def test_stop_and_resume_in_every_part(self):
        small = COLD.replace("x = 24, y = 17", "x = 8, y = 5").replace("= 40", "= 4")
        self.generate(small, "straight.h5")
        expected = self.info("straight.h5")
        parts = []
        for part in range(300):
            done = self.generate(small, "parts.h5", "--resume", "--time-limit", "0.000001s", expect=None,
                                 ranks={1: 3, 4: 2, 30: 7, 45: 3}.get(part))
            parts.append(self.state("parts.h5").get("phase", "anneal"))
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, 75, done.stderr)
        self.assertEqual(list(dict.fromkeys(parts)), ["relax", "drain", "fill", "done", "anneal"])
        self.assertGreater(parts.count("anneal"), 10)
        self.assertGreater(len(parts), 46, "parts of all these numbers of ranks")
        self.assertEqual(self.info("parts.h5")["checksums"], expected["checksums"])
        for column in ("sweep", "temperature", "relative_error"):
            self.assertEqual(self.info("parts.h5")["history"][column], expected["history"][column])

    def test_kill_while_annealing(self):
        self.generate(COLD, "straight.h5")
        expected = self.info("straight.h5")["checksums"]
        killed = 0
        at = 60
        while True:
            done = self.generate(COLD, "out.h5", "--resume", "--checkpoint-every", "0.000001s", expect=None,
                                 environment={"LD_PRELOAD": KILLER, "KILL_AT": str(at), "KILL_PART": self.folder.name})
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
            killed += 1
            at += 37
            self.assertLess(killed, 100)
        self.assertGreater(killed, 3)
        self.assertEqual(self.info("out.h5")["checksums"], expected)

    def test_a_finished_construction_may_be_annealed_later(self):
        self.generate(COLD, "straight.h5")
        self.generate(re.sub("stop.*", "", COLD), "later.h5")
        self.generate(COLD, "later.h5", "--resume", ranks=2)
        self.assertEqual(self.info("later.h5")["checksums"], self.info("straight.h5")["checksums"])
        refused = self.generate(re.sub("stop.*", "", COLD), "later.h5", "--resume", expect=2)
        self.assertIn("iterations = 40", refused.stderr)

    def test_the_rule_may_change_while_it_is_constructed(self):
        longer = COLD.replace("iterations = 40", "iterations = 30")
        self.generate(longer, "straight.h5")
        self.generate(COLD, "changed.h5", "--time-limit", "0.000001s", expect=75)
        self.assertIn(self.state("changed.h5")["phase"], ("relax", "drain", "fill"))
        self.generate(longer, "changed.h5", "--resume")
        self.assertEqual(self.info("changed.h5")["checksums"], self.info("straight.h5")["checksums"])
        refused = self.generate(COLD.replace("sigma = 1.0", "sigma = 0.9"), "changed.h5", "--resume", expect=2)
        self.assertIn("sigma", refused.stderr)

    def test_stop_rules(self):
        self.generate(re.sub("stop.*", "", JOINED), "constructed.h5")
        before = self.read("constructed.h5")[1]["relative_error"]
        reached = JOINED.replace("iterations = 3000", f"score = {before * 1.001:.6f}")
        self.assertIn("stopped by   stop.score", self.generate(reached, "score.h5").stdout)
        self.assertEqual(self.samples_checksum("score.h5"), self.samples_checksum("constructed.h5"))
        lower = JOINED.replace("iterations = 3000", f"score = {before * 0.998:.6f}")
        self.assertIn("stopped by   stop.score", self.generate(lower, "lower.h5").stdout)
        self.assertLessEqual(self.read("lower.h5")[1]["relative_error"], before * 0.998)
        improvement = JOINED.replace("iterations = 3000", "improvement = 0.01")
        self.assertIn("stopped by   stop.improvement", self.generate(improvement, "improvement.h5").stdout)
        begun = time.monotonic()
        limited = self.generate(JOINED.replace("iterations = 3000", "time = 2"), "time.h5")
        self.assertLess(time.monotonic() - begun, 6)
        self.assertIn("stopped by   stop.time", limited.stdout)
        self.assertLessEqual(self.read("time.h5")[1]["relative_error"], before)
        short = self.generate(JOINED.replace("iterations = 3000", "time = 0.000001"), "short.h5")
        self.assertIn("stopped by   stop.time", short.stdout)
        self.assertEqual(self.samples_checksum("short.h5"), self.samples_checksum("constructed.h5"))

    def test_what_cannot_be_gone_on_with_is_refused(self):
        self.generate(re.sub("stop.*", "", JOINED), "constructed.h5")
        before = self.read("constructed.h5")[1]["relative_error"]
        reached = JOINED.replace("iterations = 3000", f"score = {before * 1.01:.6f}")
        done = self.generate(reached, "run.h5")
        self.assertIn("annealing did not begin", done.stdout)
        lower = JOINED.replace("iterations = 3000", f"score = {before * 0.99:.6f}")
        self.assertIn("ended before annealing began", self.generate(lower, "run.h5", "--resume", expect=2).stderr)
        self.assertEqual(self.samples_checksum("run.h5"), self.samples_checksum("constructed.h5"))
        hot = COLD.replace("stop = { iterations = 40 }", "temperature = { start = 9, end = 5 }\nstop = { score = 0.0001 }")
        self.assertIn("which annealing did not improve", self.generate(hot, "hot.h5").stdout)
        refused = self.generate(hot.replace("0.0001", "0.00001"), "hot.h5", "--resume", expect=2)
        self.assertIn("put back", refused.stderr)

    def test_settings_that_do_not_go_with_a_list(self):
        numpy.save(self.folder / "list.npy", numpy.random.default_rng(1).random((24 * 17, 2), dtype=numpy.float32))
        text = SCALARS.replace('"uniform"', '{ file = "list.npy" }')
        refused = self.generate(text + "sharpness = 1.2\n", "out.h5", expect=2)
        self.assertIn("optimizer.sharpness", refused.stderr)
        self.assertIn("start", self.generate(SCALARS + "start = {}\n", "out.h5", expect=2).stderr)

    def test_plan(self):
        plan = self.run_program("plan", self.write("run.toml", COLD), "--ranks", 2).stdout
        for words in ("method     construct", "annealing: on (of what was constructed, until stop.iterations", "sharpening: on",
                      "features"):
            self.assertIn(words, plan)

    def test_start_from_a_lattice(self):
        text = SCALARS.replace("24", "32").replace("17", "32") + 'start = { pattern = "lattice" }\nstop = { iterations = 40 }\n'
        text = re.sub("groups.*", 'groups = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "box", size = 2 } ]', text)
        told = self.generate(text, "one.h5").stdout
        self.assertIn("that of the lattice", told)
        samples, state = self.read("one.h5")
        self.generate(re.sub("start.*\nstop.*", "", text), "constructed.h5")
        self.assertLess(state["given_error"], 0.8 * self.read("constructed.h5")[1]["relative_error"])
        self.assertLessEqual(state["relative_error"], state["given_error"])
        for ranks in (2, 5) if THOROUGH else (3,):
            self.generate(text, "many.h5", "--overwrite", ranks=ranks)
            self.assertEqual(self.info("many.h5")["checksums"], self.info("one.h5")["checksums"])
        self.generate(text, "again.h5", "--time-limit", "0.000001s", expect=75)
        self.generate(text, "again.h5", "--resume")
        self.assertEqual(self.info("again.h5")["checksums"], self.info("one.h5")["checksums"])
        plan = self.run_program("plan", self.write("run.toml", text)).stdout
        self.assertRegex(plan, r"lattice: on \(to begin with; cycles: \d+ along x, \d+ along y, \d+ along t; R about 0\.0\d+ with uniform")

        numpy.save(self.folder / "list.npy", numpy.random.default_rng(1).random((32 * 32, 2), dtype=numpy.float32))
        refused = (('"vector2"', 'optimizer.start.pattern = "lattice": a lattice is for scalars'), ('"circle"', "a lattice is for scalars"),
                   ('{ file = "list.npy" }', "its samples have 2 channels"))
        for samples, words in refused:
            self.assertIn(words, self.generate(text.replace('"uniform"', samples), "out.h5", expect=2).stderr)
        two = text.replace('pattern = "lattice"', 'pattern = "lattice", file = "one.h5"')
        self.assertIn("must have exactly one of file, pattern", self.generate(two, "out.h5", expect=2).stderr)
        along = re.sub("groups.*", 'groups = [ { axes = "t", kernel = "box", size = 2 } ]', text)
        self.assertIn("optimizer.start.pattern: a lattice follows from how pixels of a slice act", self.generate(along, "out.h5", expect=2).stderr)
        self.assertFalse((self.folder / "out.h5").exists())

    def test_start_from_a_run_file(self):
        annealed = SCALARS + 'method = "anneal"\nstop = { iterations = 20 }\n'
        self.generate(annealed, "first.h5")
        second = SCALARS + 'start = { file = "first.h5" }\nstop = { iterations = 60 }\n'
        self.generate(second, "second.h5", "--threads", 1)
        (one, first), (two, state) = self.read("first.h5"), self.read("second.h5")
        self.assertAlmostEqual(state["given_error"], first["relative_error"], delta=1e-6)
        self.assertLess(state["relative_error"], first["relative_error"])
        self.assertTrue(numpy.array_equal(numpy.sort(one.reshape(5, -1)), numpy.sort(two.reshape(5, -1))))
        self.assertEqual(self.stored_method("second.h5"), "anneal")
        for ranks in (2, 5) if THOROUGH else (3,):
            self.generate(second, "many.h5", "--overwrite", ranks=ranks)
            self.assertEqual(self.info("many.h5")["checksums"], self.info("second.h5")["checksums"])
        self.generate(second, "parts.h5", "--time-limit", "0.000001s", expect=75)
        (self.folder / "first.h5").unlink()  # the run has what it began with
        self.generate(second, "parts.h5", "--resume", ranks=3)
        self.assertEqual(self.samples_checksum("parts.h5"), self.samples_checksum("second.h5"))

    def test_start_from_a_texture_of_ones_own(self):
        texture = numpy.random.default_rng(7).integers(0, 256, (5, 17, 24, 2)).astype(numpy.float32) / 256
        numpy.save(self.folder / "mine.npy", texture)
        text = SCALARS.replace('"uniform"', '{ file = "mine.npy" }') + 'start = { file = "mine.npy" }\nstop = { iterations = 30 }\n'
        self.assertIn("method     anneal", self.run_program("plan", self.write("mine.toml", text)).stdout)
        numpy.save(self.folder / "turned.npy", texture.transpose(0, 2, 1, 3))
        turned = self.generate(text.replace("mine", "turned"), "out.h5", expect=2)
        self.assertIn("shape (5, 24, 17, 2): as a whole texture it must be (5, 17, 24)", turned.stderr)
        self.generate(text, "run.h5")
        samples, state = self.read("run.h5")
        as_rows = lambda values: numpy.sort(numpy.ascontiguousarray(values).reshape(5, -1, 2).view("f4,f4")[..., 0], axis=1)
        self.assertTrue(numpy.array_equal(as_rows(samples), as_rows(texture)))
        self.assertLess(state["relative_error"], 0.8 * state["given_error"])
        self.generate(text.replace("iterations = 30", "score = 0.999"), "same.h5")  # which is reached as it starts
        given = self.read("same.h5")[1]
        if given["finished"] == b"score" and given["sweep"] == 0:
            self.assertTrue(numpy.array_equal(self.read("same.h5")[0], texture))

    def test_starts_that_are_refused(self):
        numpy.save(self.folder / "other.npy", numpy.random.default_rng(7).random((5, 17, 24), dtype=numpy.float32))
        numpy.save(self.folder / "shape.npy", numpy.zeros((5, 24, 17), dtype=numpy.float32))
        self.generate(SCALARS.replace("t = 5", "t = 4"), "slices.h5")
        self.generate(SCALARS.replace('"uniform"', '"uniform"\nseed = 3'), "seed.h5")
        self.generate(SCALARS, "half.h5", "--time-limit", "0.000001s", expect=75)
        for name, words in (("other.npy", ("other.npy: slice 0: does not hold the samples of texture.samples",)),
                            ("shape.npy", ("shape (5, 24, 17)", "(5, 17, 24)")), ("slices.h5", ("24 x 17 x 4", "24 x 17 x 5")),
                            ("seed.h5", ("slice 0: does not hold the samples",)), ("half.h5", ("slice 0: does not hold",)),
                            ("absent.h5", ("absent.h5", "no such file")), ("run.toml", ("run.toml",))):
            with self.subTest(name):
                for ranks in (None, 2) if name == "other.npy" else (None,):
                    text = SCALARS + f'start = {{ file = "{name}" }}\nstop = {{ iterations = 5 }}\n'
                    refused = self.generate(text, "out.h5", expect=2, ranks=ranks)
                    for word in words:
                        self.assertIn(word, refused.stderr)
                    self.assertFalse((self.folder / "out.h5").exists())

    def test_contents_that_no_run_has_are_refused(self):
        self.generate(COLD, "half.h5")
        for changes, words in ((["state.is_given=0"], "is_given"), (["state.join=2"], "join"), (["state.is_cold=7"], "is_cold"),
                               (["state.given_kept=3"], "given_kept"), (["state.given_error=nan"], "given_error"),
                               (["state.begun_s=-1"], "begun_s"), (["/state/given[2][3]=5000"], "/state/given, slice 2")):
            with self.subTest(changes):
                self.rewrite("half.h5", "bad.h5", *changes)
                for command in (("info", "bad.h5"), ("generate", "run.toml", "-o", "bad.h5", "--resume")):
                    self.assertIn(words, self.run_program(*command, expect=2).stderr)


if __name__ == "__main__":
    main()
