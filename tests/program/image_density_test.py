"""Samples whose density is an image: the same from every container, kept in the run file, never read again."""

import json
import os
import shutil
import subprocess

import numpy

from support import BIN, PLAIN_CPU, ProgramTest, main

CONFIG = """
[texture]
size    = { x = 24, y = 16, t = 3 }
samples = { image = "sky.npy", onto = "sphere", encoding = "linear" }
[filter]
groups  = [ { axes = "xy", kernel = "gauss", sigma = 0.9 }, { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 } ]
[optimizer]
stop = { iterations = 40 }
"""
HEIGHT, WIDTH = 10, 23


def sky():
    y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH]
    light = (x * 3 + y * 5) % 17 / 16 + (x == 7) * (y == 3)
    light[:, 11] = 0
    return light.astype(numpy.float32)


class ImageDensity(ProgramTest):
    def setUp(self):
        super().setUp()
        numpy.save(self.folder / "sky.npy", sky())
        self.config = self.write("run.toml", CONFIG)

    def generate(self, output, *arguments, **options):
        return self.run_program("generate", self.config, "-o", output, "--progress", "none", *arguments, **options)

    def read(self, name):
        import h5py

        with h5py.File(self.folder / name) as file:
            return file["samples"][...], file["pdf"][...]

    def oiio(self, *arguments):
        subprocess.run(["oiiotool", *arguments], check=True, cwd=self.folder, capture_output=True)

    def luminance_at(self, samples):
        """From the definition of the equirectangular image with y up."""
        v = numpy.arccos(numpy.clip(samples[..., 1], -1, 1)) / numpy.pi
        u = numpy.arctan2(samples[..., 2], samples[..., 0]) / (2 * numpy.pi) % 1
        return sky()[numpy.minimum((v * HEIGHT).astype(int), HEIGHT - 1), numpy.minimum((u * WIDTH).astype(int), WIDTH - 1)]

    def test_samples_and_their_density(self):
        self.generate("run.h5")
        samples, pdf = self.read("run.h5")
        self.assertTrue(numpy.allclose(numpy.linalg.norm(samples, axis=-1), 1, atol=1e-6))
        light = self.luminance_at(samples)
        self.assertGreater(light.min(), 0)
        factor = pdf / light
        self.assertLess(factor.max() / factor.min() - 1, 1e-5)  # the density is the luminance, up to one number
        # Of independent samples, 1 / pdf has the support's solid angle as its mean; strata come nearer.
        edges = numpy.cos(numpy.pi * numpy.arange(HEIGHT + 1) / HEIGHT)
        support = ((sky() > 0) * (edges[:-1] - edges[1:])[:, None]).sum() * 2 * numpy.pi / WIDTH
        error = (1 / pdf).std() / numpy.sqrt(pdf.size)
        self.assertLess(abs((1 / pdf).mean() - support), 4 * error)

    def test_same_bytes_from_every_container(self):
        """PNG and .npy of the same codes; TIFF, EXR and .npy of the same floats."""
        from PIL import Image

        codes = numpy.arange(HEIGHT * WIDTH, dtype=numpy.uint8).reshape(HEIGHT, WIDTH)
        numpy.save(self.folder / "codes.npy", codes)
        Image.fromarray(codes).save(self.folder / "codes.png")
        Image.fromarray(sky(), mode="F").save(self.folder / "sky.tif")
        self.oiio("sky.tif", "-o", "sky.exr")
        self.oiio("sky.tif", "--ch", "0,0,0", "-o", "sky.hdr")
        checksums = {}
        for image in ("codes.npy", "codes.png", "sky.npy", "sky.tif", "sky.exr", "sky.hdr"):
            self.generate("a.h5", "--overwrite", "--set", f"texture.samples.image={image}")
            checksums[image] = self.samples_checksum("a.h5")
        self.assertEqual(checksums["codes.npy"], checksums["codes.png"])
        self.assertEqual(checksums["sky.npy"], checksums["sky.tif"])
        self.assertEqual(checksums["sky.npy"], checksums["sky.exr"])
        self.assertEqual(checksums["sky.npy"], checksums["sky.hdr"])  # sixteenths fit into the 8 bits that HDR has

    def test_same_bytes_on_ranks_threads_and_processors(self):
        self.generate("one.h5")
        one = (self.folder / "one.h5").read_bytes()
        expected = self.samples_checksum("one.h5")
        for ranks in (2, 3):
            self.generate("many.h5", "--overwrite", ranks=ranks)
            self.assertEqual(self.samples_checksum("many.h5"), expected)
        self.generate("plain.h5", "--threads", 2, environment=PLAIN_CPU)
        self.assertEqual(self.samples_checksum("plain.h5"), expected)
        self.assertEqual(one, (self.folder / "one.h5").read_bytes())

    def test_never_reads_the_image_again(self):
        from PIL import Image

        Image.fromarray(sky(), mode="F").save(self.folder / "sky.tif")
        arguments = ("--set", "texture.samples.image=sky.tif")
        self.generate("whole.h5", *arguments)
        self.generate("part.h5", *arguments, "--time-limit", "0.01s", expect=75)
        (self.folder / "sky.tif").unlink()
        self.generate("part.h5", *arguments, "--resume", "--time-limit", "0.01s", expect=None)
        self.generate("part.h5", *arguments, "--resume", ranks=2)
        self.assertEqual(self.samples_checksum("part.h5"), self.samples_checksum("whole.h5"))
        scored = json.loads(self.run_program("score", "part.h5", "--json").stdout)["relative_error"]
        self.assertLess(scored, 0.6)
        self.run_program("export", "part.h5", "-o", "out/", "--pdf", "separate")
        self.assertTrue((self.folder / "out" / "part_2_pdf.png").exists())
        self.run_program("analyze", "part.h5", "-o", "report")
        self.assertNotIn("sky.tif", self.run_program("info", "part.h5").stderr)

    def test_what_is_no_density_is_refused(self):
        from PIL import Image

        Image.new("L", (4, 4)).save(self.folder / "black.png")
        numpy.save(self.folder / "nan.npy", numpy.array([[1, numpy.nan], [2, 3]]))
        numpy.save(self.folder / "negative.npy", numpy.array([[1, -1], [2, 3]]))
        numpy.save(self.folder / "deep.npy", numpy.ones((2, 2, 2, 2)))
        self.write("text.png", "no image")
        self.generate("kept.h5")
        before = (self.folder / "kept.h5").read_bytes()
        for image, words in (("black.png", "every pixel is black"),
                             ("nan.npy", "pixel 1, 0"), ("negative.npy", "negative"), ("deep.npy", "shape (2, 2, 2, 2)"),
                             ("text.png", "not an image"), ("none.exr", "no such file")):
            for command in (("generate", "-o", "kept.h5", "--overwrite"), ("plan",)):
                with self.subTest(image=image, command=command[0]):
                    done = self.run_program(command[0], self.config, *command[1:], "--set", f"texture.samples.image={image}",
                                            expect=2)
                    self.assertIn(words, done.stderr)
                    self.assertIn(image, done.stderr)
        self.assertEqual((self.folder / "kept.h5").read_bytes(), before)

    def test_numbers_that_may_be_codes_are_told_of(self):
        from PIL import Image

        Image.fromarray(numpy.full((4, 4), 128, numpy.uint8)).save(self.folder / "grey.png")
        text = CONFIG.replace("sky.npy", "grey.png").replace(', encoding = "linear"', "")
        told = self.run_program("generate", self.write("told.toml", text), "-o", "told.h5")
        self.assertIn('encoding = "srgb"', told.stderr)
        for encoding in ("linear", "srgb"):
            stated = self.run_program("generate", self.config, "-o", f"{encoding}.h5", "--set", "texture.samples.image=grey.png",
                                      "--set", f"texture.samples.encoding={encoding}")
            self.assertNotIn("WARNING", stated.stderr)
        self.assertIn("encoding", self.run_program("plan", "told.toml").stdout)

    def test_says_what_is_missing_without_the_other_program(self):
        """noiseloom reads .npy itself; for images it needs noiseloom-study beside it."""
        from PIL import Image

        Image.fromarray(sky(), mode="F").save(self.folder / "sky.tif")
        alone = self.folder / "bin"
        alone.mkdir()
        shutil.copy(BIN / "noiseloom", alone)
        for image, status in (("sky.npy", 0), ("sky.tif", 1)):
            done = subprocess.run([alone / "noiseloom", "generate", "run.toml", "-o", "x.h5", "--overwrite", "--set",
                                   f"texture.samples.image={image}"], cwd=self.folder, capture_output=True, text=True,
                                  env={**os.environ, "PATH": "/nowhere"})
            self.assertEqual(done.returncode, status, done.stderr)
        self.assertIn("noiseloom-study", done.stderr)


if __name__ == "__main__":
    main()
