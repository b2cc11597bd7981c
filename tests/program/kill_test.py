"""kill -9 while computing and at every operation on files; a rerun with --resume ends with the bytes of the undisturbed run."""

import os
import signal
import subprocess
import time

from support import BIN, KILLER, THOROUGH, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 17, y = 13, t = 5 }
samples = "tent"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 600 }
"""


# Of the first publishing its last operations, of the second some of the writing and all that gives names.
STOPS = (30, 36, 37, 38, 45, *range(76, 88))


class Kill(ProgramTest):
    def setUp(self):
        super().setUp()
        self.config = self.write("run.toml", CONFIG)
        self.run_program("generate", self.config, "-o", "straight.h5", "--progress", "none")
        self.expected = self.samples_checksum("straight.h5")

    def resume(self, output, ranks=None):
        self.run_program("generate", self.config, "-o", output, "--resume", "--progress", "none", ranks=ranks)
        self.assertEqual(self.samples_checksum(output), self.expected)
        leftovers = [p.name for p in self.folder.iterdir() if p.name.startswith(output) and "tmp" in p.name]
        self.assertEqual(leftovers, [])

    def test_at_every_file_operation(self):
        # Many checkpoints in a short run, so that every operation happens with and without a generation before it.
        output = "out.h5"
        arguments = ("generate", self.config, "-o", output, "--resume", "--checkpoint-every", "0.02s", "--progress", "none")
        killed = 0
        at = 1
        while True:
            for path in self.folder.glob(output + "*"):
                path.unlink()
            done = self.run_program(*arguments, expect=None,
                                    environment={"LD_PRELOAD": KILLER, "KILL_AT": str(at), "KILL_PART": self.folder.name})
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
            killed += 1
            self.resume(output)
            # The first checkpoints one operation at a time (elsewhere every third one, which comes to all kinds), then in strides.
            at += 11 if at >= 64 else 1 if THOROUGH else 3
            if at > 200:
                break
        self.assertGreater(killed, 40 if THOROUGH else 20)

    def test_asked_to_stop_at_any_operation_of_a_save(self):
        for at in STOPS[::3]:
            with self.subTest(at):
                done = self.run_program("generate", self.config, "-o", f"{at}.h5", "--checkpoint-every", "0.001s", "--progress", "none", expect=75,
                                        environment={"LD_PRELOAD": KILLER, "KILL_AT": str(at), "KILL_PART": self.folder.name,
                                                     "KILL_SIGNAL": str(int(signal.SIGTERM))})
                self.assertIn("stopped by SIGTERM", done.stdout + done.stderr)
                self.resume(f"{at}.h5")

    def test_a_superseded_run_overwrites_nothing_wherever_it_was_stopped(self):
        """Suspended at an operation of its publishing, superseded by the next start of its job, then woken up."""
        output = "out.h5"
        arguments = [str(BIN / "noiseloom"), "generate", self.config, "-o", output, "--resume", "--checkpoint-every", "0.02s",
                     "--progress", "none"]
        job = {**os.environ, "SLURM_JOB_ID": "7", "SLURM_RESTART_COUNT": "0"}
        stopped = 0
        for at in STOPS:
            for path in self.folder.glob(output + "*"):
                path.unlink()
            old = subprocess.Popen(arguments, cwd=self.folder, stderr=subprocess.PIPE, text=True,
                                   env={**job, "LD_PRELOAD": KILLER, "KILL_AT": str(at), "KILL_PART": self.folder.name,
                                        "KILL_SIGNAL": str(int(signal.SIGSTOP))})
            _, how = os.waitpid(old.pid, os.WUNTRACED)
            if os.WIFEXITED(how) and os.WEXITSTATUS(how) == 0:  # a machine on which the run is over before so many operations
                old.communicate(timeout=60)
                break
            self.assertTrue(os.WIFSTOPPED(how), at)
            stopped += 1
            self.run_program(*arguments[1:], environment={"SLURM_JOB_ID": "7", "SLURM_RESTART_COUNT": "1"})
            newer = (self.folder / output).read_bytes()
            old.send_signal(signal.SIGCONT)
            said = old.communicate(timeout=60)[1]
            self.assertEqual(old.returncode, 1, f"{at}: {said}")
            self.assertEqual((self.folder / output).read_bytes(), newer, at)
            self.assertEqual([p.name for p in self.folder.glob("*tmp-*")], [], at)
        self.assertGreater(stopped, 4)
        self.assertEqual(self.samples_checksum(output), self.expected)

    def under_way(self, ranks, iterations=4000, *further):
        command = self.command("generate", self.config, "-o", "out.h5", "--resume", "--checkpoint-every", "0.05s", "--progress",
                               "json", "--set", f"optimizer.stop.iterations={iterations}", *further, ranks=ranks)
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=self.folder)
        for line in process.stderr:
            if "saved" in line:
                return process
        self.fail("ended before its first checkpoint")

    def ranks_of(self, process):
        """Process ids of the noiseloom processes below a launcher."""
        found = []
        todo = [process.pid]
        while todo:
            pid = todo.pop()
            for task in os.listdir(f"/proc/{pid}/task"):
                with open(f"/proc/{pid}/task/{task}/children") as children:
                    below = [int(child) for child in children.read().split()]
                found += below
                todo += below
        return found

    def finish(self, process):
        process.stderr.read()
        process.wait(timeout=60)
        process.stderr.close()

    def test_one_rank_and_all_ranks_while_computing(self):
        long_run = ("--set", "optimizer.stop.iterations=4000")
        self.run_program("generate", self.config, "-o", "long.h5", "--progress", "none", *long_run)
        expected = self.samples_checksum("long.h5")
        for victims in ("one", "all"):
            with self.subTest(victims):
                process = self.under_way(ranks=3)
                ranks = self.ranks_of(process)
                self.assertEqual(len(ranks), 3)
                for pid in ranks[1:2] if victims == "one" else ranks:
                    os.kill(pid, signal.SIGKILL)
                self.finish(process)
                self.assertNotEqual(process.returncode, 0)
        self.run_program("generate", self.config, "-o", "out.h5", "--resume", "--progress", "none", *long_run, ranks=2)
        self.assertEqual(self.samples_checksum("out.h5"), expected)

    def test_a_rank_that_is_stopped_ends_the_run_by_name(self):
        for victim in (1, 0):
            with self.subTest(victim):
                # Each rank that waits for the stopped one keeps a processor busy.
                process = self.under_way(3 if THOROUGH else 2, 10_000_000, "--watchdog", "2s")
                ranks = {self.rank_of(pid): pid for pid in self.ranks_of(process)}
                os.kill(ranks[victim], signal.SIGSTOP)
                said = process.stderr.read()
                process.wait(timeout=60)
                process.stderr.close()
                self.assertEqual(process.returncode, 76, said)
                self.assertRegex(said, rf"rank {victim} on .* \(process {ranks[victim]}\) has not been heard of for .*its last word")
                self.info("out.h5")  # what was saved last is whole

    def rank_of(self, pid):
        with open(f"/proc/{pid}/environ") as environment:
            variables = dict(entry.split("=", 1) for entry in environment.read().split("\0") if "=" in entry)
        return int(variables.get("OMPI_COMM_WORLD_RANK", variables.get("PMI_RANK", "-1")))

    def test_a_job_that_is_suspended_as_a_whole_goes_on(self):
        process = self.under_way(2, 10_000_000, "--watchdog", "2s")
        ranks = self.ranks_of(process)
        for pid in ranks:
            os.kill(pid, signal.SIGSTOP)
        time.sleep(4)
        for pid in ranks:
            os.kill(pid, signal.SIGCONT)
        time.sleep(1)
        os.kill(ranks[1], signal.SIGUSR1)
        self.finish(process)
        self.assertEqual(process.returncode, 75)


if __name__ == "__main__":
    main()
