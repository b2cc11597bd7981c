"""kill -9 while computing and at every operation on files; a rerun with --resume ends with the bytes of the undisturbed run."""

import os
import signal
import subprocess
import time

from support import KILLER, ProgramTest, main

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
            # The first checkpoints one operation at a time, then in strides.
            at += 1 if at < 64 else 11
            if at > 200:
                break
        self.assertGreater(killed, 40)

    def under_way(self, ranks):
        command = self.command("generate", self.config, "-o", "out.h5", "--resume", "--checkpoint-every", "0.05s", "--progress",
                               "json", "--set", "optimizer.stop.iterations=4000", ranks=ranks)
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


if __name__ == "__main__":
    main()
