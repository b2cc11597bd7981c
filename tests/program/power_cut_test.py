"""What a power cut leaves: the image of a file system is copied while a run writes to it, and the run goes on from the copy.

As root on Linux alone, where loop devices may be mounted; part of tools/test --all."""

import os
import shutil
import subprocess
import sys

from support import KILLER, THOROUGH, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 19, y = 13, t = 4 }
samples = "uniform"
[filter]
combine = "product"
groups  = [ { axes = "xy", kernel = "gauss", sigma = 1.0 }, { axes = "t", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 30000 }
"""
CUTS = 12
# Operations on files of the first publishing and of the second: the last writes, and all that syncs and gives names.
STEPS = (*range(28, 39), *range(74, 89))


class Mount:
    """A file system of an image, mounted on a folder."""

    def __init__(self, image, folder):
        self.folder = folder
        folder.mkdir(exist_ok=True)
        subprocess.run(["mount", "-o", "loop,errors=remount-ro", image, folder], check=True, capture_output=True)

    def __enter__(self):
        return self.folder

    def __exit__(self, *_):
        subprocess.run(["umount", "-l", self.folder], check=True)


def why_impossible():
    if os.getuid() != 0:
        return "only root may mount"
    missing = [name for name in ("mkfs.ext4", "mount", "umount") if shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin:/sbin") is None]
    if missing:
        return f"there is no {', '.join(missing)}"
    return ""


def make_image(path):
    with open(path, "wb") as image:
        image.truncate(24 << 20)
    subprocess.run(["mkfs.ext4", "-q", "-F", path], check=True, capture_output=True, env={**os.environ, "PATH": os.environ["PATH"] + ":/usr/sbin"})


class PowerCut(ProgramTest):
    def test_before_and_after_each_step_of_publishing(self):
        """After one step is before the next. The run is killed there and the image copied as it is: what the system has
        not written yet is lost."""
        config = self.write("run.toml", CONFIG.replace("30000", "600"))
        self.run_program("generate", config, "-o", "straight.h5", "--quiet")
        found = []
        for step in STEPS:
            image = self.folder / "disk.img"
            make_image(image)
            with Mount(image, self.folder / "disk") as disk:
                done = self.run_program("generate", config, "-o", disk / "out.h5", "--checkpoint-every", "0.02s", "--progress", "plain",
                                        environment={"LD_PRELOAD": KILLER, "KILL_AT": str(step), "KILL_PART": "out.h5"}, expect=None)
                self.assertEqual(done.returncode, -9, f"{step}: the run has fewer steps")
                shutil.copyfile(image, self.folder / "cut.img")
            with Mount(self.folder / "cut.img", self.folder / "after") as after:
                saved = [int(line.split()[3].rstrip(",")) for line in done.stderr.splitlines() if line.startswith("saved at iteration")]
                there = (after / "out.h5").exists()
                found.append(there)
                if saved:
                    self.assertTrue(there, f"{step}: {done.stderr}")
                    self.assertGreaterEqual(self.info(after / "out.h5")["state"]["iterations"], saved[-1], step)
                self.run_program("generate", config, "-o", after / "out.h5", "--resume", "--quiet")
                self.assertEqual(self.samples_checksum(after / "out.h5"), self.samples_checksum("straight.h5"))
                self.assertEqual([path.name for path in after.glob("out.h5?*")], [])
        self.assertEqual(set(found), {False, True}, "the steps are no longer those of publishing")

    def test_what_was_saved_last_is_whole_wherever_the_power_goes(self):
        config = self.write("run.toml", CONFIG)
        self.run_program("generate", config, "-o", "straight.h5", "--quiet")
        image = self.folder / "disk.img"
        make_image(image)
        came_to = set()
        with Mount(image, self.folder / "disk") as disk:
            command = self.command("generate", config, "-o", disk / "out.h5", "--checkpoint-every", "0.02s", "--progress", "plain")
            run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, cwd=self.folder)
            self.addCleanup(run.stderr.close)
            for cut in range(CUTS):
                saved = next((line for line in run.stderr if line.startswith("saved at iteration")), None)
                if saved is None:
                    break
                # The image as it lies under the mounted file system, at no moment of the run's choosing.
                copy = self.folder / f"cut{cut}.img"
                shutil.copyfile(image, copy)
                with Mount(copy, self.folder / "after") as after:
                    iterations = self.info(after / "out.h5")["state"]["iterations"]
                    self.assertGreaterEqual(iterations, int(saved.split()[3].rstrip(",")), "what was said to be saved is not")
                    came_to.add(iterations)
                    (after / "out.h5.lock").unlink(missing_ok=True)  # its process would have ended, which lives here
                    if cut % 3 == 0:
                        self.run_program("generate", config, "-o", after / "out.h5", "--resume", "--quiet")
                        self.assertEqual(self.samples_checksum(after / "out.h5"), self.samples_checksum("straight.h5"))
                        self.assertEqual([path.name for path in after.glob("out.h5?*")], [])
                copy.unlink()
            self.assertEqual(run.wait(), 0)
        self.assertGreater(len(came_to), 3)


if __name__ == "__main__":
    if not THOROUGH and len(sys.argv) == 1:
        print("skipped: power cuts, which tools/test --all tries", file=sys.stderr)
        sys.exit(77)
    if reason := why_impossible():
        print(f"skipped: power cuts, as {reason}", file=sys.stderr)
        sys.exit(77)
    main()
