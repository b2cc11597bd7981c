"""The job script, with stand-ins for Slurm's commands: what it does at each exit status of the launcher."""

import os
import signal
import subprocess
import time

from support import BIN, SOURCE, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 8, y = 8, t = 2 }
samples = "uniform"
[filter]
groups  = [ { axes = "xy", kernel = "box", size = 3 } ]
[optimizer]
method = "anneal"
stop = { iterations = 4 }
"""

# The k-th call takes its status from the k-th word of STATUSES (the last one from then on); "signal" waits for USR1 and
# ends with 75. "save:9" changes the output, or the file SAVED, first. "0" finishes what is not finished, and says so;
# "nothing" ends with 0, and nothing was done; with "lost" all was done, and the launcher was killed.
# Bash alone does what it can: to start other programs takes most of the time.
SRUN = """#!/bin/bash
echo "$SRUN_CPUS_PER_TASK $*" >> calls
read -ra statuses <<< "$STATUSES"
mapfile -t calls < calls
k=$((${#calls[@]} - 1))
[ "$k" -lt "${#statuses[@]}" ] || k=$((${#statuses[@]} - 1))
word=${statuses[$k]}
[ "$word" != nothing ] || exit 0
case $word in 0 | lost) [ -n "${BANK:-}" ] || [[ $(noiseloom info "$OUTPUT") == finished* ]] || echo finished >> "$OUTPUT" ;; esac
[ "$word" != lost ] || exit 137
[ "$word" != 0 ] || echo "file  $OUTPUT  /samples 0123456789abcdef"
if [ "$word" = signal ]; then
  trap 'exit 75' USR1
  touch waiting
  while :; do sleep 0.05; done
fi
case $word in save:*) echo "$EPOCHREALTIME" >> "${SAVED:-out.h5}" ;; esac
exit "${word#save:}"
"""
INFO = '#!/bin/bash\nmapfile -t lines < "$2"\n[ "${lines[*]: -1}" = finished ] && echo "finished after 9 iterations" || echo "not finished: iteration 3"\n'
SCONTROL = """#!/bin/bash
[ "$1" != show ] || { echo "JobId=$3 Requeue=1 Restarts=${RESTARTS:-${SLURM_RESTART_COUNT:-0}} BatchFlag=1"; exit; }
echo "$*" >> requeued
"""


class Slurm(ProgramTest):
    def setUp(self):
        super().setUp()
        for name, text in (("srun", SRUN), ("mpirun", SRUN), ("noiseloom", INFO), ("scontrol", SCONTROL)):
            self.write(name, text).chmod(0o755)

    def start(self, statuses, **environment):
        for name in ("calls", "requeued", "waiting"):
            (self.folder / name).unlink(missing_ok=True)
        environment = {**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}", "CONFIG": "a.toml", "OUTPUT": "out.h5",
                       "SLURM_JOB_ID": "17", "SLURM_CPUS_PER_TASK": "8", "STATUSES": statuses, "RETRY_WAITS": "0 0 0", **environment}
        return subprocess.Popen(["bash", SOURCE / "slurm" / "generate.sbatch"], cwd=self.folder, env=environment,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def lines(self, name):
        path = self.folder / name
        return path.read_text().splitlines() if path.exists() else []

    def job(self, statuses, **environment):
        """Exit status, number of steps, whether the job was queued again."""
        process = self.start(statuses, **environment)
        output = process.communicate(timeout=60)[0]
        requeued = self.lines("requeued")
        self.assertIn(requeued, ([], ["requeue 17"]), output)
        return process.returncode, len(self.lines("calls")), bool(requeued)

    def test_what_follows_each_status(self):
        self.assertEqual(self.job("0"), (0, 1, False))
        self.assertEqual(self.job("75"), (0, 1, True))
        self.assertEqual(self.job("76"), (0, 1, True))
        self.assertEqual(self.job("2"), (2, 1, False))

    def test_processors_of_a_rank_reach_the_step(self):
        self.job("0")
        self.assertRegex(self.lines("calls")[0], r"^8 --mpi=pmix .*noiseloom generate a.toml -o out.h5 --resume --threads 8 ")
        self.job("0", LAUNCHER="mpirun")
        self.assertRegex(self.lines("calls")[0], r"^8 --map-by slot:PE=8 noiseloom generate ")

    def test_a_step_that_fails_at_once_is_tried_again_and_not_for_ever(self):
        self.assertEqual(self.job("1 1 0"), (0, 3, False))
        self.assertEqual(self.job("1"), (1, 4, False))

    def test_a_step_that_is_killed_at_once_with_nothing_saved_is_tried_again(self):
        """So ends one that finds the socket of a step of its number whose manager was killed."""
        self.assertEqual(self.job("137 0"), (0, 2, False))
        (self.folder / "out.h5").unlink()
        self.assertEqual(self.job("137 save:137 0"), (0, 2, True))

    def test_a_launcher_that_says_done_is_not_believed_while_the_output_is_not(self):
        """srun ends with 0 where the node's daemon could not start the step at all."""
        for statuses, then in (("nothing 75", (0, 2, True)), ("nothing", (1, 4, False)), ("nothing 0", (0, 2, False))):
            self.assertEqual(self.job(statuses), then)
        self.write("out.h5", "begun\n")
        self.assertEqual(self.job("lost"), (0, 1, False))  # done, and srun was killed since
        made = self.folder / "made"
        made.mkdir()
        bank = {"BANK": "bank.toml", "OUTPUT": "made"}
        self.assertEqual(self.job("0", **bank), (1, 4, False))
        for states, status in ((("done", "begun"), 1), (("open", "done"), 1), (("done", "done"), 0)):
            (made / "index.json").write_text("[\n" + ",\n".join(f'{{"name": "{k}", "state": "{s}"}}' for k, s in enumerate(states)) + "\n]\n")
            self.assertEqual(self.job("0", **bank)[0], status, states)

    def test_an_output_that_was_finished_before_says_nothing_of_this_job(self):
        """It may be of another config; noiseloom alone can tell."""
        self.write("out.h5", "finished\n")
        self.assertEqual(self.job("1"), (1, 4, False))
        self.assertEqual(self.job("nothing"), (1, 4, False))
        self.assertEqual(self.job("137"), (0, 4, True))
        self.assertEqual(self.job("2"), (2, 1, False))
        self.assertEqual(self.job("1 nothing 0"), (0, 3, False))
        self.assertEqual(self.lines("out.h5"), ["finished"])

    def test_what_a_launcher_that_starts_nothing_leaves_undone_is_told(self):
        """With noiseloom itself: of another config, and of a bank that has got more members since."""
        (self.folder / "noiseloom").unlink()
        self.write("a.toml", CONFIG)
        path = f"{self.folder}:{BIN}:{os.environ['PATH']}"
        self.assertEqual(self.job("", LAUNCHER="env", PATH=path, TMPDIR="/nowhere", OUTPUT="elsewhere.h5"), (0, 0, False))
        bank = {"BANK": "bank.toml", "OUTPUT": "made"}
        for output in ({}, bank):
            self.write("bank.toml", 'base = "a.toml"\n[vary]\n"texture.seed" = "1:2"\n')
            for launcher, status in (("env", 0), ("env", 0), ("true", 1), ("false", 1)):
                self.assertEqual(self.job("", LAUNCHER=launcher, PATH=path, **output), (status, 0, False), (launcher, output))
        self.write("bank.toml", 'base = "a.toml"\n[vary]\n"texture.seed" = "1:3"\n')
        self.assertEqual(self.job("", LAUNCHER="false", PATH=path, **bank), (1, 0, False))
        self.assertEqual(self.job("", LAUNCHER="env", PATH=path, **bank), (0, 0, False))
        self.write("a.toml", CONFIG.replace("[texture]", "[texture]\nseed = 5"))
        self.assertEqual(self.job("", LAUNCHER="env", PATH=path), (2, 0, False))

    def test_jobs_that_save_something_are_queued_again_however_often(self):
        for status in ("save:137", "save:75"):
            for restarts in range(6):
                self.assertEqual(self.job(status, SLURM_RESTART_COUNT=str(restarts)), (0, 1, True))

    def test_a_bank_has_saved_something_wherever_it_came_further(self):
        made = self.folder / "made"
        made.mkdir()
        self.write("made/index.csv", "".join(f"seed{seed},begun,,0.5,0123456789abcdef,0123456789abcdef,{seed}\n" for seed in range(2000)))
        self.write("made/seed7.h5", "begun")
        bank = {"BANK": "bank.toml", "OUTPUT": "made"}
        for saved in ("made/seed7.h5", "made/seed8.h5", "made/index.csv"):  # within a member, a new one, far down the index
            for _ in range(2):
                self.assertEqual(self.job("save:137", **bank, SAVED=saved, MAX_RESTARTS="0"), (0, 1, True), saved)
        self.assertEqual(self.job("137", **bank, MAX_RESTARTS="0"), (137, 4, False))

    def test_jobs_in_a_row_that_save_nothing_come_to_an_end(self):
        for status, steps in ((137, 4), (75, 1)):
            for _ in range(3):
                self.assertEqual(self.job(str(status), SLURM_RESTART_COUNT="30"), (0, steps, True))
            self.assertEqual(self.job(str(status)), (status, steps, False))
            self.assertEqual(list(self.folder.glob("*fruitless*")), [])
        self.assertEqual(self.job("137", MAX_RESTARTS="0"), (137, 4, False))

    def test_a_job_that_saves_something_ends_the_row(self):
        for status in ("137", "137", "save:137", "137", "75", "137"):
            self.assertEqual(self.job(status), (0, 4 if status == "137" else 1, True))
        self.assertEqual(self.job("137"), (137, 4, False))
        self.job("137")
        self.assertEqual(self.job("0"), (0, 1, False))
        self.assertEqual(list(self.folder.glob("*fruitless*")), [])

    def test_a_job_that_cannot_be_queued_again_says_what_to_do(self):
        self.write("scontrol", "#!/usr/bin/env bash\n[ $1 != show ] || exit 1\necho 'Requested operation is presently disabled' >&2; exit 1\n").chmod(0o755)
        process = self.start("save:75")
        output = process.communicate(timeout=60)[0]
        self.assertEqual(process.returncode, 75, output)
        self.assertIn("submit it once more", output)

    def test_a_script_on_a_node_that_was_given_up_starts_nothing_more(self):
        """The job has begun again elsewhere, and would be queued again under its own hands."""
        for statuses, steps in (("1 0", 1), ("137", 1), ("75", 1)):
            self.assertEqual(self.job(statuses, RESTARTS="1"), (75, steps, False))
        self.assertEqual(self.job("137", RESTARTS="1", SLURM_RESTART_COUNT="1"), (0, 4, True))

    def test_the_warning_of_the_time_limit_is_passed_on(self):
        process = self.start("signal")
        while not (self.folder / "waiting").exists():
            time.sleep(0.02)
        process.send_signal(signal.SIGUSR1)
        output = process.communicate(timeout=60)[0]
        self.assertEqual((process.returncode, self.lines("requeued")), (0, ["requeue 17"]), output)


if __name__ == "__main__":
    main()
