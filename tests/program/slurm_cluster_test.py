"""The job scripts under a real Slurm of four nodes: what its time limit, cancelling, lost ranks and lost nodes leave of a run.

Skipped where Slurm is not installed (tools/setup --all installs it), and outside of tools/test --all, as it takes a minute."""

import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

from slurm_cluster import Cluster, Job, missing_commands
from support import BIN, SOURCE, THOROUGH, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 17, y = 13, t = 6 }
samples = "tent"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "box", size = 3 } ]
[optimizer]
method = "anneal"
stop = { iterations = 12000 }
"""
TWO_NODES = ("-N", "2", "--ntasks-per-node=1")
ONE_NODE = ("-N", "1", "--ntasks-per-node=2")


def has_pending(pid, number):
    """Whether a suspended process has got a signal that it will see when it goes on."""
    with open(f"/proc/{pid}/status") as status:
        masks = [int(line.split()[1], 16) for line in status if line.startswith(("SigPnd", "ShdPnd"))]
    return any(mask >> (number - 1) & 1 for mask in masks)


class SlurmCluster(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.addClassCleanup(cls.cluster.close)
        cls.straight = cls.new_folder()
        subprocess.run([BIN / "noiseloom", "generate", "run.toml", "-o", "out.h5", "--quiet"], check=True, cwd=cls.straight)
        # What takes Slurm long is begun first, for the last two tests: that it misses a node, and that it looks at its clock
        # and warns of a time limit, up to half a minute after the start of the job, which waits suspended. The limit itself
        # lies far behind the warning, so that the other tests may take their time.
        cls.cut_off = cls.submit_in(cls.new_folder(), *ONE_NODE)
        cls.cut_off.hold("out.h5")
        cls.cluster.kill_node("n3")
        cls.headless = cls.submit_in(cls.new_folder(), "-x", "n3", *ONE_NODE)
        cls.headless.hold("out.h5")
        cls.cluster.kill_daemon("n4")
        cls.limited = cls.submit_in(cls.new_folder(), "-w", "n1", *ONE_NODE, "-t", "9", "--signal=B:USR1@539")
        cls.limited_ranks = cls.limited.hold("out.h5")

    @classmethod
    def new_folder(cls):
        holder = tempfile.TemporaryDirectory(prefix="noiseloom-test-")
        cls.addClassCleanup(holder.cleanup)
        folder = pathlib.Path(holder.name)
        (folder / "run.toml").write_text(CONFIG)
        return folder

    def setUp(self):
        super().setUp()
        self.write("run.toml", CONFIG)

    def submit(self, *options, **variables):
        return self.submit_in(self.folder, "-x", "n3,n4", *options, **variables)

    @classmethod
    def submit_in(cls, folder, *options, **variables):
        return Job(cls.cluster, folder, SOURCE / "slurm" / "generate.sbatch", *options, CONFIG="run.toml", OUTPUT="out.h5",
                   CHECKPOINT_EVERY="0.1s", RETRY_WAITS="3", **variables)

    def ends_well(self, job, restarts=1):
        self.assertEqual(job.wait_for_end(), "COMPLETED", job.said())
        self.assertEqual(job.restarts(), restarts)
        self.assertEqual(job.said().count("starting afresh"), 1, job.said())
        self.has_the_bytes()

    def has_the_bytes(self):
        self.assertEqual(self.samples_checksum("out.h5"), self.samples_checksum(self.straight / "out.h5"))
        self.assertEqual([path.name for path in self.folder.glob("out.h5?*") if path.suffix != ".log"], [],
                         [path.read_text() for path in self.folder.glob("*.log")])

    def test_a_rank_that_is_killed(self):
        job = self.submit(*TWO_NODES)
        ranks = job.hold("out.h5")
        os.kill(ranks[1], signal.SIGKILL)
        job.wait_for_requeue()
        self.assertIn("a rank was killed; queueing again", job.said())
        self.ends_well(job)

    def test_a_rank_that_is_stopped(self):
        job = self.submit(*TWO_NODES, WATCHDOG="2s")
        ranks = job.hold("out.h5")
        os.kill(ranks[0], signal.SIGCONT)
        job.wait_for_requeue()
        self.assertRegex(job.said(), r"rank 1 on \S+ \(process \d+\) has not been heard of")
        self.ends_well(job)

    def test_a_step_whose_manager_is_killed(self):
        """Nobody tells srun of the rank of that node any more. Where the rank gets to its end without, so does the job."""
        job = self.submit(*TWO_NODES, WATCHDOG="2s", SLURM_WAIT="2")
        ranks = job.hold("out.h5")
        self.assertEqual(self.cluster.kill_steps(job.node_of(ranks[1])), 1)
        job.send(ranks, signal.SIGCONT)
        job.wait_for_requeue_or_end()
        self.ends_well(job, job.restarts())

    def test_cancelled(self):
        job = self.submit(*TWO_NODES)
        job.hold("out.h5")
        self.cluster.run("scancel", job.id)  # sends SIGCONT as well
        self.assertEqual(job.wait_for_end(), "CANCELLED")
        self.assertIn("everything is saved in out.h5", job.said())
        self.run_program("generate", "run.toml", "-o", "out.h5", "--resume", "--progress", "none")
        self.has_the_bytes()

    def test_preempted(self):
        job = self.submit(*ONE_NODE, "-w", "n2")
        job.hold("out.h5")
        self.cluster.run("sbatch", "-p", "urgent", "-w", "n2", "--exclusive", "-t", "1", "-D", self.folder, "-o", "urgent.log", "--wrap", "true")
        job.wait_for_requeue()  # Slurm wakes the ranks for the signal
        self.assertIn("stopped by SIGTERM", job.said())
        self.ends_well(job)

    def test_an_array_of_jobs_shares_a_bank(self):
        self.write("bank.toml", 'base = "run.toml"\n[vary]\n"texture.seed" = "1:6"\n')
        self.write("run.toml", CONFIG.replace("12000", "200"))
        job = Job(self.cluster, self.folder, SOURCE / "slurm" / "generate.sbatch", "-x", "n3,n4", "--array=1-2", *TWO_NODES,
                  BANK="bank.toml", OUTPUT="made")
        self.assertEqual(job.wait_for_end(), "COMPLETED", job.said())
        self.run_program("bank", "bank.toml", "-o", "straight", "--quiet")
        made, straight = ((self.folder / name / "index.csv").read_text().splitlines() for name in ("made", "straight"))
        seconds = r",[^,]*(,[0-9a-f]{16},[0-9a-f]{16},)"
        self.assertEqual([re.sub(seconds, r"\1", row) for row in made], [re.sub(seconds, r"\1", row) for row in straight])

    def test_mpirun(self):
        job = self.submit(*ONE_NODE, LAUNCHER="mpirun")
        self.cluster.wait((self.folder / "out.h5").exists, f"out.h5: {job.said()}")
        self.cluster.run("scancel", "--batch", "--signal=USR1", job.id)
        job.wait_for_requeue()
        self.assertIn("stopped with everything saved; queueing again", job.said())
        self.ends_well(job)

    def test_z_the_time_limit(self):
        self.folder, job, ranks = self.limited.folder, self.limited, self.limited_ranks
        self.cluster.wait(lambda: all(has_pending(pid, signal.SIGUSR1) for pid in ranks.values()), "SIGUSR1")
        job.send(ranks, signal.SIGCONT)
        job.wait_for_requeue()
        self.assertIn("stopped by SIGUSR1", job.said())
        self.cluster.run("scontrol", "update", f"JobId={job.id}", "TimeLimit=20")
        self.ends_well(job)

    def test_x_a_node_whose_daemon_is_killed(self):
        self.lives_on_beside_its_successor(self.headless)

    def test_y_a_node_that_is_cut_off(self):
        self.lives_on_beside_its_successor(self.cut_off)

    def lives_on_beside_its_successor(self, job):
        """Started again on another node; the processes that live on change nothing of what it makes."""
        self.folder = job.folder
        job.wait_for_requeue()
        self.ends_well(job)
        finished = (self.folder / "out.h5").read_bytes()
        job.send(job.ranks(), signal.SIGCONT)
        self.cluster.wait(lambda: not job.ranks(), "the end of what was cut off")
        self.assertEqual((self.folder / "out.h5").read_bytes(), finished)


if __name__ == "__main__":
    if not THOROUGH and len(sys.argv) == 1:
        print("skipped: the job scripts under a real Slurm, which tools/test --all tries", file=sys.stderr)
        sys.exit(77)
    if missing := missing_commands():
        print(f"skipped: the job scripts under a real Slurm, as there is no {', '.join(missing)}", file=sys.stderr)
        sys.exit(77)
    try:
        SlurmCluster.cluster = Cluster()
    except (AssertionError, OSError, subprocess.SubprocessError) as error:
        print(f"skipped: the job scripts under a real Slurm, as that which is installed does not start here:\n{error}", file=sys.stderr)
        sys.exit(77)
    main()
