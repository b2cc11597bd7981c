"""Run files whose digests are right and whose contents are not: nothing crashes on them, nothing believes them.

Another program, or a person, may have written such a file; a digest says only that the bytes are those that were
written. `info` and `generate --resume` look at everything and refuse it by name; the others look at what they use.
These read through one loader and take a quarter of a second each only to start: every change of samples, places and ids is tried with
one of them in turn, and of the others every fourth. Where NOISELOOM_THOROUGH is set, every change is tried with all three.
"""

import itertools
import shutil

from support import THOROUGH, ProgramTest, main

SWAPS = """
[texture]
size    = { x = 7, y = 5, t = 9 }
samples = "vector2"
[filter]
groups  = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "ema", alpha = 0.1 } ]
[optimizer]
stop = { iterations = 40 }
"""

ORDER = """
[texture]
size = { x = 13, y = 11, t = 3 }
[filter]
groups = [ { axes = "xyt", kernel = "gauss-energy", sigma = 1.2 } ]
[optimizer]
method = "void-and-cluster"
"""

# Changes (tests/program/native/rewrite_run_file.cpp says how they are written) and words of what info and --resume then say.
LAYOUT = [
    (["extents=7,5,8"], "but its /config says"),
    (["extents=1,1,1"], "but its /config says"),
    (["config:t = =>q = "], "/config"),
    (["config:[texture]=>[texture"], "/config"),
    (["config:seed = 1=>seed = -1"], "seed"),
    (["-history.seconds"], "/history/seconds: missing"),
    (["history.seconds[0]=nan"], "/history/seconds, row 0 = nan"),
    (["history.seconds[0]=-1"], "/history/seconds, row 0 = -1"),
    (["state.finished=lunch"], "lunch"),
    (["-state.finished"], "\"finished\""),
    (["state.finished:number=1"], "\"finished\""),
    (["state.algorithm=0"], "/state/@algorithm"),
    (["state.algorithm:text=one"], "/state/@algorithm"),
    (["/samples:type=uint32"], "/samples: has"),
]

SWAP_CHANGES = [
    (["-/state/permutation"], "has no /state/permutation"),
    (["/state/permutation:type=float32"], "/state/permutation: is float32"),
    (["/state/permutation[4][17]=2147483647"], "slice 4: cell 17 holds id 2147483647"),
    (["/state/permutation[0][0]=35"], "slice 0: cell 0 holds id 35, must be below 35"),
    (["/state/permutation[8][1]=3", "/state/permutation[8][2]=3"], "slice 8: cell"),
    (["config:vector2=>vector3"], "/samples: has 2 channels, but vector3 samples are 3"),
    (['config:method = "anneal"=>method = "void-and-cluster"'], ""),
    (["state.sweep=-1"], "/state/@sweep = -1"),
    (["state.sweep=4000000000"], "/state/@sweep = 4000000000"),
    (["state.step=1000"], "/state/@step = 1000"),
    (["state.step=-1"], "/state/@step = -1"),
    (["state.accepted=-1"], "/state/@accepted = -1"),
    (["state.accepted=9000000000000000000", "state.candidates=9000000000000000000"], "/state/@candidates"),
    (["state.temperature=nan"], "/state/@temperature = nan"),
    (["state.temperature=-1"], "/state/@temperature = -1"),
    (["state.elapsed_s=inf"], "/state/@elapsed_s = inf"),
    (["state.fraction=0"], "/state/@fraction = 0"),
    (["state.fraction=1.5"], "/state/@fraction = 1.5"),
    (["state.mean_magnitude=-2"], "/state/@mean_magnitude = -2"),
    (["state.mean_distance=nan"], "/state/@mean_distance = nan"),
    (["state.relative_error=nan"], "/state/@relative_error = nan"),
    (["state.iterations=-1"], "/state/@iterations = -1"),
    (["state.scored_iterations=1000000"], "/state/@scored_iterations = 1000000"),
    (["state.scored_step=-1"], "/state/@scored_step = -1"),
    (["state.round_score=inf"], "/state/@round_score = inf"),
    (["state.finished=score"], "/state/@finished = score"),
    (["-state.step"], "\"step\""),
    (["state.step:text=0"], "\"step\""),
    (["-history.relative_error"], "/history/relative_error: missing"),
    (["history.sweep[0]=1"], "/history/sweep, row 0 = 1"),
    (["history.sweep[0]=nan"], "/history/sweep, row 0 = nan"),
    (["history.iterations[0]=-5"], "/history/iterations, row 0 = -5"),
    (["history.iterations[0]=1e300"], "/history/iterations, row 0 = 1e+300"),
    (["history.temperature[0]=-inf"], "/history/temperature, row 0 = -inf"),
    (["history.acceptance[0]=1.01"], "/history/acceptance, row 0 = 1.01"),
    (["history.relative_error[0]=inf"], "/history/relative_error, row 0 = inf"),
]

