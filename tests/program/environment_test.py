"""Surroundings that jobs meet: odd paths and limits, missing folders, other locales, storage that is slow or fails for a while.

Each ends in the bytes of a run that nothing disturbed, or in a message that names what is wrong."""

import errno
import os
import re
import shutil
import subprocess
import unittest

from support import KILLER, SOURCE, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 13, y = 11, t = 2 }
samples = "tent"
[filter]
groups  = [ { axes = "xy", kernel = "gauss", sigma = 0.75 } ]
[optimizer]
stop = { iterations = 60 }
"""


class Environment(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("run.toml", CONFIG)
        self.run_program("generate", "run.toml", "-o", "straight.h5", "--quiet")
        self.expected = self.samples_checksum("straight.h5")

    def generate(self, output="out.h5", *more, limit="", environment=None, expect=0):
        """In a shell, where `limit` is set; the variables of `environment` that are None are taken away."""
        variables = {**os.environ, **(environment or {})}
        variables = {name: value for name, value in variables.items() if value is not None}
        command = self.command("generate", "run.toml", "-o", output, *more)
        done = subprocess.run(["bash", "-c", f'{limit or ":"} && exec "$@"', "bash", *command], cwd=self.folder, env=variables,
                              capture_output=True, text=True, timeout=120)
        if expect is not None:
            self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        if expect == 0:
            self.assertEqual(self.samples_checksum(output), self.expected)
        return done

    def test_paths_that_shells_and_tables_of_names_stumble_over(self):
        for name in ("a b.h5", "qu'ote\".h5", "größe-音.h5", "$HOME;*.h5", "-.h5", "100%d.h5"):
            with self.subTest(name):
                self.generate(f"./{name}")
        deep = self.folder
        while len(str(deep)) < 3900:
            deep = deep / ("d" * min(200, 3950 - len(str(deep))))
            deep.mkdir()  # each path as a whole is short enough for the system
        self.generate(str(deep / ("o" * (3996 - len(str(deep))) + ".h5")))
        self.assertIn("too long", self.generate("o" * 300 + ".h5", expect=2).stderr)

    def test_no_home_no_folder_for_temporaries_no_terminal(self):
        self.generate(environment={"HOME": None, "USER": None, "LOGNAME": None, "TERM": None, "TMPDIR": str(self.folder / "gone")})

    def test_locales_change_no_number(self):
        if shutil.which("localedef") is None or subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", str(self.folder / "de_DE.UTF-8")],
                                                               capture_output=True).returncode != 0:
            self.skipTest("a locale with decimal commas cannot be made here")
        comma = {"LOCPATH": str(self.folder), "LC_ALL": "de_DE.UTF-8"}
        self.assertIn("0,5", subprocess.run(["bash", "-c", "printf %.1f 0,5"], env={**os.environ, **comma}, capture_output=True, text=True).stdout)
        self.generate(environment=comma)
        texts = [self.run_program(*words, environment=variables).stdout for variables in ({}, comma)
                 for words in (("info", "straight.h5"), ("plan", "run.toml", "--json"))]
        self.assertEqual(texts[0], texts[2])
        self.assertNotIn("0,75", texts[2] + texts[3])

    def test_limits_of_the_shell(self):
        self.generate("few.h5", limit="ulimit -n 32 -s 512")
        done = self.generate("fewer.h5", limit="ulimit -n 16", expect=None)  # which of the two the MPI library decides
        if done.returncode == 0:
            self.assertEqual(self.samples_checksum("fewer.h5"), self.expected)
        else:
            self.assertIn("Too many open files", done.stderr)
        self.assertIn("ulimit -f", self.generate("small.h5", limit="ulimit -f 4", expect=1).stderr)
        self.assertFalse((self.folder / "small.h5").exists())

    def storage(self, **variables):
        return {"LD_PRELOAD": str(KILLER), "KILL_PART": "out.h5", **{name: str(value) for name, value in variables.items()}}

    def test_slow_storage(self):
        self.generate(environment=self.storage(SLOW_MS=2))

    def test_stale_handles_of_a_network_file_system(self):
        """Those of a checkpoint cost a warning; for ever, the run ends and what was saved before is whole."""
        counted = self.storage(COUNT_FILE=self.folder / "count")
        every = ("--checkpoint-every", "0.001s", "--set", "optimizer.stop.iterations=400")
        self.expected = None
        for to, expect in ((0, 0), (30, 0), (10**9, 1)):
            with self.subTest(to):
                (self.folder / "out.h5").unlink(missing_ok=True)
                failing = {} if to == 0 else self.storage(FAIL_FROM=25 if to == 30 else 60, FAIL_TO=to, FAIL_ERRNO=errno.ESTALE)
                command = self.command("generate", "run.toml", "-o", "out.h5", *every)
                done = subprocess.run(command, cwd=self.folder, env={**os.environ, **counted, **failing}, capture_output=True, text=True)
                self.assertEqual(done.returncode, expect, done.stderr)
                if to != 0:
                    self.assertIn("Stale file handle", done.stderr)
                if expect == 0:
                    self.expected = self.expected or self.samples_checksum("out.h5")
                    self.assertEqual(self.samples_checksum("out.h5"), self.expected)
                    continue
                self.run_program("generate", "run.toml", "-o", "out.h5", "--resume", "--quiet", *every[2:])
                self.assertEqual(self.samples_checksum("out.h5"), self.expected)

    def test_a_clock_that_jumps_by_a_year(self):
        """In the middle of a run: neither its end nor what it saves go by the clock of the wall."""
        for years in (1, -1):
            done = self.generate("out.h5", "--overwrite", "--checkpoint-every", "0.005s", "--time-limit", "1h", "--progress", "plain",
                                 environment=self.storage(FAIL_FROM=20, CLOCK_JUMP=years * 365 * 86400))
            self.assertEqual([path.name for path in self.folder.glob("out.h5?*")], [])
            self.assertLess(self.info("out.h5")["provenance"]["seconds_total"], 100)
            self.assertLess(done.stderr.count("saved at"), 100)

    def test_a_quota_that_is_used_up(self):
        used_up = self.storage(FAIL_FROM=0, FAIL_TO=10**9, FAIL_ERRNO=errno.EDQUOT)
        self.assertIn("Disk quota exceeded", self.generate(environment=used_up, expect=1).stderr)
        self.generate()


class Faults(unittest.TestCase):
    def test_the_table_of_faults_names_tests_that_there_are(self):
        named = re.findall(r"`(\w+_test\.(?:py|cpp)) (\w+)`", (SOURCE / "tests/program/FAULTS.md").read_text())
        self.assertGreater(len(named), 40)
        for file, test in named:
            (path,) = (SOURCE / "tests").glob(f"*/{file}")
            self.assertRegex(path.read_text(), rf"(def |, ){test}\(?", f"{file} {test}")


if __name__ == "__main__":
    main()
