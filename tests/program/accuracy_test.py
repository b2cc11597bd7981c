"""accuracy: a table and a page that say what was run; stopped, killed, resumed and refused."""

import csv
import json
import resource
import shlex
import signal
import subprocess

from support import ProgramTest, main

CONFIG = """[texture]
size    = { x = 16, y = 16, t = 4 }
samples = "vector2"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "box", size = 2 } ]
[optimizer]
stop = { iterations = 30 }
"""
FILES = {"accuracy.csv", "report.html", "config.toml"}


class Accuracy(ProgramTest):
    def setUp(self):
        super().setUp()
        self.config = self.write("run.toml", CONFIG)

    def accuracy(self, *arguments, **options):
        return self.run_program("accuracy", "run.toml", "-o", "out", *arguments, **options)

    def rows(self):
        with open(self.folder / "out" / "accuracy.csv", newline="") as table:
            return list(csv.DictReader(table))

    def wait_for_points(self, number, *arguments):
        """Starts it and returns the process once so many more points are in the table."""
        seeds = () if "--seeds" in arguments else ("--seeds", "1")
        process = subprocess.Popen(self.command("accuracy", "run.toml", "-o", "out", "--budget", "10m", *seeds, *arguments),
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=self.folder)
        seen = 0
        for line in process.stdout:
            seen += " R " in line
            if seen == number:
                return process
        self.fail("ended before so many points")

    def end(self, process):
        text = process.stdout.read()
        process.wait(timeout=60)
        process.stdout.close()
        return text

    def test_points_say_what_made_them(self):
        process = self.wait_for_points(2, "--keep", "--threads", "1")
        process.send_signal(signal.SIGUSR2)
        self.end(process)
        self.assertEqual(process.returncode, 75)
        self.assertEqual({p.name for p in (self.folder / "out").iterdir()}, FILES | {"runs"})
        rows = self.rows()
        self.assertGreaterEqual(len(rows), 2)
        page = (self.folder / "out" / "report.html").read_text()
        self.assertNotIn("<script", page)
        version = self.run_program("--version").stdout.split()[-1]
        self.assertIn(f"noiseloom {version}", page)
        self.assertIn("noiseloom accuracy run.toml -o out --budget 10m --seeds 1 --keep --threads 1", page)
        self.assertNotIn("http", page.replace("http://www.w3.org/2000/svg", ""))
        names = [p.name for p in (self.folder / "out" / "runs").iterdir()]
        self.assertEqual(len(names), len(rows))
        row = rows[0]
        self.assertEqual(row["seed"], "1")
        command = shlex.split(row["command"])
        run_file = command[command.index("-o") + 1]
        for name, other in zip(("first", "last"), (row, rows[-1])):
            kept = other["command"].split()
            score = json.loads(self.run_program("score", kept[kept.index("-o") + 1], "--json").stdout)
            self.assertAlmostEqual(float(other["R"]), score["relative_error"], places=9, msg=name)
        self.assertIn(row["command"], page)
        # The command makes the same point again.
        (self.folder / run_file).unlink()
        self.run_program(*command[1:])
        again = json.loads(self.run_program("score", run_file, "--json").stdout)
        self.assertAlmostEqual(float(row["R"]), again["relative_error"], places=9)
        self.run_program("export", run_file, "-o", "png/")
        stored = json.loads(self.run_program("score", "png", "--config", "run.toml", "--json").stdout)
        self.assertAlmostEqual(float(row["R_8_bit"]), stored["relative_error"], places=9)

    def test_a_signal_stops_it_and_resume_goes_on(self):
        process = self.wait_for_points(2)
        process.send_signal(signal.SIGTERM)
        text = self.end(process)
        self.assertEqual(process.returncode, 75, text)
        self.assertIn("--resume", text)
        self.assertEqual({p.name for p in (self.folder / "out").iterdir()}, FILES)
        before = self.rows()
        self.assertIn("Stopped by a signal", (self.folder / "out" / "report.html").read_text())
        # No budget is left: the same points, and a page that lists the others.
        self.assertIn("exists", self.accuracy(expect=2).stderr)
        self.accuracy("--resume", "--budget", "0.001s")
        self.assertEqual(self.rows(), before)
        self.assertIn("25600", (self.folder / "out" / "report.html").read_text())

    def test_every_point_is_the_mean_of_its_seeds(self):
        self.config.write_text(CONFIG.replace("vector2", "uniform"))
        process = self.wait_for_points(1, "--seeds", "2", "--keep")
        process.send_signal(signal.SIGTERM)
        self.end(process)
        row = self.rows()[0]
        self.assertEqual((row["seed"], row["runs"]), ("1", "2"))
        runs = []
        for seed in ("1", "2"):
            command = shlex.split(row["command"])
            command[command.index("-o") + 1] = f"{seed}.h5"
            self.run_program(*command[1:], "--set", f"texture.seed={seed}")
            runs.append(json.loads(self.run_program("score", f"{seed}.h5", "--json").stdout)["relative_error"])
        self.assertNotEqual(*runs)
        for column, value in (("R", sum(runs) / 2), ("R_least", min(runs)), ("R_most", max(runs))):
            self.assertAlmostEqual(float(row[column]), value, places=9, msg=column)
        # More seeds are added to what is there.
        process = self.wait_for_points(1, "--seeds", "3", "--resume")
        process.send_signal(signal.SIGTERM)
        self.end(process)
        more = self.rows()[0]
        self.assertEqual(more["runs"], "3")
        self.assertLessEqual(float(more["R_least"]), min(runs))
        self.assertGreaterEqual(float(more["R_most"]), max(runs))

    def test_a_mask_is_compared_with_construction_and_annealing(self):
        self.config.write_text("""[texture]
size = { x = 16, y = 16 }
[filter]
groups = [ { axes = "xy", kernel = "gauss-energy" } ]
[optimizer]
method = "void-and-cluster"
""")
        process = self.wait_for_points(4)
        process.send_signal(signal.SIGTERM)
        self.end(process)
        rows = self.rows()
        self.assertEqual(rows[0]["method"], "void-and-cluster")
        self.assertEqual({row["method"] for row in rows}, {"void-and-cluster", "anneal", "fast", "construct"})
        for row in rows:
            self.assertLess(0, float(row["R"]))
        self.assertIn("void-and-cluster has R = ", (self.folder / "out" / "report.html").read_text())

    def test_killed_between_two_points(self):
        process = self.wait_for_points(1)
        process.kill()
        self.end(process)
        before = self.rows()
        self.assertGreaterEqual(len(before), 1)
        self.write("out/.accuracy.partial-1.csv", "cut")
        process = self.wait_for_points(1, "--resume")
        process.send_signal(signal.SIGUSR1)
        self.end(process)
        self.assertEqual(process.returncode, 75)
        after = self.rows()
        key = ("method", "setting", "value", "iterations", "seed", "runs", "seconds", "R", "command")
        self.assertGreater(len(after), len(before))
        for old, new in zip(before, after):
            self.assertEqual([old[k] for k in key], [new[k] for k in key])
        self.assertEqual({p.name for p in (self.folder / "out").iterdir()}, FILES)

    def test_a_run_that_fails_is_told_and_nothing_is_lost(self):
        self.config.write_text(CONFIG.replace("x = 16, y = 16", "x = 64, y = 64").replace("vector2", "uniform"))

        def small_files():
            resource.setrlimit(resource.RLIMIT_FSIZE, (30000, 30000))

        done = subprocess.run(self.command("accuracy", "run.toml", "-o", "out"), capture_output=True, text=True,
                              preexec_fn=small_files, cwd=self.folder)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("noiseloom generate run.toml", done.stderr)
        self.accuracy("--resume", "--budget", "0.001s")

    def test_resume_refuses_another_config_and_damage(self):
        self.accuracy("--budget", "0.001s")
        done = self.accuracy("--resume", "--set", "texture.seed=2", expect=2)
        self.assertIn("texture.seed: 1 in the file, 2 here", done.stderr)
        table = self.folder / "out" / "accuracy.csv"
        text = table.read_text()
        table.write_text(text + "anneal,iterat")
        self.assertIn("accuracy.csv:", self.accuracy("--resume", expect=2).stderr)
        line = "anneal,iterations,26,26,1,1,2,0.5,0.5,0.5,0.5,0.5,0.5,no,no,noiseloom\n"
        table.write_text(text.splitlines()[0] + "\n" + line)
        self.assertIn("26 iterations", self.accuracy("--resume", expect=2).stderr)
        self.assertEqual(table.read_text().splitlines()[1] + "\n", line)
        self.accuracy("--overwrite", "--budget", "0.001s")
        self.assertNotIn("26", [row["iterations"] for row in self.rows()])

    def test_all_faults_at_once_and_nothing_started(self):
        self.config.write_text(CONFIG.replace("t = 4", "t = 0").replace("size = 3", "size = -3"))
        done = self.accuracy("--budget", "soon", "--threads", "none", "--seeds", "0", "--resume", "--overwrite", expect=2)
        for words in ("--budget soon", "--threads none", "--seeds 0", "exclude", "run.toml:2", "run.toml:6", "6 errors"):
            self.assertIn(words, done.stderr)
        self.assertFalse((self.folder / "out").exists())
        for folder, words in (("-", "cannot go to standard output"), ("", "empty"), ("a.html", "the folder's name")):
            done = self.run_program("accuracy", "run.toml", "-o", folder, expect=2)
            self.assertIn(words, done.stderr)
            self.assertIn("run.toml:2", done.stderr)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["run.toml"])

    def test_output_that_cannot_be_or_is_something_else(self):
        self.run_program("accuracy", "run.toml", "-o", "/sys/out", expect=1)
        self.write("file", "mine")
        self.assertIn("not a folder", self.run_program("accuracy", "run.toml", "-o", "file", expect=2).stderr)
        (self.folder / "out").mkdir()
        self.write("out/report.html", "mine")
        for arguments in ((), ("--resume",)):
            self.assertIn("report.html", self.accuracy(*arguments, expect=2).stderr)
        self.assertEqual([p.name for p in (self.folder / "out").iterdir()], ["report.html"])
        self.assertEqual((self.folder / "out" / "report.html").read_text(), "mine")


if __name__ == "__main__":
    main()
