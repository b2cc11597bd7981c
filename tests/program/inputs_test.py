"""What a run was made from is in its run file: the files that the config names are read once, by one rank, at the start."""

import shutil
import subprocess

import h5py
import numpy

from support import MPIEXEC, BIN, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 8, y = 7, t = 6 }
samples = { file = "mine.npy" }
[filter]
groups  = [ { axes = "xy", kernel = "table", file = "taps.npy" }, { axes = "t", kernel = "ema", alpha = 0.1 } ]
[optimizer]
stop = { iterations = 60 }
"""


class Inputs(ProgramTest):
    def setUp(self):
        super().setUp()
        self.random = numpy.random.default_rng(1)
        self.samples = self.random.random((6, 56, 2))  # float64, one list a slice
        self.taps = numpy.array([[1.0, 2, 1], [0.1, 4, 0.3]])
        self.write_inputs(self.folder)
        self.config = self.write("run.toml", CONFIG)

    def write_inputs(self, folder, samples=None, taps=None):
        numpy.save(folder / "mine.npy", self.samples if samples is None else samples)
        numpy.save(folder / "taps.npy", self.taps if taps is None else taps)

    def remove_inputs(self):
        for name in ("mine.npy", "taps.npy"):
            (self.folder / name).unlink()

    def generate(self, output, *arguments, **options):
        return self.run_program("generate", self.config, "-o", output, "--progress", "plain", *arguments, **options)

    def test_the_run_file_holds_the_arrays_as_they_were_read(self):
        self.generate("run.h5")
        with h5py.File(self.folder / "run.h5") as file:
            self.assertEqual(set(file["inputs"]), {"texture.samples.file", "filter.groups[0].file"})
            samples = file["inputs"]["texture.samples.file"]
            taps = file["inputs"]["filter.groups[0].file"]
            self.assertEqual((samples.attrs["file"], taps.attrs["file"]), (b"mine.npy", b"taps.npy"))
            self.assertEqual((samples.dtype, taps.dtype), (numpy.float32, numpy.float64))
            numpy.testing.assert_array_equal(samples[...], self.samples.astype(numpy.float32))
            numpy.testing.assert_array_equal(taps[...], self.taps)
            self.assertIsNone(samples.chunks)

    def score(self, *arguments):
        return self.run_program("score", "run.h5", "--json", *arguments).stdout

    def test_whoever_measures_a_texture_reads_nothing_else(self):
        self.generate("run.h5")
        expected = self.score()
        self.write_inputs(self.folder, taps=numpy.ones((2, 3)))
        self.assertEqual(self.score(), expected, "with another table under that name")
        self.remove_inputs()
        self.assertEqual(self.score(), expected, "without the table")
        self.run_program("analyze", "run.h5", "-o", "report")
        self.run_program("export", "run.h5", "-o", "images", "--range", "0:1")
        self.run_program("info", "run.h5")

    def test_another_table_may_be_named(self):
        self.generate("run.h5")
        expected = self.score()
        numpy.save(self.folder / "other.npy", numpy.ones((2, 3)))
        self.assertNotEqual(self.score("--set", "filter.groups[0].file=other.npy"), expected)

    def test_a_run_goes_on_without_the_files(self):
        self.generate("straight.h5")
        self.generate("run.h5", "--time-limit", "0.000001s", expect=75)
        self.remove_inputs()
        done = self.generate("run.h5", "--resume", ranks=2)
        self.assertNotIn("changed", done.stderr)
        self.assertEqual(self.samples_checksum("run.h5"), self.samples_checksum("straight.h5"))

    def test_a_run_goes_on_from_what_it_began_with_and_says_so(self):
        self.generate("straight.h5")
        self.generate("run.h5", "--time-limit", "0.000001s", expect=75)
        self.write_inputs(self.folder, samples=self.samples / 2)
        done = self.generate("run.h5", "--resume")
        self.assertRegex(done.stderr, "mine.npy.*changed")
        self.assertNotRegex(done.stderr, "taps.npy.*changed")
        self.assertEqual(self.samples_checksum("run.h5"), self.samples_checksum("straight.h5"))

    def test_a_new_run_needs_the_files(self):
        self.remove_inputs()
        done = self.generate("run.h5", "--resume", expect=2)
        self.assertIn("mine.npy", done.stderr)
        self.assertIn("taps.npy", done.stderr)

    def test_ranks_whose_folders_hold_other_files_work_from_those_of_rank_0(self):
        self.generate("straight.h5")
        other = self.folder / "other node"
        other.mkdir()
        self.write_inputs(other, samples=self.samples / 2, taps=numpy.ones((2, 3)))
        empty = self.folder / "empty node"
        empty.mkdir()
        for folder in (other, empty):
            shutil.copy(self.config, folder)
        command = []
        for folder in (self.folder, other, empty):
            command += [":"] if command else []
            command += ["-n", "1", "-wdir", str(folder), str(BIN / "noiseloom"), "generate", "run.toml", "-o",
                        str(self.folder / "run.h5"), "--progress", "none"]
        done = subprocess.run([MPIEXEC] + command, capture_output=True, text=True, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.samples_checksum("run.h5"), self.samples_checksum("straight.h5"))

    def test_contents_that_cannot_be_are_refused(self):
        self.generate("good.h5", "--time-limit", "0.000001s", expect=75)
        for changes, words in ((["inputs.texture.samples.file[3]=nan"], "mine.npy: slice 0, sample 1, channel 1 = nan"),
                               (["inputs.texture.samples.file:shape=56,12"], "shape (56, 12)"),
                               (["inputs.filter.groups[0].file[0]=inf"], "tap 0 is inf"),
                               (["inputs.filter.groups[0].file:shape=6,1,1"], "3 dimensions"),
                               (["inputs.texture.samples.file[0]=0.5"], "the stored samples are not those")):
            with self.subTest(changes=changes):
                self.rewrite("good.h5", "run.h5", *changes)
                done = self.generate("run.h5", "--resume", expect=2)
                self.assertIn(words, done.stderr)

    def test_negative_taps_are_told_of(self):
        self.assertNotIn("negative", self.generate("run.h5").stderr)
        self.write_inputs(self.folder, taps=numpy.array([-0.1, 1, -0.1]))
        done = self.generate("run.h5", "--overwrite")
        self.assertRegex(done.stderr, r"filter.groups\[0\].file = .*taps.npy.*: 2 of 3 taps are negative")

    def test_runs_from_before_are_gone_on_with_from_the_files(self):
        """Their run files have no /inputs, and a digest of the files' bytes instead."""
        self.generate("straight.h5")
        self.generate("good.h5", "--time-limit", "0.000001s", expect=75)
        self.rewrite("good.h5", "run.h5", "-inputs.texture.samples.file", "-inputs.filter.groups[0].file",
                     "state.inputs:digest=mine.npy,taps.npy")
        shutil.copy(self.folder / "run.h5", self.folder / "changed.h5")
        self.generate("run.h5", "--resume")
        self.assertEqual(self.samples_checksum("run.h5"), self.samples_checksum("straight.h5"))
        self.run_program("score", "run.h5")
        self.write_inputs(self.folder, taps=numpy.ones(3))
        self.assertIn("has changed since", self.generate("changed.h5", "--resume", expect=2).stderr)


if __name__ == "__main__":
    main()
