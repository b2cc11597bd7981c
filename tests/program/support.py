"""Runs the programs under test, alone and under mpirun."""

import array
import json
import os
import pathlib
import signal
import socket
import subprocess
import tempfile
import threading
import unittest

BIN = pathlib.Path(os.environ["NOISELOOM_BIN"])
SOURCE = pathlib.Path(os.environ["NOISELOOM_SOURCE_DIR"])
MPIEXEC = os.environ["NOISELOOM_MPIEXEC"]
KILLER = os.environ["NOISELOOM_KILLER"]
REWRITER = os.environ["NOISELOOM_REWRITER"]
FORKER = os.environ["NOISELOOM_FORKER"]
# Whether to try what is left out elsewhere, as it takes long and seldom teaches anything (tools/test --all).
THOROUGH = os.environ.get("NOISELOOM_THOROUGH", "") != ""

# What noiseloom leaves to noiseloom-study; that it does is tried by the tests that start it afresh, and by install_test.
STUDY_COMMANDS = {"export", "score", "verify", "compare", "analyze", "accuracy", "render", "fastnoise", "stbn-scalar", "stbn-vector"}

# Without FMA and AVX2 the C library takes other code paths; the results must be the same bytes.
PLAIN_CPU = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable,-FMA4_Usable"}


class LoadedProgram:
    """A program that is loaded once and forked for each command line, see tests/program/native/fork_before_main.cpp."""

    def __init__(self, path):
        self.path = path
        self.socket, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with other:
            environment = {"LD_PRELOAD": f"{FORKER}:{KILLER}", "FORK_SOCKET": str(other.fileno())}
            self.process = subprocess.Popen([path], env={**os.environ, **environment}, pass_fds=[other.fileno()])

    @staticmethod
    def can_have(environment):
        """Whether a program that is loaded can have these variables: the loader has read its own, and nothing is unloaded."""
        return all(not name.startswith(("LD_", "GLIBC_", "COUNT_")) or (name, value) == ("LD_PRELOAD", KILLER)
                   for name, value in environment.items())

    def receive(self, timeout):
        self.socket.settimeout(timeout)
        message = self.socket.recv(array.array("i").itemsize)
        if not message:
            raise RuntimeError(f"{self.path}: the loaded program has ended")
        return array.array("i", message)[0]

    def run(self, command, folder, timeout, environment):
        """As subprocess.run() with capture_output=True and text=True; the environment is that of this process when the program was
        loaded, and these variables."""
        variables = [f"{name}={value}" for name, value in environment.items() if name != "LD_PRELOAD"]
        message = b"".join(os.fsencode(word) + b"\0" for word in [*variables, "", str(folder), *command])
        with os.fdopen(os.memfd_create("out"), "r+") as out, os.fdopen(os.memfd_create("error"), "r+") as error:
            socket.send_fds(self.socket, [message], [out.fileno(), error.fileno()])
            child = self.receive(timeout)
            try:
                status = self.receive(timeout)
            except TimeoutError:
                os.kill(child, signal.SIGKILL)
                raise subprocess.TimeoutExpired(command, timeout) from None
            out.seek(0)
            error.seek(0)
            return subprocess.CompletedProcess(command, os.waitstatus_to_exitcode(status), out.read(), error.read())

    def end(self):
        self.socket.close()
        try:
            self.process.wait(timeout=10)
        except subprocess.TimeoutExpired:  # it waits for a child
            self.process.kill()
            self.process.wait()


loaded_programs = {}  # of each program one for each thread that runs it


def run_loaded(path, *arguments):
    """LoadedProgram.run() of the program that this thread has loaded, or loads now; one that failed is not asked again."""
    key = (path, threading.get_ident())
    if key not in loaded_programs:
        loaded_programs[key] = LoadedProgram(path)
        unittest.addModuleCleanup(lambda: key in loaded_programs and loaded_programs.pop(key).end())
    try:
        return loaded_programs[key].run(*arguments)
    except BaseException:  # an answer may still be under way, and would be taken for the next one's
        loaded_programs.pop(key).end()
        raise


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

    def run_program(self, *arguments, ranks=None, environment=None, expect=0, timeout=300, afresh=False):
        """Runs noiseloom and returns the finished process; expect=None takes any exit status, afresh=True makes it a process of
        its own, from the first instruction to the last, and a child of this one."""
        command = self.command(*arguments, ranks=ranks)
        environment = environment or {}
        if FORKER and not afresh and ranks is None and arguments and LoadedProgram.can_have(environment):
            program = "noiseloom-study" if arguments[0] in STUDY_COMMANDS else "noiseloom"
            done = run_loaded(BIN / program, command, self.folder, timeout, environment)
        else:
            done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True,
                                  timeout=timeout, cwd=self.folder)
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
        """Another run file with right digests; tests/program/native/rewrite_run_file.cpp says how changes are written."""
        subprocess.run([REWRITER, str(run_file), str(output), *changes], check=True, cwd=self.folder)

    def samples_checksum(self, run_file):
        return self.info(run_file)["checksums"]["/samples"]


def main():
    unittest.main(verbosity=2)
