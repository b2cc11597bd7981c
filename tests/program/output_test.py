"""What happens to the output of a run: links, locks, readers, damage, and programs that write into it."""

import os
import shutil
import subprocess
import threading
import time

import h5py

from support import BIN, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 19, y = 11, t = 3 }
samples = "uniform"
[filter]
groups  = [ { axes = "xy", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 300 }
"""


class Output(ProgramTest):
    def setUp(self):
        super().setUp()
        self.config = self.write("run.toml", CONFIG)

    def test_a_run_alone_needs_no_folder_of_the_machine(self):
        """Nothing is made in the folder for temporary files, where many runs at once would be in each other's way."""
        blocked = self.write("no-folder", "")
        self.generate("run.h5", environment={"TMPDIR": str(blocked), "OMPI_MCA_orte_tmpdir_base": str(blocked)})

    def generate(self, output, *more, **options):
        return self.run_program("generate", self.config, "-o", output, "--progress", "plain", *more, **options)

    def study(self, *arguments, expect=0):
        done = subprocess.run([str(BIN / "noiseloom"), *map(str, arguments)], capture_output=True, text=True, cwd=self.folder,
                              timeout=120)
        self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def test_through_a_symbolic_link_the_target_is_written(self):
        (self.folder / "disk").mkdir()
        link = self.folder / "link.h5"
        link.symlink_to("disk/target.h5")  # not there yet
        self.generate("link.h5")
        self.assertTrue(link.is_symlink())
        first = (self.folder / "disk/target.h5").read_bytes()
        self.generate("link.h5", "--overwrite", "--set", "texture.seed=2")
        self.assertTrue(link.is_symlink())
        self.assertNotEqual((self.folder / "disk/target.h5").read_bytes(), first)
        self.assertEqual([p.name for p in self.folder.iterdir() if p.name.startswith("link")], ["link.h5"])

    def test_a_reader_always_finds_a_whole_file(self):
        path = self.folder / "out.h5"
        self.generate("out.h5")
        done = threading.Event()
        looks, absent = [0], [0]

        def look():
            while not done.is_set():
                looks[0] += 1
                absent[0] += not path.exists()

        reader = threading.Thread(target=look)
        reader.start()
        self.generate("out.h5", "--overwrite", "--checkpoint-every", "0.001s", "--set", "optimizer.stop.iterations=3000")
        done.set()
        reader.join()
        self.assertEqual(absent[0], 0)
        self.assertGreater(looks[0], 1000)

    LOCK = ("process 4711 on node7, since 2026-01-31 12:00:00 UTC\nmachine another\npid 4711\nstarted 1\nnumber 0123456789abcdef\n"
            "slurm_job snow/77\nslurm_restarts 0\n")

    def test_the_lock_of_a_node_that_died_does_not_refuse_the_requeued_job(self):
        lock = self.write("out.h5.lock", self.LOCK)
        requeued = {"SLURM_JOB_ID": "77", "SLURM_CLUSTER_NAME": "snow", "SLURM_RESTART_COUNT": "1"}
        begun = time.monotonic()
        self.generate("out.h5", environment=requeued)
        self.assertLess(time.monotonic() - begun, 30)  # not even waited for
        self.assertFalse(lock.exists())
        lock = self.write("out.h5.lock", self.LOCK)  # and a day later, by hand
        os.utime(lock, (time.time() - 86400,) * 2)
        self.generate("out.h5", "--overwrite")
        self.assertFalse(lock.exists())

    def test_the_lock_of_a_live_run_on_another_node_refuses(self):
        lock = self.write("out.h5.lock", self.LOCK)
        done = threading.Event()

        def beat():
            while not done.wait(0.5):
                os.utime(lock)

        heart = threading.Thread(target=beat)
        heart.start()
        try:
            refused = self.generate("out.h5", expect=2)
        finally:
            done.set()
            heart.join()
        self.assertIn("another run is writing it: process 4711 on node7", refused.stderr)
        self.assertFalse((self.folder / "out.h5").exists())

    def test_who_looks_at_a_lost_file_is_told_of_the_generation_before_it(self):
        self.generate("out.h5")
        whole = (self.folder / "out.h5").read_bytes()
        (self.folder / "out.h5").rename(self.folder / "out.h5.prev")
        flipped = bytearray(whole)
        flipped[7000] ^= 4  # within /samples
        for name, contents in {"missing": None, "damaged": bytes(flipped), "cut": whole[:3000], "empty": b"",
                               "zeros": bytes(len(whole))}.items():
            if contents is not None:
                (self.folder / "out.h5").write_bytes(contents)
            for command in (["info"], ["score"], ["export", "-o", "images/"], ["analyze", "-o", "report"]):
                done = self.run_program(command[0], "out.h5", *command[1:], expect=2)
                self.assertIn("out.h5.prev, the generation before it, is there", done.stderr, f"{name}, {command}")
        self.run_program("score", "out.h5.prev")

    def test_damage_in_the_first_bytes_is_no_other_file(self):
        long = ("--set", "optimizer.stop.iterations=20000")
        self.generate("straight.h5", *long)
        checksum = self.samples_checksum("straight.h5")
        # A run that is stopped in the middle keeps two generations.
        self.generate("out.h5", *long, "--checkpoint-every", "0.001s", "--time-limit", "0.1s", expect=75)
        for begin, end, what in ((0, 1, b"\x6f"), (3, 19, b"\0" * 16), (0, 4096, b"\0" * 4096), (0, 600, b"\xa5" * 600)):
            with self.subTest(f"{begin}..{end}"):
                for suffix in ("", ".prev"):
                    shutil.copy(self.folder / ("out.h5" + suffix), self.folder / ("bad.h5" + suffix))
                with open(self.folder / "bad.h5", "r+b") as file:
                    file.seek(begin)
                    file.write(what)
                done = self.generate("bad.h5", "--resume", *long)
                self.assertIn("going on from the generation before it", done.stderr)
                self.assertEqual(self.samples_checksum("bad.h5"), checksum)
                self.assertTrue((self.folder / "bad.h5.damaged").exists())
                for path in self.folder.glob("bad.h5*"):
                    path.unlink()

    def change(self, name):
        with h5py.File(self.folder / name, "r+") as file:
            file.attrs["author"] = "somebody"
            file["provenance"].attrs["note"] = "the best of ten"

    def repack(self, name):
        path = self.folder / name
        subprocess.run(["h5repack", "-f", "GZIP=6", path, self.folder / "packed.h5"], check=True)
        os.replace(self.folder / "packed.h5", path)

    def test_files_that_other_programs_changed_are_read_and_not_resumed(self):
        self.generate("good.h5")
        score = self.study("score", "good.h5", "--json")
        changes = [self.change] + ([self.repack] if shutil.which("h5repack") else [])
        for change in changes:
            with self.subTest(change.__name__):
                shutil.copy(self.folder / "good.h5", self.folder / "out.h5")
                change("out.h5")
                before = (self.folder / "out.h5").read_bytes()
                self.assertIn("another program has changed it", self.study("info", "out.h5"))
                self.assertIn("another program has changed it", self.study("score", "out.h5"))
                self.assertEqual(self.relative_error("out.h5"), self.relative_error("good.h5"))
                said = self.study("export", "out.h5", "-o", f"{change.__name__}.npy")
                self.assertIn("another program has changed it", said)
                refused = self.generate("out.h5", "--resume", expect=2)
                self.assertIn("another program has changed it", refused.stderr)
                self.assertEqual((self.folder / "out.h5").read_bytes(), before)
        self.assertIn("relative_error", score)

    def relative_error(self, name):
        import json
        done = subprocess.run([str(BIN / "noiseloom"), "score", name, "--json"], capture_output=True, text=True, cwd=self.folder)
        return json.loads(done.stdout)["relative_error"]


if __name__ == "__main__":
    main()
