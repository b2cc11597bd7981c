"""Wrong input: exit 2 (1 for the disk), a message that names the place, and existing output untouched."""

import hashlib
import os
import pathlib
import resource
import shutil
import struct
import subprocess
import unittest

import numpy

from support import SOURCE, ProgramTest, main

GOOD = """[texture]
size    = { x = 16, y = 16, t = 3 }
samples = "uniform"
seed    = 1
[filter]
combine = "sum"
groups  = [ { axes = "xy", kernel = "gauss", sigma = 1.0, weight = 0.5 },
            { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1, weight = 0.5 } ]
[optimizer]
stop = { iterations = 3 }
"""


# What begins like a run file may be replaced by one.
PRECIOUS = b"noiseloom run file\nprecious"


def digest(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


class BadInput(ProgramTest):
    def refused(self, text, *expected, arguments=(), status=2):
        """generate with this config refuses, naming all that is expected; an earlier output stays as it was."""
        config = self.write("bad.toml", text)
        output = self.folder / "out.h5"
        output.write_bytes(PRECIOUS)
        done = self.run_program("generate", config, "-o", output, "--overwrite", *arguments, expect=status)
        for words in expected:
            self.assertIn(words, done.stderr)
        if status == 2:
            self.assertIn("nothing was started", done.stderr)
        self.assertEqual(output.read_bytes(), PRECIOUS)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir() if p.name.startswith("out.h5")), ["out.h5"])

    def test_configs(self):
        change = GOOD.replace
        self.refused(change("seed ", "sede "), "bad.toml:4", "sede", '"seed"')
        self.refused(change('combine = "sum"', "combine = 7"), "bad.toml:6", "combine")
        self.refused(change("t = 3", "t = 0"), "bad.toml:2", "texture.size.t = 0", "at least 1")
        self.refused(change("sigma = 1.0", "sigma = -1.0"), "bad.toml:7", "sigma", "-1")
        self.refused(change('axes = "t"', 'axes = "w"'), "bad.toml:8", '"w"')
        self.refused(change("weight = 0.5 },", "weight = 0.7 },"), "weight")
        self.refused(change('"ema"', '"expontial"'), "bad.toml:8", '"ema"')
        self.refused(change('"uniform"', '{ file = "absent.npy" }'), "bad.toml:3", "absent.npy")
        self.refused(change("[filter]", "[filter"), "bad.toml:5")
        self.refused(GOOD, "--set", arguments=("--set", "texture.seed=many"))

    def test_configs_that_are_something_else(self):
        self.refused(".".join(["a"] * 20000) + " = 1\n", "bad.toml:1", "more than 32 parts")
        self.refused("a = " + "[" * 100000, "bad.toml:1", "more than 32 deep")
        good = self.write("good.toml", GOOD)
        self.run_program("generate", good, "-o", "run.h5", "--overwrite")
        self.assertIn("run.h5: is a run file, must be a config", self.run_program("plan", "run.h5", expect=2).stderr)
        self.assertIn("is an image (PNG)", self.run_program("plan", SOURCE / "configs/mask.png", expect=2).stderr)
        self.assertIn("longer than 4 MiB", self.run_program("plan", "/dev/zero", expect=2).stderr)

    def test_configs_of_void_and_cluster(self):
        method = ("--set", "optimizer.method=void-and-cluster")
        here = 'here it is "void-and-cluster"'
        self.refused(GOOD, "bad.toml:7", '"gauss-energy"', "bad.toml:8", "bad.toml:10", here, "3 errors", arguments=method)
        text = GOOD.replace('kernel = "gauss", sigma = 1.0', 'kernel = "gauss-energy"').replace("stop = { iterations = 3 }", "")
        text = text.replace('kernel = "ema", alpha = 0.1, rejection = 0.1', 'kernel = "gauss-energy"')
        self.refused(text, "optimizer.bits = 17", "from 0 to 16", arguments=(*method, "--set", "optimizer.bits=17"))
        self.refused(text, "optimizer.bounded", '"w"', "x, y, t", arguments=(*method, "--set", "optimizer.bounded=tw"))
        self.refused(text, "optimizer.density = 0.6", arguments=(*method, "--set", "optimizer.density=0.6"))
        self.refused(text.replace('"sum"', '"product"').replace(", weight = 0.5", ""), "bad.toml:6", 'combine = "sum"', arguments=method)
        self.refused(text.replace("weight = 0.5 }", "weight = 0.6 }"), "bad.toml:7", "weights add up to 1.2", arguments=method)
        self.refused(text.replace('"uniform"', '"sphere"'), "bad.toml:3", '"uniform"', arguments=method)
        self.refused(GOOD, "optimizer.bits", "void-and-cluster", arguments=("--set", "optimizer.bits=8"))
        # A run is not resumed as one of another method.
        config = self.write("good.toml", text)
        self.run_program("generate", config, "-o", "mask.h5", *method)
        before = digest(self.folder / "mask.h5")
        done = self.run_program("generate", config, "-o", "mask.h5", "--resume", expect=2)
        self.assertIn("optimizer.method", done.stderr)
        self.assertEqual(digest(self.folder / "mask.h5"), before)

    def test_all_faults_at_once(self):
        text = GOOD.replace("seed ", "sede ").replace("t = 3", "t = 0").replace("sigma = 1.0", "sigma = -1.0")
        self.refused(text, "bad.toml:2", "bad.toml:4", "bad.toml:7", "3 errors; nothing was started")

    def test_missing_config_and_unknown_options(self):
        done = self.run_program("generate", "nowhere.toml", "-o", "x.h5", expect=2)
        self.assertIn("nowhere.toml", done.stderr)
        self.assertIn("--frobnicate", self.run_program("generate", "a.toml", "-o", "x.h5", "--frobnicate", expect=2).stderr)
        for word, meant in (("genrate", '"generate"'), ("verison", '"version"'), ("--versoin", '"--version"'), ("--hepl", '"--help"')):
            self.assertIn(meant, self.run_program(word, expect=2).stderr)
        for command, word, meant in ((("generate", "a.toml", "-o", "x.h5"), "--thread", "--threads"), (("generate", "a.toml"), "--ouptut", "--output"),
                                     (("plan", "a.toml"), "--rank", "--ranks"), (("info", "a.h5"), "--jsn", "--json")):
            self.assertIn(f"{word}: unknown option; did you mean {meant}?", self.run_program(*command, word, "2", expect=2).stderr)
        config = self.write("good.toml", GOOD)
        for option in (("--time-limit", "soon"), ("--threads", "-1"), ("--threads", "100000"), ("--threads", "two"), ("--watchdog", "never"), ("--progress", "loud"), ("--resume", "--overwrite")):
            done = self.run_program("generate", config, "-o", "x.h5", *option, expect=2)
            self.assertIn(option[0], done.stderr)
        self.assertFalse((self.folder / "x.h5").exists())

    def test_unknown_options_of_commands_that_look_at_files(self):
        for command, word, meant in (("score", "--thread", "--threads"), ("score", "--jsn", "--json"), ("analyze", "--ouput", "--output"),
                                     ("export", "--laoyut", "--layout"), ("accuracy", "--bugdet", "--budget")):
            stderr = self.run_program(command, "a.h5", "-o", "b", word, "2", expect=2).stderr
            self.assertIn(f"{word}: unknown option; did you mean {meant}?", stderr)
            self.assertIn(f"see noiseloom {command} --help", stderr)
        self.assertIn("noiseloom score --help", self.run_program("score", expect=2).stderr)

    def test_one_message_under_mpi(self):
        config = self.write("bad.toml", GOOD.replace("t = 3", "t = 0"))
        done = self.run_program("generate", config, "-o", "x.h5", ranks=3, expect=2)
        self.assertEqual(done.stderr.count("nothing was started"), 1)

    def test_user_samples(self):
        text = GOOD.replace('"uniform"', '{ file = "mine.npy" }')
        samples = numpy.linspace(0, 1, 256, dtype=numpy.float32)
        samples[100] = numpy.nan
        numpy.save(self.folder / "mine.npy", samples)
        self.refused(text, "mine.npy", "100", "nan")
        samples[100] = numpy.inf
        numpy.save(self.folder / "mine.npy", samples)
        self.refused(text, "mine.npy", "100", "inf")
        numpy.save(self.folder / "mine.npy", samples[:200])
        self.refused(text, "mine.npy", "200", "256")

    def test_existing_output_needs_a_word(self):
        config = self.write("good.toml", GOOD)
        self.run_program("generate", config, "-o", "run.h5")
        before = digest(self.folder / "run.h5")
        done = self.run_program("generate", config, "-o", "run.h5", expect=2)
        self.assertIn("--resume", done.stderr)
        done = self.run_program("generate", config, "-o", "run.h5", "--resume", "--set", "texture.seed=9", expect=2)
        self.assertIn("texture.seed", done.stderr)
        self.assertEqual(digest(self.folder / "run.h5"), before)
        self.run_program("generate", config, "-o", "run.h5", "--resume")
        self.assertEqual(digest(self.folder / "run.h5"), before)

    def test_damaged_run_files(self):
        config = self.write("good.toml", GOOD)
        self.run_program("generate", config, "-o", "run.h5")
        whole = (self.folder / "run.h5").read_bytes()
        (self.folder / "cut.h5").write_bytes(whole[: len(whole) // 2])
        import h5py

        with h5py.File(self.folder / "run.h5") as file:
            offset = file["samples"].id.get_offset() + file.userblock_size
            offset = offset if whole[offset : offset + 4] == file["samples"][0, 0, 0, 0].tobytes() else offset - file.userblock_size
        flipped = bytearray(whole)
        flipped[offset + 5] ^= 4
        (self.folder / "flipped.h5").write_bytes(flipped)
        for name, words in (("cut.h5", "truncated"), ("flipped.h5", "/samples")):
            before = digest(self.folder / name)
            for command in (("info", name), ("generate", config, "-o", name, "--resume")):
                done = self.run_program(*command, expect=2)
                self.assertIn(name, done.stderr)
                self.assertIn(words, done.stderr)
            self.assertEqual(digest(self.folder / name), before)
        # With a generation before it, the run goes on from there, loudly.
        shutil.copy(self.folder / "run.h5", self.folder / "flipped.h5.prev")
        done = self.run_program("generate", config, "-o", "flipped.h5", "--resume")
        self.assertIn("WARNING", done.stderr)
        self.assertEqual(self.samples_checksum("flipped.h5"), self.samples_checksum("run.h5"))

    def test_directory_that_is_not_there(self):
        config = self.write("good.toml", GOOD)
        done = self.run_program("generate", config, "-o", "no/such/folder/run.h5", expect=None)
        self.assertIn(done.returncode, (1, 2))
        self.assertIn("no/such/folder", done.stderr)

    def test_directory_that_cannot_be_written(self):
        config = self.write("good.toml", GOOD)
        # Root may write anywhere else.
        done = self.run_program("generate", config, "-o", "/sys/run.h5", expect=1)
        self.assertIn("/sys", done.stderr)

    def test_full_disk(self):
        config = self.write("good.toml", GOOD)
        self.run_program("generate", config, "-o", "run.h5", "--time-limit", "0.000001s", expect=75)
        before = digest(self.folder / "run.h5")

        def small_files():
            resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))

        done = subprocess.run(self.command("generate", config, "-o", "run.h5", "--resume"), capture_output=True, text=True,
                              preexec_fn=small_files, cwd=self.folder, env={**os.environ})
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("run.h5", done.stderr)
        self.assertEqual(digest(self.folder / "run.h5"), before)
        self.run_program("generate", config, "-o", "run.h5", "--resume")
        self.assertEqual(self.info("run.h5")["state"]["finished"], "iterations")

    def test_filter_table_of_a_run_file_that_lies_elsewhere(self):
        numpy.save(self.folder / "tap.npy", numpy.array([0.1, 0.5, 0.4]))
        (self.folder / "cfg").mkdir()
        (self.folder / "tap.npy").rename(self.folder / "cfg" / "tap.npy")
        config = self.write("cfg/good.toml", GOOD.replace('kernel = "gauss", sigma = 1.0', 'kernel = "table", file = "tap.npy"'))
        annealing = ("--set", "optimizer.method=anneal")
        self.run_program("generate", config, "-o", "run.h5", *annealing, "--time-limit", "0.000001s", expect=75)
        self.run_program("score", "run.h5")
        self.run_program("generate", config, "-o", "run.h5", *annealing, "--resume")

    def test_output_that_is_no_run_file(self):
        config = self.write("good.toml", GOOD)
        (self.folder / "folder.h5").mkdir()
        shutil.copy(config, self.folder / "config.h5")
        for name, text in (("folder.h5", "not a file"), ("config.h5", "not a run file"), ("", "empty"), ("good.toml", ".h5 or .hdf5"),
                           ("a.png", ".h5 or .hdf5"), ("-", ".h5 or .hdf5"), ("run", ".h5 or .hdf5")):
            done = self.run_program("generate", config, "-o", name, "--overwrite", expect=2)
            self.assertIn(text, done.stderr)
            self.assertFalse((self.folder / name).is_file() and name not in ("good.toml", "config.h5"), name)
        self.assertEqual(config.read_text(), GOOD)
        self.assertEqual((self.folder / "config.h5").read_text(), GOOD)
        self.run_program("generate", config, "-o", "RUN.HDF5")
        # The config's faults and the output's are listed together.
        done = self.run_program("generate", self.write("bad.toml", GOOD.replace("t = 3", "t = 0")), "-o", "a.png", expect=2)
        self.assertIn("2 errors", done.stderr)

    def test_a_file_in_the_wrong_place(self):
        config = self.write("good.toml", GOOD)
        self.run_program("generate", config, "-o", "run.h5")
        self.assertIn("noiseloom generate good.toml -o RUN.h5", self.run_program("good.toml", expect=2).stderr)
        self.assertIn("noiseloom info run.h5", self.run_program("run.h5", expect=2).stderr)

    def test_a_rank_that_fails_alone_ends_the_run(self):
        config = self.write("good.toml", GOOD.replace("x = 16, y = 16", "x = 1024, y = 1024"))
        starved = "import os, resource, sys\nif os.environ['OMPI_COMM_WORLD_RANK'] == '1':\n" \
                  "    resource.setrlimit(resource.RLIMIT_AS, (270000000, 270000000))\nos.execv(sys.argv[1], sys.argv[1:])\n"
        script = self.write("starve.py", starved)
        command = self.command("generate", config, "-o", "run.h5", "--threads", "1", ranks=2)
        command[3:3] = ["/usr/bin/python3", str(script)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder, timeout=60)
        self.assertNotEqual(done.returncode, 0)

    def test_second_run_on_the_same_output(self):
        config = self.write("good.toml", GOOD)
        command = self.command("generate", config, "-o", "run.h5", "--progress", "json", "--set", "optimizer.stop.iterations=1000000")
        first = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=self.folder)
        try:
            for line in first.stderr:
                if '"iterations"' in line:
                    break
            done = self.run_program("generate", config, "-o", "run.h5", expect=2)
            self.assertIn(str(first.pid), done.stderr)
        finally:
            first.kill()
            first.stderr.close()
            first.wait()
        self.run_program("generate", config, "-o", "run.h5")


if __name__ == "__main__":
    main()
