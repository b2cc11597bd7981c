"""Void and cluster as a whole program: what the run file holds, kill and resume in every phase, other tools on it."""

import json
import re
import signal
import subprocess

import numpy

from support import KILLER, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 12, y = 8, t = 8 }
[filter]
combine = "sum"
groups  = [ { axes = "xy", kernel = "gauss-energy" }, { axes = "t", kernel = "gauss-energy" } ]
[optimizer]
method  = "void-and-cluster"
density = 0.5
"""
PIXELS = 12 * 8 * 8
POINTS = PIXELS // 2


class VoidAndCluster(ProgramTest):
    def setUp(self):
        super().setUp()
        self.config = self.write("run.toml", CONFIG)

    def generate(self, output, *arguments, **options):
        return self.run_program("generate", self.config, "-o", output, *arguments, **options)

    def read(self, name):
        import h5py

        with h5py.File(self.folder / name) as file:
            return file["order"][...], file["samples"][..., 0], dict(file["state"].attrs)

    def test_run_file(self):
        self.generate("run.h5", "--progress", "none")
        order, samples, state = self.read("run.h5")
        self.assertEqual((order.shape, order.dtype), ((8, 8, 12), numpy.uint32))
        self.assertTrue(numpy.array_equal(numpy.sort(order, axis=None), numpy.arange(PIXELS)))
        self.assertTrue(numpy.array_equal(samples, ((order + 0.5) / PIXELS).astype(numpy.float32)))
        self.assertEqual((state["phase"], state["finished"], state["start_points"]), (b"done", b"order", POINTS))
        history = self.info("run.h5")["history"]
        self.assertEqual(history["ranked"][-1], PIXELS)
        self.assertEqual(sorted(set(history["phase"])), [0, 1, 2, 3])
        self.assertEqual(len(history["seconds"]), len(history["ranked"]))

        text = self.run_program("info", "run.h5").stdout
        self.assertIn("finished", text)
        self.assertIn(f"{POINTS} start points", text)

    def test_levels_of_volume_and_of_slices(self):
        for equalize, axis in (("volume", None), ("slice", 0)):
            with self.subTest(equalize):
                self.generate("run.h5", "--overwrite", "--set", "optimizer.bits=5", "--set", f"optimizer.equalize={equalize}")
                _, samples, _ = self.read("run.h5")
                levels = samples * 32 - 0.5
                self.assertTrue(numpy.array_equal(levels, levels.astype(int)))
                parts = [levels] if axis is None else list(levels)
                for part in parts:
                    counts = numpy.bincount(part.astype(int).ravel(), minlength=32)
                    self.assertEqual((counts.min(), counts.max()), (part.size // 32, part.size // 32))

    def test_other_commands_read_it(self):
        self.generate("run.h5", "--progress", "none", "--set", "optimizer.bits=8")
        score = json.loads(self.run_program("score", "run.h5", "--json").stdout)
        self.assertGreater(score["relative_error"], 0)
        self.assertLess(score["relative_error"], 0.9)
        self.run_program("export", "run.h5", "-o", "images")
        from PIL import Image

        _, samples, _ = self.read("run.h5")
        first = numpy.asarray(Image.open(sorted((self.folder / "images").iterdir())[0]))
        self.assertTrue(numpy.array_equal(first, numpy.floor(samples[0] * 256)))
        self.run_program("analyze", "run.h5", "-o", "report")
        self.assertTrue((self.folder / "report" / "report.html").exists())
        self.run_program("accuracy", self.config, "-o", "accuracy", "--budget", "1s", "--seeds", 1)
        self.assertTrue((self.folder / "accuracy" / "report.html").exists())

    def test_plan_and_summary(self):
        plan = self.run_program("plan", self.config, "--ranks", 3, "--set", "optimizer.bounded=t").stdout
        for words in ("axis       t: on, bounded", "axis       x: on, wraps around", "rank    2  2 slices", "memory", "time"):
            self.assertIn(words, plan)
        done = self.generate("run.h5", "--set", "optimizer.equalize=slice", ranks=2)
        self.assertRegex(done.stdout, r"samples moved by 0\.0\d+ \(rms\)")
        for words in (f"{PIXELS} pixels", "swaps", "collectives a pick", "B a pick", "noiseloom export run.h5"):
            self.assertIn(words, done.stdout)
        lines = [json.loads(line) for line in self.generate("run.h5", "--overwrite", "--progress", "json").stderr.splitlines()]
        figures = [line for line in lines if "phase" in line]
        self.assertEqual((figures[-1]["phase"], figures[-1]["ranked"]), ("done", PIXELS))
        self.assertTrue(all(0 <= line["fraction"] <= 1 for line in figures))

    def test_stop_and_resume_in_every_phase(self):
        self.generate("straight.h5", "--progress", "none")
        expected = self.info("straight.h5")["checksums"]
        phases = set()
        for part in range(60):
            done = self.generate("parts.h5", "--resume", "--time-limit", "0.000001s", "--progress", "none", expect=None,
                                 ranks={1: 3, 4: 2}.get(part))
            _, samples, state = self.read("parts.h5")
            phases.add(state["phase"].decode())
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, 75, done.stderr)
            self.assertEqual(numpy.count_nonzero(~numpy.isnan(samples)), state["ranked"])
            for command in (("score", "parts.h5"), ("export", "parts.h5", "-o", "images"))[: 2 if part == 2 else 0]:
                self.assertIn("not finished", self.run_program(*command, expect=2).stderr)
        self.assertEqual(phases, {"swap", "drain", "fill", "done"})
        self.assertEqual(self.info("parts.h5")["checksums"], expected)

    def test_kill_in_every_phase(self):
        self.generate("straight.h5", "--progress", "none")
        expected = self.info("straight.h5")["checksums"]
        arguments = ("--resume", "--checkpoint-every", "0.000001s", "--progress", "none")
        phases = set()
        killed = 0
        at = 25
        while True:
            done = self.generate("out.h5", *arguments, expect=None,
                                 environment={"LD_PRELOAD": KILLER, "KILL_AT": str(at), "KILL_PART": self.folder.name})
            if done.returncode == 0:
                break
            self.assertEqual(done.returncode, -signal.SIGKILL, done.stderr)
            killed += 1
            at += 9 if killed % 2 else -2
            existing = [name for name in ("out.h5", "out.h5.prev") if (self.folder / name).exists()]
            if existing:
                phases.add(self.read(existing[0])[2]["phase"].decode())
            self.assertLess(killed, 100)
        self.assertTrue({"swap", "drain", "fill"} <= phases, phases)
        self.assertEqual(self.info("out.h5")["checksums"], expected)

    def test_a_signal_is_heard_soon(self):
        config = self.write("large.toml", CONFIG.replace("x = 12, y = 8, t = 8", "x = 256, y = 256, t = 64"))
        process = subprocess.Popen(self.command("generate", config, "-o", "large.h5", "--progress", "json"),
                                   stderr=subprocess.PIPE, text=True, cwd=self.folder)
        for line in process.stderr:
            if '"phase"' in line:
                break
        process.send_signal(signal.SIGUSR1)
        words = process.stderr.read()
        self.assertEqual(process.wait(timeout=60), 75)
        process.stderr.close()
        self.assertTrue(re.search("stopped by SIGUSR1 at phase (swap|drain|fill)", words), words)
        info = self.run_program("info", "large.h5").stdout
        self.assertIn("not finished: stopped in phase", info)


if __name__ == "__main__":
    main()
