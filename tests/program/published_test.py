"""fastnoise, stbn-scalar, stbn-vector: files and names as the published programs make them; and tools/gallery."""

import fcntl
import json
import os
import subprocess
import sys
import unittest

from support import BIN, SOURCE, ProgramTest, main

try:
    import numpy as np
    from PIL import Image
except ImportError as missing:
    print(f"skipped: {missing}")
    raise SystemExit(77)


def pixels(path):
    return np.asarray(Image.open(path))


class PublishedPrograms(ProgramTest):
    def names(self, folder="."):
        return sorted(path.name for path in (self.folder / folder).iterdir())

    def test_images_of_fastnoise(self):
        line = "fastnoise vector2 Uniform Gauss 1.0 Exponential 0.1 0.1 Separate 0.5 8 4 2 out/noise -numsteps 5".split()
        printed = self.run_program(*line, "--progress", "none").stdout
        self.assertIn("wrote out/noise.png", printed)
        self.assertRegex(printed, r"seed \d+, drawn")
        self.assertEqual(self.names("out"), ["noise.png"])  # nothing else is left behind
        strip = pixels(self.folder / "out/noise.png")
        self.assertEqual(strip.shape, (8, 8, 4))  # slices downward, RGBA
        self.assertTrue((strip[..., 2] == 0).all() and (strip[..., 3] == 255).all())
        # What is there is not touched.
        before = (self.folder / "out/noise.png").read_bytes()
        refused = self.run_program(*line, expect=2)
        self.assertIn("out/noise.png", refused.stderr)
        self.assertEqual((self.folder / "out/noise.png").read_bytes(), before)

    def test_another_line_on_the_same_files_is_left_alone(self):
        line = "fastnoise real Uniform Box 3 Box 1 Product 8 8 1 n -numsteps 5 --quiet".split()
        config = self.write("n.unfinished.toml", self.run_program(*line, "-seed", 4, "--print-config").stdout)
        before = config.read_text()
        for words in (["-seed", 5], []):  # by its seed, and while it runs
            with open(self.folder / "n.unfinished.toml.lock", "a") as lock:
                if not words:
                    fcntl.flock(lock, fcntl.LOCK_EX)
                refused = self.run_program(*line, *words, expect=2)
                self.assertIn("another line" if words else "another run is writing it", refused.stderr)
            self.assertEqual(config.read_text(), before)
        (self.folder / "n.unfinished.toml.lock").unlink(missing_ok=True)
        self.run_program(*line)  # takes the seed of the first
        self.assertEqual(self.names(), ["n.png"])
        self.assertIn("seed = 4", " ".join(Image.open(self.folder / "n.png").text.values()))

    def test_start_and_floats_of_fastnoise(self):
        start = np.random.default_rng(3).random((2, 4, 8, 4), dtype=np.float32)
        start.tofile(self.folder / "start.raw")
        line = "fastnoise real Uniform Gauss 1.0 Box 1 Product 8 4 2 noise -split -init start.raw -seed 3 -numsteps 5"
        self.run_program(*line.split(), "--quiet", "-output", "csv")
        self.assertEqual(self.names(), ["noise_0.csv", "noise_1.csv", "start.raw"])
        for z in range(2):
            rows = (self.folder / f"noise_{z}.csv").read_text().splitlines()
            table = np.array([[float(number.strip('"')) for number in row.split(",")] for row in rows]).reshape(4, 8, 4)
            self.assertTrue(all(number.startswith('"') for number in rows[0].split(",")))
            np.testing.assert_array_equal(table[..., 0], table[..., 2])
            self.assertTrue((table[..., 3] == 1).all())
            # The samples of the slice are those of the file, elsewhere.
            np.testing.assert_allclose(np.sort(table[..., 0].ravel()), np.sort(start[z, ..., 0].ravel()), atol=1e-6)

    def test_blue_noise(self):
        result = json.loads(self.run_program(*"stbn-vector -x 8 -y 8 -z 2 -g Unit -o v --json --progress none".split()).stdout)
        self.assertEqual(result["files"], [f"v/VectorSTBN_8x8x2_8x8x2_{z}.png" for z in range(2)])
        self.assertIn("value_kernel", result["config"])
        self.assertEqual(self.names("v"), [f"VectorSTBN_8x8x2_8x8x2_{z}.png" for z in range(2)])
        vectors = (pixels(self.folder / result["files"][0])[..., :2] + 0.5) / 128 - 1
        np.testing.assert_allclose(np.hypot(vectors[..., 0], vectors[..., 1]), 1, atol=0.01)
        self.run_program(*"stbn-scalar --dimsX 16 --dimsY 16 --dimsZ 2 -o s --quiet".split())
        grey = pixels(self.folder / "s/stbn_scalar_Splice_Cache_2Dx1Dx1D_16x16x2_1.png")
        self.assertEqual(grey.shape, (16, 16))
        both = np.stack([grey, pixels(self.folder / "s/stbn_scalar_Splice_Cache_2Dx1Dx1D_16x16x2_0.png")])
        np.testing.assert_array_equal(np.bincount(both.ravel(), minlength=256), np.full(256, 2))

    def test_printed_config_is_a_config(self):
        printed = self.run_program(*"fastnoise sphere Cosine Box 3 Box 1 Product 8 8 1 n -seed 5 --print-config".split())
        config = self.write("printed.toml", printed.stdout)
        self.assertEqual(self.names(), ["printed.toml"])
        self.assertIn("hemisphere-cosine", self.run_program("plan", config).stdout)
        wrong = self.run_program(*"fastnoise sphere Tent Box 3 Box 1 Product 8 8 1 n -split -foo".split(), expect=2)
        self.assertIn('word 2 "Tent"', wrong.stderr)
        self.assertRegex(wrong.stderr, r'word 13 "-foo": unknown option.*; see noiseloom fastnoise --help')