ORDER_CHANGES = LAYOUT + [
    (["-/order"], ""),
    (["/order:type=float32"], "/order: is float32"),
    (["/order[1][5]=2147483647"], "/order does not fit /state"),
    (["/order[0][0]=429"], "/order does not fit /state"),
    (["/order[2][3]=7", "/order[2][4]=7"], "/order does not fit /state"),
    (["/order[0][1]=4294967294"], "/order does not fit /state"),
    (["state.phase=melt"], "\"melt\""),
    (["state.start_points=-1"], "-1 start points"),
    (["state.start_points=43"], "43 start points"),
    (["state.swaps=-3"], "-3 swaps"),
    (["state.swaps=9223372036854775807"], "9223372036854775807 swaps"),
    (["state.ranked=430"], "430 of 429 pixels"),
    (["history.phase[0]=7"], "/history/phase, row 0 = 7"),
    (["history.phase[0]=0.5"], "/history/phase, row 0 = 0.5"),
    (["history.swaps[0]=-1"], "/history/swaps, row 0 = -1"),
    (["history.ranked[0]=1e18"], "/history/ranked, row 0 = 1e+18"),
]


READERS = ("score", "export", "analyze")


class RunFileContents(ProgramTest):
    def setUp(self):
        super().setUp()
        self.readers = itertools.cycle(READERS)
        self.turns = itertools.cycle(part for reader in READERS for part in ((reader,), (), (), ()))

    def commands(self, config):
        shutil.copy(self.folder / "changed.h5", self.folder / "again.h5")
        return {
            "info": ("info", "changed.h5"),
            "resume": ("generate", config, "-o", "again.h5", "--resume", "--progress", "none"),
            "score": ("score", "changed.h5"),
            "export": ("export", "changed.h5", "-o", "images", "--overwrite"),
            "analyze": ("analyze", "changed.h5", "-o", "report", "--overwrite"),
        }

    def refuse(self, config, run_file, changes, words):
        self.rewrite(run_file, "changed.h5", *changes)
        only_state = all(change.lstrip("-").startswith("state.") for change in changes)
        if only_state:  # none of them looks at that
            readers = ()
        elif THOROUGH:
            readers = READERS
        elif changes[0].lstrip("-").startswith(("/samples", "/order", "/state/permutation")):  # what they read
            readers = (next(self.readers),)
        else:
            readers = next(self.turns)
        for name, arguments in self.commands(config).items():
            if name in READERS and name not in readers:
                continue
            done = self.run_program(*arguments, expect=None)
            self.assertIn(done.returncode, (0, 2), (name, done.stderr))
            if name not in ("info", "resume"):
                continue
            self.assertEqual(done.returncode, 2, (name, done.stdout))
            if name != "resume" or "made from another config" not in done.stderr:
                self.assertIn(words, done.stderr, name)
            self.assertRegex(done.stderr, "(changed|again).h5", name)

    def test_swaps(self):
        config = self.write("run.toml", SWAPS)
        self.run_program("generate", config, "-o", "done.h5", "--progress", "none")
        # Inside the first sweep.
        self.run_program("generate", config, "-o", "begun.h5", "--progress", "none", "--time-limit", "0.000001s", expect=75)
        self.assertEqual(self.info(self.folder / "begun.h5")["state"]["step"], 1)
        of_a_sweep = [(changes, words) for changes, words in SWAP_CHANGES
                      if changes[0].startswith(("state.step", "state.accepted", "/state/permutation["))]
        for run_file, all_changes in (("done.h5", LAYOUT + SWAP_CHANGES), ("begun.h5", of_a_sweep)):
            for changes, words in all_changes:
                with self.subTest(run_file=run_file, changes=changes):
                    self.refuse(config, run_file, changes, words)

    def test_void_and_cluster(self):
        config = self.write("run.toml", ORDER)
        self.run_program("generate", config, "-o", "done.h5", "--progress", "none")
        for changes, words in ORDER_CHANGES:
            with self.subTest(changes=changes):
                self.refuse(config, "done.h5", changes, words)

    def test_provenance_goes_on_where_it_makes_sense(self):
        config = self.write("run.toml", SWAPS)
        self.run_program("generate", config, "-o", "begun.h5", "--progress", "none", "--time-limit", "0.000001s", expect=75)

        def resumed(*changes, expect=0):
            self.rewrite("begun.h5", "changed.h5", *changes)
            return self.run_program("generate", config, "-o", "changed.h5", "--resume", "--progress", "none", expect=expect)

        resumed("provenance.seconds_total=5000", "provenance.parts=7")
        provenance = self.info("changed.h5")["provenance"]
        self.assertEqual(provenance["parts"], 8)
        self.assertGreater(provenance["seconds_total"], 5000)
        # What a person alone reads begins anew where it makes no sense; what the schedule may follow is refused.
        for parts in ("parts=-3", "parts=9223372036854775807", "parts:text=many"):
            resumed("provenance." + parts)
            self.assertEqual(self.info("changed.h5")["provenance"]["parts"], 1)
        for seconds in ("seconds_total=-1", "seconds_total=nan", "seconds_total=inf", "seconds_total:text=long"):
            self.assertIn("changed.h5: /provenance: seconds_total", resumed("provenance." + seconds, expect=2).stderr)

    def test_what_is_rewritten_without_changes_is_good(self):
        for text in (SWAPS, ORDER):
            config = self.write("run.toml", text)
            self.run_program("generate", config, "-o", "done.h5", "--progress", "none", "--overwrite")
            self.rewrite("done.h5", "changed.h5")
            for name, arguments in self.commands(config).items():
                self.run_program(*arguments)


if __name__ == "__main__":
    main()
