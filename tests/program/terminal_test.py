"""What a person and a script see: help, plan, progress, summary, stop rules."""

import json
import re
import subprocess
import time

from support import ProgramTest, main

CONFIG = """
[texture]
size    = { x = 16, y = 16, t = 6 }
samples = "uniform"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "box", size = 2 } ]
[optimizer]
method = "anneal"
stop = { iterations = 64 }
"""


class Terminal(ProgramTest):
    def setUp(self):
        super().setUp()
        self.config = self.write("run.toml", CONFIG)

    def generate(self, *arguments, **options):
        return self.run_program("generate", self.config, "-o", "run.h5", "--overwrite", *arguments, **options)

    def test_help_names_every_command_and_option(self):
        text = self.run_program("--help").stdout
        for word in ("generate", "plan", "info", "export", "score", "analyze", "--resume", "75"):
            self.assertIn(word, text)
        text = self.run_program("generate", "--help").stdout
        for word in ("--set", "--resume", "--overwrite", "--time-limit", "--checkpoint-every", "--threads", "--progress", "--quiet", "HUP"):
            self.assertIn(word, text)
        text = self.run_program("--help-config").stdout
        for word in ("texture.size", "hemisphere-cosine", "rejection", "optimizer.stop"):
            self.assertIn(word, text)
        for words in ("--version", "-V", "version"):
            self.assertRegex(self.run_program(words).stdout, r"^noiseloom \d+\.\d+\.\d+\n$")
        self.assertEqual(self.run_program("help", "info").stdout, self.run_program("info", "--help").stdout)
        for command in ("plan", "info", "export", "score", "analyze"):
            self.assertIn(command, self.run_program(command, "--help").stdout)

    def test_plan_counts_what_the_run_sends(self):
        text = self.run_program("plan", self.config, "--ranks", 3).stdout
        # box 2 reaches one slice: each rank of two slices tells both neighbours.
        self.assertIn("6 slice updates a sweep", text)
        self.assertRegex(text, r"rank +0 +2 slices, 2 halo slices")
        self.assertRegex(text, r"memory +at most [\d.]+ [KM]iB a rank of 1 thread")
        self.assertRegex(text, r"time +about [\d.]+ s for 64 iterations")
        alone = self.run_program("plan", self.config, "--ranks", 3, "--set",
                                 'filter.groups=[{axes="xy",kernel="box",size=3}]').stdout
        self.assertIn("none: slices are not coupled", alone)
        self.assertIn("t: off", alone)
        self.assertRegex(text, r"background other slices act through 8 \(7\.\d %\), 32 \(1\.\d %\), 64 \(0\.\d+ %\)")
        self.assertNotIn("background", alone)
        self.assertFalse((self.folder / "run.h5").exists())

    def test_json_progress_is_one_stream(self):
        """From the first line to the summary, on one descriptor, whatever else is printed."""
        self.generate("--progress", "json", "--progress-to", "progress", ranks=2)
        lines = [json.loads(line) for line in (self.folder / "progress").read_text().splitlines()]
        self.assertEqual((lines[0]["event"], lines[0]["ranks"], lines[-1]["event"]), ("start", 2, "summary"))
        self.assertEqual(lines[-1]["checksum"], self.samples_checksum("run.h5"))
        reports = [line for line in lines if line["event"] == "progress"]
        self.assertLessEqual({"relative_error", "seconds_left", "seconds_since_save", "bytes_sent", "slowest_rank", "fastest_rank"},
                             reports[-1].keys())
        self.assertGreater(reports[-1]["bytes_sent"], 0)
        for report in reports:
            self.assertTrue(0 <= report["fastest_computed"] <= report["slowest_computed"] <= 1, report)
        self.assertIn("nowhere/progress: cannot write progress",
                      self.run_program("generate", self.config, "-o", "x.h5", "--progress-to", "nowhere/progress", ranks=2, expect=1).stderr)

    def test_json_progress_and_summary(self):
        done = self.generate("--progress", "json")
        lines = [json.loads(line) for line in done.stderr.splitlines()]
        rows = [line for line in lines if line["event"] == "progress"]
        self.assertGreater(len(rows), 1)
        self.assertLess(rows[-1]["relative_error"], rows[0]["relative_error"])
        for key in ("iterations", "temperature", "acceptance", "candidates_per_second", "seconds", "seconds_left"):
            self.assertIn(key, rows[-1])
        self.assertRegex(done.stdout, r"R +0\.\d+ +\(white noise 1")
        self.assertIn(self.samples_checksum("run.h5"), done.stdout)
        self.assertIn("noiseloom export run.h5", done.stdout)

    def test_no_bar_without_a_terminal_and_silence_on_request(self):
        self.assertNotIn("\r", self.generate("--progress", "auto").stderr)
        done = self.generate("--progress", "none")
        self.assertIn(self.samples_checksum("run.h5"), done.stdout)
        self.assertEqual(done.stderr, "")
        done = self.generate("--quiet")
        self.assertEqual((done.stdout, done.stderr), ("", ""))
        done = self.generate("--progress", "none", "--time-limit", "0.001s", expect=75)
        self.assertIn("stopped by --time-limit at iteration", done.stderr)
        done = self.generate("--quiet", "--time-limit", "0.001s", expect=75)
        self.assertEqual((done.stdout, done.stderr), ("", ""))

    def test_results_of_all_commands_are_asked_for_alike(self):
        general = self.run_program("--help").stdout
        for command in set(re.findall(r"^  noiseloom ([a-z][-a-z]*) ", general, re.MULTILINE)):
            text = self.run_program(command, "--help").stdout
            self.assertRegex(text, r"--quiet +print nothing but warnings and errors, not even the result", command)
            self.assertRegex(text, r"--json +the result as one JSON object", command)
        result = json.loads(self.generate("--progress", "none", "--json").stdout)
        self.assertEqual(result["output"], "run.h5")
        info = self.info("run.h5")
        self.assertEqual(result["checksum"], info["checksums"]["/samples"])
        self.assertEqual(result["relative_error"], info["state"]["relative_error"])
        for words in (["info", "run.h5"], ["plan", self.config], ["export", "run.h5", "-o", "x.npy", "--overwrite"],
                      ["score", "run.h5"], ["verify", "run.h5"], ["compare", "run.h5", "run.h5"],
                      ["analyze", "run.h5", "-o", "report", "--overwrite"]):
            self.assertEqual(self.run_program(*words, "--quiet", expect=None).stdout, "", words)
            self.assertIsInstance(json.loads(self.run_program(*words, "--json", expect=None).stdout), dict, words)

    def test_the_start_says_what_takes_its_time(self):
        self.assertRegex(self.generate("--progress", "plain").stderr, r"start: .*score.*\nstarted in [\d.]+ s at iteration 0, R \d")

    def test_says_which_ranks_idle_and_that_nothing_is_sent(self):
        self.assertIn("3 of 9 ranks have no slice", self.generate(ranks=9).stderr)
        done = self.generate("--set", 'filter.groups=[{axes="xy",kernel="box",size=3}]', ranks=2)
        self.assertIn("exchange nothing", done.stderr)

    def test_history_and_stop_rules(self):
        self.generate("--progress", "none")
        info = self.info("run.h5")
        self.assertEqual(info["state"]["finished"], "iterations")
        self.assertEqual(info["history"]["iterations"][-1], 64)
        self.assertEqual(info["history"]["iterations"][0], 0)
        scores = info["history"]["relative_error"]
        self.assertLess(scores[-1], 0.5)

        target = scores[-1] * 1.2
        self.generate("--progress", "none", "--set", f"optimizer.stop={{score={target}}}")
        info = self.info("run.h5")
        self.assertEqual(info["state"]["finished"], "score")
        self.assertLessEqual(info["history"]["relative_error"][-1], target)

        self.generate("--progress", "none", "--set", "optimizer.stop={improvement=0.1}")
        self.assertEqual(self.info("run.h5")["state"]["finished"], "improvement")

        self.generate("--progress", "none", "--set", 'optimizer.stop={time="1s"}')
        info = self.info("run.h5")
        self.assertEqual(info["state"]["finished"], "time")
        self.assertGreater(info["history"]["seconds"][-1], 0.5)  # it ends where another score would be too late
        self.assertLess(info["history"]["seconds"][-1], 20)

    def test_info_of_a_run_that_is_not_finished(self):
        self.generate("--progress", "none", "--time-limit", "0.001s", expect=75)
        text = self.run_program("info", "run.h5").stdout
        self.assertRegex(text, r"not finished: iteration \d+ of 64, R \d\.\d+ \(white noise 1\); go on with generate --resume")
        (self.folder / "run.h5.prev").write_bytes((self.folder / "run.h5").read_bytes())
        self.assertIn("run.h5.prev: the generation before it", self.run_program("info", "run.h5").stdout)
        self.generate("--quiet", "--set", "optimizer.stop={score=0.001}", "--time-limit", "0.001s", expect=75)
        self.assertRegex(self.run_program("info", "run.h5").stdout, r"not finished: iteration \d+, R \d\.\d+ of 0\.001 ")

    def begin(self, *options):
        """A run that goes on with run.h5 and holds its lock."""
        run = subprocess.Popen(self.command("generate", self.config, "-o", "run.h5", "--resume", *options), cwd=self.folder)
        lock = self.folder / "run.h5.lock"
        while not lock.exists() or f"process {run.pid} " not in lock.read_text():
            self.assertIsNone(run.poll())
        return run

    def test_a_run_is_followed_to_its_end(self):
        long = ("--set", "optimizer.stop.iterations=6000", "--checkpoint-every", "0.05s", "--quiet")
        self.generate(*long, "--time-limit", "0.1s", expect=75)
        stopped = self.run_program("info", "run.h5", "--follow", expect=75)
        self.assertIn("nobody works on it", stopped.stderr)
        self.assertIn("not finished: iteration", stopped.stdout)
        run = self.begin(*long)
        run.kill()  # leaves its lock file
        run.wait()
        self.assertTrue((self.folder / "run.h5.lock").exists())
        self.assertIn("nobody works on it", self.run_program("info", "run.h5", "--follow", expect=75, timeout=20).stderr)
        run = self.begin(*long)
        followed = self.run_program("info", "run.h5", "--follow", "--json", timeout=60)
        run.wait()
        states = [json.loads(line)["state"] for line in followed.stdout.splitlines()]
        self.assertGreater(len(states), 1)
        self.assertEqual((states[-1]["iterations"], states[-1]["finished"]), (6000, "iterations"))
        self.assertEqual([state["finished"] for state in states[:-1]], [""] * (len(states) - 1))
        self.assertIn("nowhere.h5", self.run_program("info", "nowhere.h5", "--follow", expect=2).stderr)

    def test_a_run_is_followed_past_a_moment_without_its_file(self):
        """As there is between the two renames of a save, where the file system has no links."""
        self.generate("--quiet", "--time-limit", "0.001s", expect=75)
        lock = self.write("run.h5.lock", "")  # of somebody who has not said yet who it is
        followed = subprocess.Popen(self.command("info", "run.h5", "--follow"), cwd=self.folder, text=True,
                                    stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertIn("not finished", followed.stdout.readline())
        (self.folder / "run.h5").rename(self.folder / "run.h5.prev")
        time.sleep(0.5)
        (self.folder / "run.h5.prev").rename(self.folder / "run.h5")
        lock.unlink()
        self.assertIn("nobody works on it", followed.communicate(timeout=60)[1])
        self.assertEqual(followed.returncode, 75)

    def test_text_info(self):
        self.generate("--progress", "none")
        text = self.run_program("info", "run.h5").stdout
        for words in ("16 x 16 x 6", "finished after 64 iterations", "/samples", "[texture]", "provenance"):
            self.assertIn(words, text)


if __name__ == "__main__":
    main()