class Gallery(ProgramTest):
    def gallery(self, *arguments, expect=0):
        path = f"{BIN}{os.pathsep}{os.environ['PATH']}"
        done = subprocess.run([sys.executable, SOURCE / "tools/gallery", *map(str, arguments)], env={**os.environ, "PATH": path},
                              capture_output=True, text=True, timeout=300, cwd=self.folder)
        self.assertEqual(done.returncode, expect, done.stdout + done.stderr)
        return done.stdout

    def test_every_member_of_the_banks_is_a_config(self):
        names = self.gallery("--list").split()
        self.assertEqual((len(names), len(set(names))), (164, 164))
        for word in ("masks_128x128x64", "stbn_vector2_64x64x32", "circle_128x128x32_sum_gauss1_ema0.1-0.1"):
            self.assertIn(word, names)

    def test_the_gallery_is_a_bank(self):
        self.run_program("bank", SOURCE / "configs/gallery.toml", "-o", "g", "--time-limit", "0.1s", "--threads", 1, "--quiet", expect=75)
        self.assertEqual(len((self.folder / "g/index.csv").read_text().splitlines()), 1 + 144)

    def test_members_have_a_run_file_a_certificate_and_files_for_programs(self):
        self.write("base.toml", """
[texture]
size = { x = 16, y = 8, t = 2 }
[filter]
groups = [ { axes = "xy", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 20 }
""")
        bank = self.write("small.toml", """
base = "base.toml"
combine = "side-by-side"
[vary]
"texture.samples" = ["uniform", "vector2"]
"filter.groups" = [[{ axes = "xy", kernel = "box", size = 3 }], [{ axes = "xy", kernel = "gauss", sigma = 1.0 }]]
""")
        said = self.gallery("out", "--bank", bank, "--for", "three,unreal", "--threads", 1)
        self.assertEqual(sorted(path.name for path in (self.folder / "out").iterdir()), ["uniform_box3", "vector2_gauss1"])
        self.assertRegex(said, r"vector2_gauss1: sound, .* s\n.*--for unreal: vector2_gauss1 is 16 x 8 x 2; accepted")
        for name, samples in ("uniform_box3", "uniform"), ("vector2_gauss1", "vector2"):
            folder = self.folder / "out" / name
            certificate = json.loads((folder / f"{name}.verify.json").read_text())
            self.assertEqual(certificate["taken_for"]["samples"], samples)
            self.assertEqual([path.name for path in (folder / "three").iterdir()], [f"{name}.ktx2"])
        before = (folder / f"{name}.h5").stat().st_mtime_ns
        self.gallery("out", "--bank", bank, "--only", "vector2")
        self.assertEqual((folder / f"{name}.h5").stat().st_mtime_ns, before)
        self.gallery("out", "--bank", bank, "--only", "vector9", expect=2)


if __name__ == "__main__":
    main()
