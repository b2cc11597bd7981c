"""score takes what anybody has: several files, foreign arrays and images, described on the command line alone."""

import json
import shutil
import struct
import subprocess
import unittest

import support

try:
    import h5py
    import numpy
    from PIL import Image
except ImportError as missing:
    print(f"skipped: {missing}")
    raise SystemExit(77)

CONFIG = """
[texture]
size = { x = %d, y = %d%s }
samples = "%s"
[filter]
groups = [ { axes = "xy", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 1 }
"""


class ScoreFilesTest(support.ProgramTest):
    def setUp(self):
        super().setUp()
        random = numpy.random.default_rng(5)
        self.codes = (random.permutation(24 * 24) * 256 // (24 * 24)).astype(numpy.uint8).reshape(24, 24)
        Image.fromarray(self.codes).save(self.folder / "a.png")

    def score(self, *arguments):
        return json.loads(self.run_program("score", *arguments, "--json").stdout)

    def test_set_alone_says_what_a_file_is(self):
        config = self.write("c.toml", CONFIG % (24, 24, "", "uniform"))
        expected = self.score("a.png", "--config", config)["relative_error"]
        box = ["--set", "texture.samples=uniform", "--set", "filter.groups[0].kernel=box", "--set",
               "filter.groups[0].size=3"]
        found = self.score("a.png", *box)
        self.assertAlmostEqual(found["relative_error"], expected, places=12)
        self.assertEqual(found["size"], "24 x 24")
        self.assertEqual(found["filters"]["none"], 1)
        self.assertAlmostEqual(found["filters"]["box 3 over xy"], expected, places=12)
        self.assertIn("gauss 1 over xy", self.score("a.png", "--set", "texture.samples=uniform")["filter"])
        self.assertIn("texture.samples", self.run_program("score", "a.png", "--set", "texture.seed=1", expect=2).stderr)
        self.assertIn("texture.samples", self.run_program("score", "a.png", expect=2).stderr)

    def test_exports_of_our_own_need_no_config(self):
        config = self.write("c.toml", CONFIG % (8, 8, ", t = 3", "uniform"))
        self.run_program("generate", config, "-o", "run.h5", "--quiet")
        self.run_program("export", "run.h5", "-o", "atlas.png", "--layout", "atlas", "--depth", "16", "--quiet")
        expected = self.score("run.h5")
        found = self.score("atlas.png")
        self.assertEqual((found["size"], found["filter"]), (expected["size"], expected["filter"]))
        self.assertAlmostEqual(found["relative_error"], expected["relative_error"], places=3)
        wider = ["--set", "filter.groups[0].size=5"]
        self.assertAlmostEqual(self.score("atlas.png", *wider)["relative_error"],
                               self.score("run.h5", *wider)["relative_error"], places=3)
        # Who says what the values are is believed.
        self.assertEqual(self.score("atlas.png", "--set", "texture.samples=circle")["samples"], "circle")

    def test_the_same_numbers_score_alike_in_every_file(self):
        values = (self.codes + 0.5) / 256
        numpy.save(self.folder / "half.npy", values.astype(numpy.float16))
        numpy.save(self.folder / "big.npy", numpy.asfortranarray(values.astype(">f8")))
        values.astype(">f4").tofile(self.folder / "big.raw")
        with h5py.File(self.folder / "lab.h5", "w") as file:
            file["noise/blue"] = self.codes
            file["noise/red"] = values[:, ::-1].astype(">f4")
        config = self.write("c.toml", CONFIG % (24, 24, "", "uniform"))
        expected = self.score("a.png", "--config", config)["relative_error"]
        for name in ("half.npy", "big.npy", "big.raw", "lab.h5:/noise/blue"):
            self.assertAlmostEqual(self.score(name, "--config", config)["relative_error"], expected, places=3, msg=name)
        asked = self.run_program("score", "lab.h5", "--config", config, expect=2).stderr
        self.assertIn("lab.h5:/noise/blue (24 x 24)", asked)
        self.assertIn("lab.h5:/noise/red (24 x 24)", asked)

    def test_several_files_are_a_list_or_the_slices_of_one_texture(self):
        for s in range(3):
            Image.fromarray(numpy.roll(self.codes, 5 * s)).save(self.folder / f"n_{s}.png")
        flat = self.write("flat.toml", CONFIG % (24, 24, "", "uniform"))
        deep = self.write("deep.toml", CONFIG % (24, 24, ", t = 3", "uniform"))
        names = [f"n_{s}.png" for s in range(3)]
        self.assertEqual([one["file"] for one in self.score(*names, "--config", flat)], names)
        self.assertEqual(self.score(*names, "--config", deep)["size"], "24 x 24 x 3")
        for pattern in ("n_%i.png", "n_#.png", "n_*.png", "n_{}.png"):
            self.assertEqual(self.score(pattern, "--config", deep)["size"], "24 x 24 x 3", pattern)
        done = self.run_program("score", "n_0.png", "none.png", "n_9.png", "--config", flat, expect=2)
        self.assertIn("none.png", done.stderr)
        self.assertIn("n_9.png", done.stderr)
        self.assertEqual(done.stdout, "")

    def test_run_files_take_the_filter_of_a_config_of_another_size(self):
        self.run_program("generate", self.write("r.toml", CONFIG % (13, 11, ", t = 2", "uniform")), "-o", "r.h5")
        config = self.write("c.toml", CONFIG.replace("size = 3", "size = 5") % (64, 64, "", "sphere"))
        self.assertEqual(self.score("r.h5", "--config", config)["filter"], "box 5 over xy")

    def test_every_channel_of_a_scalar_is_scored(self):
        colour = numpy.stack([self.codes, numpy.roll(self.codes, 7), self.codes.T], axis=-1)
        Image.fromarray(colour).save(self.folder / "rgb.png")
        found = self.score("rgb.png", "--set", "texture.samples=uniform")
        self.assertEqual(set(found["channels"]), {"G", "B"})
        self.assertAlmostEqual(found["channels"]["B"], found["relative_error"], places=9)  # the filter is symmetric
        self.assertTrue(any("G, B" in note for note in found["notes"]))

    def test_json_holds_no_nan_and_says_why(self):
        text = self.run_program("score", "a.png", "--set", "texture.samples=uniform", "--set",
                                "texture.size={ x = 24, y = 8, t = 3 }", "--json").stdout

        def refuse(word):
            raise AssertionError(word)

        found = json.loads(text, parse_constant=refuse)
        self.assertIsNone(found["low_frequency_power"]["t"])
        self.assertTrue(any("low_frequency_power of t is null" in note for note in found["notes"]))

    def test_gamma_and_two_tones_are_warned_of(self):
        bright = (255 * (self.codes / 255) ** (1 / 2.2)).astype(numpy.uint8)
        Image.fromarray(bright).save(self.folder / "bright.png")
        Image.fromarray(((self.codes > 99) * 200).astype(numpy.uint8)).save(self.folder / "tones.png")
        self.assertEqual(self.score("a.png", "--set", "texture.samples=uniform")["warnings"], [])
        for name in ("bright.png", "tones.png"):
            [warning] = self.score(name, "--set", "texture.samples=uniform")["warnings"]
            self.assertIn("not distributed as samples", warning)
        self.assertIn("warning: ", self.run_program("score", "tones.png", "--set", "texture.samples=uniform").stdout)

    def test_hostile_files_end_with_a_reason(self):
        files = {
            "w.hdr": b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 7 +X 0\n",
            "h.pgm": b"P2 9 0 255\n",
            "huge.tif": b"II*\0\x08\0\0\0\x02\0" + struct.pack("<HHII", 256, 4, 1, 2**31 - 5) +
                        struct.pack("<HHII", 257, 4, 1, 2**20) + b"\0\0\0\0",
            "cut.npy": b"\x93NUMPY\x01\0\x76\0{'descr': '<f4', 'fortran_order': False, 'shape': (9, 9), }",
            "cut.h5": b"\x89HDF\r\n\x1a\n" + bytes(40),
        }
        for name, contents in files.items():
            (self.folder / name).write_bytes(contents)
            done = self.run_program("score", name, "--set", "texture.samples=uniform", expect=2)
            self.assertIn(f"{name}: ", done.stderr)

    def test_little_address_space_is_named(self):
        # The image libraries start threads while they are loaded, and end the process where these find no room.
        for program in ("noiseloom", "noiseloom-study"):
            for kilobytes in (400_000, 450_000, 480_000, 520_000):
                done = subprocess.run(["bash", "-c", f"ulimit -v {kilobytes}; exec \"$0\" score a.png --set "
                                       "texture.samples=uniform", str(support.BIN / program)],
                                      capture_output=True, text=True, cwd=self.folder)
                self.assertIn(done.returncode, (0, 1), f"{program} {kilobytes}: {done.stderr}")
                if done.returncode == 1:
                    self.assertIn("memory", done.stderr)

    def test_only_images_need_the_image_library(self):
        numpy.save(self.folder / "a.npy", self.codes)
        for program in ("noiseloom", "noiseloom-study"):
            shutil.copy(support.BIN / program, self.folder / program)  # without the module that is beside them
        for name, status in ("a.npy", 0), ("a.png", 1):
            done = subprocess.run([self.folder / "noiseloom", "score", name, "--set", "texture.samples=uniform"],
                                  capture_output=True, text=True, cwd=self.folder)
            self.assertEqual(done.returncode, status, done.stderr)
        self.assertIn("the library that reads and writes images cannot be loaded: noiseloom-images.so", done.stderr)


if __name__ == "__main__":
    support.main()
