"""What ends a run early leaves it saved: signals at any time, a reader that goes away, a disk that fails for a while."""

import os
import pathlib
import re
import signal
import subprocess
import time

from support import ProgramTest, main

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
CONSTRUCTED = """
[texture]
size    = { x = 48, y = 48, t = 4 }
samples = "uniform"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "gauss", sigma = 1.0 }, { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 } ]
[optimizer]
method = "construct"
stop   = { iterations = 1000 }
"""
# Of circles whose slices act on each other the sharpness takes 18 constructions to find, as large as this one.
SOUGHT = """
[texture]
size    = { x = 24, y = 24, t = 16 }
samples = "circle"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "gauss", sigma = 4.0 }, { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 } ]
[optimizer]
method = "construct"
"""
LONG = ("--set", "optimizer.stop.iterations=1000000")


class Stop(ProgramTest):
    def setUp(self):
        super().setUp()
        self.config = self.write("run.toml", CONFIG)

    def start(self, *arguments, ranks=None, output="out.h5", **options):
        command = self.command("generate", self.config, "-o", output, "--progress", "json", *arguments, ranks=ranks)
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=self.folder, **options)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def wait_for(self, process, words):
        seen = []
        for line in process.stderr:
            seen.append(line)
            if words in line:
                return seen
        self.fail(f"ended without saying {words!r}: {seen}")

    def ended(self, process, status):
        """What a process has still to say; it must end with this status."""
        output, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, status, errors)
        return errors

    def test_every_signal_that_means_stop(self):
        self.run_program("generate", self.config, "-o", "straight.h5", "--quiet")
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1, signal.SIGUSR2, signal.SIGHUP, signal.SIGXCPU, signal.SIGPIPE):
            with self.subTest(number.name):
                process = self.start(*LONG, "--overwrite")
                self.wait_for(process, '"iterations"')
                process.send_signal(number)
                errors = self.ended(process, 75)
                self.assertIn(f"stopped by {number.name} at iteration", errors)
                self.run_program("info", "out.h5")

    def test_a_stop_goes_on_to_the_bytes_of_the_straight_run(self):
        long_run = ("--set", "optimizer.stop.iterations=4000")
        self.run_program("generate", self.config, "-o", "straight.h5", "--quiet", *long_run)
        process = self.start(*long_run)
        self.wait_for(process, '"iterations"')
        process.send_signal(signal.SIGHUP)
        self.ended(process, 75)
        self.run_program("generate", self.config, "-o", "out.h5", "--resume", "--quiet", *long_run)
        self.assertEqual(self.samples_checksum("out.h5"), self.samples_checksum("straight.h5"))

    def test_signals_every_fifty_milliseconds(self):
        """Whatever a run is at, it saves once and ends; the next one goes on."""
        long_run = ("--set", "optimizer.stop.iterations=6000")
        self.run_program("generate", self.config, "-o", "straight.h5", "--quiet", *long_run)
        stops = 0
        for _ in range(100):
            process = self.start(*long_run, *(("--resume",) if stops > 0 else ()))
            self.wait_for(process, '"iterations"')
            while process.poll() is None:
                time.sleep(0.05)
                process.send_signal((signal.SIGUSR1, signal.SIGTERM, signal.SIGHUP)[stops % 3])
            if process.returncode == 0:
                break
            self.ended(process, 75)
            stops += 1
        self.assertGreater(stops, 0)
        self.assertEqual(process.returncode, 0, self.run_program("info", "out.h5").stdout)
        self.assertEqual(self.samples_checksum("out.h5"), self.samples_checksum("straight.h5"))

    def test_a_stop_within_the_trials_of_annealing_keeps_what_was_constructed(self):
        # Trials tell how hot annealing may begin; they come after the construction and have no step of their own.
        self.config = self.write("constructed.toml", CONSTRUCTED)
        self.run_program("generate", self.config, "-o", "straight.h5", "--quiet")
        for ranks in (None, 2):
            with self.subTest(ranks=ranks):
                process = self.start("--overwrite", ranks=ranks)
                self.wait_for(process, '"phase": "done"')
                process.send_signal(signal.SIGUSR1)
                errors = self.ended(process, 75)
                self.assertIn("stopped by SIGUSR1 at the end of the construction", errors)
                self.assertNotIn('"iterations"', errors)
                self.run_program("generate", self.config, "-o", "out.h5", "--resume", "--quiet")
                self.assertEqual(self.samples_checksum("out.h5"), self.samples_checksum("straight.h5"))

    def stop_in_the_search(self, *arguments, ranks=None, pid_of=lambda process: process.pid):
        """What is said by a run that gets a signal while it looks for a sharpness: after the lock, before it says what it is."""
        lock = self.folder / "out.h5.lock"
        lock.unlink(missing_ok=True)
        process = self.start(*arguments, ranks=ranks)
        while not lock.exists():
            self.assertIsNone(process.poll())
            time.sleep(0.01)
        time.sleep(0.2)
        os.kill(pid_of(process), signal.SIGUSR1)
        errors = self.ended(process, 75)
        self.assertNotIn('"start"', errors, "the search went on to its end")
        return errors

    def test_a_stop_within_the_search_for_a_sharpness(self):
        self.config = self.write("sought.toml", SOUGHT)
        self.run_program("generate", self.config, "-o", "straight.h5", "--quiet")
        for ranks in (None, 2):
            with self.subTest(ranks=ranks):
                errors = self.stop_in_the_search(ranks=ranks)
                self.assertIn("stopped by SIGUSR1 before anything was computed; there is nothing to save yet", errors)
                self.assertFalse((self.folder / "out.h5").exists())
        # A run that was under way looks for its sharpness again, and is as it was where that is stopped.
        self.run_program("generate", self.config, "-o", "out.h5", "--resume", "--time-limit", "0.001s", expect=75)
        before = (self.folder / "out.h5").read_bytes()
        errors = self.stop_in_the_search("--resume")
        self.assertIn("stopped by SIGUSR1 before anything was computed; out.h5 is as it was", errors)
        self.assertEqual((self.folder / "out.h5").read_bytes(), before)
        self.run_program("generate", self.config, "-o", "out.h5", "--resume", "--quiet")
        self.assertEqual(self.samples_checksum("out.h5"), self.samples_checksum("straight.h5"))

    def test_a_stop_of_one_rank_within_the_search_is_one_of_all(self):
        self.config = self.write("sought.toml", SOUGHT)

        def last_rank(launcher):
            threads = pathlib.Path(f"/proc/{launcher.pid}/task").iterdir()
            children = [int(pid) for thread in threads for pid in (thread / "children").read_text().split()]
            self.assertEqual(len(children), 2)
            return max(children)

        errors = self.stop_in_the_search(ranks=2, pid_of=last_rank)
        self.assertRegex(errors, "stopped by (SIGUSR1|a signal to another rank) before anything was computed")
        self.assertFalse((self.folder / "out.h5").exists())

    def test_a_signal_before_the_start(self):
        # As soon as the handler is in place, which is long before MPI is: nothing is saved, and that is said.
        process = self.start()
        while True:
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
            caught = int(re.search(r"SigCgt:\s+([0-9a-f]+)", status)[1], 16)
            if caught >> (signal.SIGUSR1 - 1) & 1 and "noiseloom" in status:
                break
        process.send_signal(signal.SIGUSR1)
        errors = self.ended(process, 75)
        self.assertIn("SIGUSR1", errors)
        self.assertIn("nothing to save", errors)
        self.assertFalse((self.folder / "out.h5").exists())
        self.run_program("generate", self.config, "-o", "out.h5", "--resume")

    def test_nohup_keeps_a_run_alive(self):
        process = self.start("--set", "optimizer.stop.iterations=20000", preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        self.wait_for(process, '"iterations"')
        process.send_signal(signal.SIGHUP)
        self.ended(process, 0)

    def test_ranks_stop_together(self):
        process = self.start(*LONG, ranks=3)
        self.wait_for(process, '"iterations"')
        process.send_signal(signal.SIGUSR1)  # mpirun passes it on to every rank
        errors = self.ended(process, 75)
        self.assertEqual(errors.count("everything is saved"), 1)
        self.assertIn("it means exit status 75", errors)

    def test_a_log_that_nobody_reads_any_more(self):
        command = " ".join(str(word) for word in self.command("generate", self.config, "-o", "out.h5", "--progress", "json", *LONG))
        done = subprocess.run(["bash", "-c", f"{command} 2>&1 | head -3; exit ${{PIPESTATUS[0]}}"], cwd=self.folder, capture_output=True,
                              text=True, timeout=60)
        self.assertEqual(done.returncode, 75, done.stdout + done.stderr)
        self.assertEqual(len(done.stdout.splitlines()), 3)
        self.run_program("info", "out.h5")

    def test_a_result_that_nobody_reads(self):
        command = " ".join(str(word) for word in self.command("generate", self.config, "-o", "out.h5", "--progress", "none"))
        for redirection in ("| true", ">&-", ">/dev/full"):
            with self.subTest(redirection):
                done = subprocess.run(["bash", "-c", f"{command} --overwrite {redirection}; exit ${{PIPESTATUS[0]}}"], cwd=self.folder,
                                      capture_output=True, text=True, timeout=60)
                self.assertEqual(done.returncode, 0, done.stderr)
                if redirection != "| true":  # the pipe may close late
                    self.assertIn("the run file is complete", done.stderr)
                self.assertEqual(self.info("out.h5")["state"]["finished"], "iterations")

    def test_a_log_that_cannot_be_written(self):
        self.run_program("generate", self.config, "-o", "straight.h5", "--quiet")
        command = " ".join(str(word) for word in self.command("generate", self.config, "-o", "out.h5", "--progress", "json"))
        for redirection in ("2>&-", "2>/dev/full", "2>&- >&- <&-"):
            with self.subTest(redirection):
                done = subprocess.run(["bash", "-c", f"{command} --overwrite {redirection}"], cwd=self.folder, capture_output=True,
                                      text=True, timeout=60)
                self.assertEqual(done.returncode, 0, done.stderr)
                # No message has found its way into a file that took the free number.
                self.assertEqual(self.samples_checksum("out.h5"), self.samples_checksum("straight.h5"))
        # Faults that cannot be printed keep their exit status.
        done = subprocess.run(["bash", "-c", f"{command} 2>/dev/full"], cwd=self.folder, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)

    def test_a_printed_result_that_is_lost_is_an_error(self):
        self.run_program("generate", self.config, "-o", "out.h5", "--quiet")
        for words in (("info", "out.h5"), ("info", "out.h5", "--json"), ("plan", "run.toml"), ("--help",), ("--version",), ("--help-config",),
                      ("generate", "--help"), ("info", "--help")):
            for redirection in (">/dev/full", ">&-"):
                with self.subTest(" ".join(words) + redirection):
                    command = " ".join(str(word) for word in self.command(*words))
                    done = subprocess.run(["bash", "-c", f"{command} {redirection}"], cwd=self.folder, capture_output=True, text=True, timeout=60)
                    self.assertEqual(done.returncode, 1, done.stderr)
                    self.assertIn("standard output", done.stderr)

    def test_a_checkpoint_that_fails_is_tried_again(self):
        # The folder goes away for a while, as a network file system does.
        (self.folder / "disk").mkdir()
        process = self.start(*LONG, "--checkpoint-every", "0.05s", output="disk/out.h5")
        self.wait_for(process, "saved at")
        (self.folder / "disk").rename(self.folder / "gone")
        lines = self.wait_for(process, "WARNING: not saved at")
        self.assertIn("still saved: iteration", lines[-1])
        (self.folder / "gone").rename(self.folder / "disk")
        self.wait_for(process, '"saved at')
        process.send_signal(signal.SIGTERM)
        self.ended(process, 75)
        self.run_program("info", "disk/out.h5")

    def test_only_the_last_save_must_succeed(self):
        (self.folder / "disk").mkdir()
        process = self.start(*LONG, "--checkpoint-every", "0.05s", output="disk/out.h5")
        self.wait_for(process, "saved at")
        (self.folder / "disk").rename(self.folder / "gone")
        self.wait_for(process, "WARNING: not saved at")
        process.send_signal(signal.SIGTERM)
        errors = self.ended(process, 1)
        self.assertIn("is not saved; what was saved last is whole: iteration", errors)
        self.run_program("info", "gone/out.h5")

    def test_the_generation_before_goes_when_a_run_is_over(self):
        self.run_program("generate", self.config, "-o", "out.h5", "--checkpoint-every", "0.001s", "--quiet")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["out.h5", "run.toml"])

    def test_a_file_of_somebody_else_at_the_name_of_the_generation_before(self):
        self.run_program("generate", self.config, "-o", "out.h5", "--quiet")
        foreign = self.write("out.h5.prev", "a letter\n")
        done = self.run_program("generate", self.config, "-o", "out.h5", "--resume")
        self.assertIn("out.h5.prev: is no generation of this run file, and is left as it is", done.stderr)
        self.assertEqual(foreign.read_text(), "a letter\n")
        # A run that would have to replace it does not begin.
        done = self.run_program("generate", self.config, "-o", "out.h5", "--overwrite", expect=2)
        self.assertIn("out.h5.prev", done.stderr)
        self.assertEqual(foreign.read_text(), "a letter\n")

    def test_only_the_generation_before_is_left(self):
        self.run_program("generate", self.config, "-o", "out.h5", "--time-limit", "0.001s", expect=75)
        (self.folder / "out.h5").rename(self.folder / "out.h5.prev")
        before = (self.folder / "out.h5.prev").read_bytes()
        for words in (("generate", self.config, "-o", "out.h5"), ("info", "out.h5")):
            done = self.run_program(*words, expect=2)
            self.assertIn("out.h5.prev", done.stderr)
            self.assertIn("--resume", done.stderr)
            self.assertEqual((self.folder / "out.h5.prev").read_bytes(), before)
        self.run_program("generate", self.config, "-o", "out.h5", "--resume")
        self.assertEqual(self.info("out.h5")["state"]["finished"], "iterations")

    def test_processes_that_do_not_find_each_other(self):
        # What N processes look like whose launcher speaks another process interface than their MPI library.
        environment = {"SLURM_STEP_NUM_TASKS": "4"}
        process = self.start(*LONG, env={**os.environ, **environment})
        lines = self.wait_for(process, '"iterations"')
        warning = "".join(line for line in lines if "WARNING" in line)
        self.assertIn("4 processes", warning)
        self.assertIn("PMIx", warning)
        for variables in (environment, {}):
            done = self.run_program("generate", self.config, "-o", "out.h5", environment=variables, expect=2)
            self.assertIn("another run is writing it", done.stderr)
            self.assertIn("PMIx", done.stderr)

    def test_too_little_memory_is_said_in_words(self):
        import resource

        def little_memory():
            resource.setrlimit(resource.RLIMIT_AS, (450_000_000, 450_000_000))

        done = subprocess.run(self.command("generate", self.config, "-o", "out.h5", "--threads", "1", "--set", "texture.size={x=4096,y=4096,t=5}"),
                              cwd=self.folder, capture_output=True, text=True, timeout=60, preexec_fn=little_memory)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("out of memory while", done.stderr)
        self.assertIn("ulimit -v", done.stderr)
        self.assertNotIn("bad_alloc", done.stderr)


if __name__ == "__main__":
    main()
