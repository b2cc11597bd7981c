"""Runs the programs under test, alone and under mpirun."""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

BIN = pathlib.Path(os.environ["NOISELOOM_BIN"])
SOURCE = pathlib.Path(os.environ["NOISELOOM_SOURCE_DIR"])
MPIEXEC = os.environ["NOISELOOM_MPIEXEC"]
KILLER = os.environ["NOISELOOM_KILLER"]
REWRITER = os.environ["NOISELOOM_REWRITER"]
# Whether to try what is left out elsewhere, as it takes long and seldom teaches anything (tools/test --all).
THOROUGH = os.environ.get("NOISELOOM_THOROUGH", "") != ""

# Without FMA and AVX2 the C library takes other code paths; the results must be the same bytes.
PLAIN_CPU = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable,-FMA4_Usable"}


class ProgramTest(unittest.TestCase):
    """A test with a folder of its own, self.folder."""

    def setUp(self):
        holder = tempfile.TemporaryDirectory(prefix="noiseloom-test-")
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def command(self, *arguments, ranks=None):
        """The command line of noiseloom, under mpirun where ranks are given."""
        launcher = [] if ranks is None else [MPIEXEC, "-n", str(ranks)]
        return launcher + [str(BIN / "noiseloom")] + [str(a) for a in arguments]

    def run_program(self, *arguments, ranks=None, environment=None, expect=0, timeout=300):
        """Runs noiseloom and returns the finished process; expect=None takes any exit status."""
        done = subprocess.run(self.command(*arguments, ranks=ranks), env={**os.environ, **(environment or {})},
                              capture_output=True, text=True, timeout=timeout, cwd=self.folder)
        if expect is not None:
            self.assertEqual(done.returncode, expect, f"{arguments}\n{done.stdout}\n{done.stderr}")
        return done

    def info(self, run_file):
        """What the run file says, every byte of it checked against its digest."""
        return json.loads(self.run_program("info", run_file, "--json").stdout)

    def state(self, run_file):
        """The "state" of info(), read without the program: for tests that look after every one of many parts."""
        import h5py

        with h5py.File(self.folder / run_file) as file:
            return {key: value.decode() if isinstance(value, bytes) else value for key, value in file["state"].attrs.items()}

    def rewrite(self, run_file, output, *changes):
        """Another run file with right digests; tests/support/rewrite_run_file.cpp says how changes are written."""
        subprocess.run([REWRITER, str(run_file), str(output), *changes], check=True, cwd=self.folder)

    def samples_checksum(self, run_file):
        return self.info(run_file)["checksums"]["/samples"]


def main():
    unittest.main(verbosity=2)
