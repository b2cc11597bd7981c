"""Exported files, read back without the library that wrote them, hold what the run file holds; score and analyze run."""

import json
import os
import pathlib
import subprocess
import unittest

import support

try:
    import h5py
    import numpy
    from PIL import Image

    import image_readers
except ImportError as missing:
    print(f"skipped: {missing}")
    raise SystemExit(77)

CONFIG = """
[texture]
size = { x = 13, y = 11, t = 3 }
samples = "%s"
[filter]
combine = "product"
groups = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 } ]
[optimizer]
stop = { iterations = 1 }
"""


def codes(unit, bits):
    """floor(2^bits u), clamped, in double."""
    return numpy.clip(numpy.floor(unit.astype(float) * 2**bits), 0, 2**bits - 1).astype(int)


class ExportTest(support.ProgramTest):
    def generate(self, samples):
        config = self.write(f"{samples}.toml", CONFIG % samples)
        self.run_program("generate", config, "-o", f"{samples}.h5")
        with h5py.File(self.folder / f"{samples}.h5") as file:
            self.samples = file["/samples"][...]
            self.density = file["/pdf"][...] if "pdf" in file else None
        return f"{samples}.h5"

    def export(self, run_file, output, *arguments):
        self.run_program("export", run_file, "-o", output, *arguments)
        return self.folder / output

    def test_png_holds_the_floor_of_the_scaled_values(self):
        run_file = self.generate("vector3")
        for bits in (8, 16):
            folder = self.export(run_file, f"png{bits}/", "--depth", bits)
            for s in range(3):
                image, chunks = image_readers.read_png(folder / f"vector3_{s}.png")
                numpy.testing.assert_array_equal(image, codes(self.samples[s], bits))
                self.assertFalse({"gAMA", "sRGB", "iCCP", "cHRM"} & set(chunks), "colours are to be left alone")
        with Image.open(self.folder / "png8" / "vector3_1.png") as image:
            self.assertEqual(image.mode, "RGB")
            numpy.testing.assert_array_equal(numpy.asarray(image), codes(self.samples[1], 8))

    def test_published_names_come_with_the_published_channels(self):
        folder = self.export(self.generate("vector3"), "vectors/", "--naming", "nvidia")
        for s in range(3):
            with Image.open(folder / f"stbn_vec3_2Dx1D_13x11x3_{s}.png") as image:
                self.assertEqual(image.mode, "RGBA")
                pixels = numpy.asarray(image)
            numpy.testing.assert_array_equal(pixels[..., :3], codes(self.samples[s], 8))
            self.assertTrue((pixels[..., 3] == 255).all())
        folder = self.export(self.generate("uniform"), "scalars/", "--naming", "nvidia")
        with Image.open(folder / "stbn_vec1_2Dx1D_13x11x3_2.png") as image:
            self.assertEqual(image.mode, "L")

    def test_every_way_to_write_the_number_gives_the_same_names(self):
        run_file = self.generate("uniform")
        for place, name in [("{slice:03}", "002"), ("{}", "2"), ("%d", "2"), ("%03d", "002"), ("%i", "2"), ("####", "0002")]:
            self.export(run_file, f"places/a-{place}.PNG", "--overwrite")
            self.assertTrue((self.folder / f"places/a-{name}.PNG").exists(), place)
        self.assertIn("accepted", self.run_program("export", run_file, "-o", "places/a-*.png", expect=2).stderr)

    def test_scalars_are_grey(self):
        run_file = self.generate("uniform")
        strip = self.export(run_file, "strip.png", "--layout", "strip")
        with Image.open(strip) as image:
            self.assertEqual((image.mode, image.size), ("L", (13, 33)))
            numpy.testing.assert_array_equal(numpy.asarray(image).reshape(3, 11, 13), codes(self.samples[..., 0], 8))

    def test_two_channels_are_rgb_without_blue(self):
        run_file = self.generate("vector2")
        image, _ = image_readers.read_png(self.export(run_file, "v.png", "--slices", "2:3", "--layout", "strip"))
        self.assertEqual(image.shape, (11, 13, 3))
        numpy.testing.assert_array_equal(image[..., :2], codes(self.samples[2], 8))
        self.assertFalse(image[..., 2].any())

    def test_four_channels_are_not_multiplied_or_divided_by_alpha(self):
        run_file = self.generate("vector4")
        for bits in (8, 16):
            image, _ = image_readers.read_png(
                self.export(run_file, f"v{bits}.png", "--layout", "strip", "--depth", bits))
            numpy.testing.assert_array_equal(image.reshape(3, 11, 13, 4), codes(self.samples, bits))
        tiff = image_readers.read_tiff(self.export(run_file, "v.tif", "--layout", "strip", "--depth", "16"))
        numpy.testing.assert_array_equal(tiff.reshape(3, 11, 13, 4), codes(self.samples, 16))

    def test_directions_are_half_plus_half_with_density_in_alpha(self):
        run_file = self.generate("hemisphere-cosine")
        image, _ = image_readers.read_png(self.export(run_file, "d.png", "--layout", "strip", "--pdf"))
        image = image.reshape(3, 11, 13, 4)
        numpy.testing.assert_array_equal(image[..., :3], codes(0.5 + 0.5 * self.samples.astype(float), 8))
        density = self.density.astype(float)
        numpy.testing.assert_array_equal(image[..., 3], codes(density / density.max(), 8))

    def test_tiff_holds_integers_and_floats(self):
        run_file = self.generate("sphere")
        unit = 0.5 + 0.5 * self.samples.astype(float)
        for bits in (8, 16):
            tiff = image_readers.read_tiff(
                self.export(run_file, f"t{bits}.tif", "--layout", "strip", "--depth", bits))
            numpy.testing.assert_array_equal(tiff.reshape(self.samples.shape), codes(unit, bits))
        tiff = image_readers.read_tiff(self.export(run_file, "t.tif", "--layout", "strip", "--depth", "32f"))
        numpy.testing.assert_array_equal(tiff.reshape(self.samples.shape), self.samples)
        with Image.open(self.folder / "t8.tif") as image:
            numpy.testing.assert_array_equal(numpy.asarray(image).reshape(self.samples.shape), codes(unit, 8))

    def test_exr_holds_the_floats_themselves(self):
        run_file = self.generate("gauss")
        self.assertLess(self.samples.min(), 0)
        folder = self.export(run_file, "exr/", "--format", "exr", "--naming", "ea")
        for s in range(3):
            [(names, image)] = image_readers.read_exr(folder / f"real_gauss_box3x3_exp0101_product_{s}.exr")
            self.assertEqual(names, ["Y"])
            numpy.testing.assert_array_equal(image, self.samples[s])
        run_file = self.generate("sphere")
        parts = image_readers.read_exr(self.export(run_file, "parts.exr", "--layout", "exr-multipart"))
        self.assertEqual(len(parts), 3)
        for s, (names, image) in enumerate(parts):
            self.assertEqual(names, ["B", "G", "R"])
            numpy.testing.assert_array_equal(image[..., ::-1], self.samples[s])

    def test_hdr_holds_eight_bits_of_encoded_values(self):
        run_file = self.generate("disk")
        image = image_readers.read_hdr(self.export(run_file, "d.hdr", "--layout", "strip")).reshape(3, 11, 13, 3)
        unit = 0.5 + 0.5 * self.samples.astype(float)
        largest = unit.max(axis=-1, keepdims=True)  # of a pixel: it sets the common exponent
        self.assertLess((numpy.abs(image[..., :2] - unit) / largest).max(), 1 / 128)

    def test_arrays_hold_the_run_files_bytes(self):
        run_file = self.generate("sphere")
        array = numpy.load(self.export(run_file, "a.npy"))
        self.assertEqual(array.dtype, numpy.float32)
        numpy.testing.assert_array_equal(array, self.samples)
        raw = self.export(run_file, "a.raw", "--depth", "8")
        description = json.loads(raw.with_suffix(".json").read_text())
        self.assertEqual(description["shape"], [3, 11, 13, 3])
        self.assertEqual(description["axes"], ["t", "y", "x", "channel"])
        self.assertEqual(description["range"], [-1, 1])
        numbers = numpy.fromfile(raw, dtype=description["type"]).reshape(description["shape"])
        numpy.testing.assert_array_equal(numbers, codes(0.5 + 0.5 * self.samples.astype(float), 8))

    def test_wrong_requests_change_nothing(self):
        run_file = self.generate("uniform")
        (self.folder / "there.png").write_text("mine")
        before = sorted(self.folder.iterdir())
        for arguments, words in [
            (("-o", "there.png", "--layout", "strip"), "exists; --overwrite"),
            (("-o", "a/", "--format", "ktx"), "accepted: png, exr, tiff, hdr, ktx2, dds, npy, raw"),
            (("-o", "a.exr", "--depth", "8"), "accepted for exr: 32f"),
            (("-o", "a.png", "--depth", "12"), "accepted for png: 8, 16"),
            (("-o", "a/", "--slices", "1:9"), "0 <= A < B <= 3"),
            (("-o", "a/", "--pdf"), "constant"),
            (("-o", "a/", "--naming", "nvidea"), "nvidia"),
            (("-o", "-"), "standard output"),
            (("-o", "x.h5"), "accepted: png, exr, tiff"),
            (("-o", "a.csv"), "--threshold"),
            (("-o", "a_*.png"), "{slice:03}"),
        ]:
            done = self.run_program("export", run_file, *arguments, expect=2)
            self.assertIn(words, done.stderr, arguments)
        self.assertEqual(sorted(self.folder.iterdir()), before)
        self.assertEqual((self.folder / "there.png").read_text(), "mine")
        if os.geteuid() != 0:
            (self.folder / "closed").mkdir(mode=0o500)
            self.run_program("export", run_file, "-o", "closed/", expect=1)


class ScoreTest(support.ProgramTest):
    def test_images_and_run_file_score_alike(self):
        config = self.write("c.toml", CONFIG % "vector2")
        self.run_program("generate", config, "-o", "c.h5")
        self.run_program("export", "c.h5", "-o", "png/", "--depth", "16")
        from_run = json.loads(self.run_program("score", "c.h5", "--json", "--slices").stdout)
        from_images = json.loads(self.run_program("score", "png", "--config", config, "--json").stdout)
        self.assertAlmostEqual(from_run["relative_error"], from_images["relative_error"], delta=1e-4)
        self.assertAlmostEqual(sum(from_run["slices"]) / 3, from_run["relative_error"], places=12)
        stored = self.info("c.h5")["history"]["relative_error"][-1]
        self.assertAlmostEqual(from_run["relative_error"], stored, places=9)
        self.assertIn("R = ", self.run_program("score", "c.h5").stdout)
        for path in (self.folder / "png").iterdir():  # without what they say of themselves
            Image.fromarray(numpy.asarray(Image.open(path))).save(path)
        self.assertIn("--config", self.run_program("score", "png", expect=2).stderr)

    def test_published_texture_has_its_published_score(self):
        folder = pathlib.Path(os.environ.get("NOISELOOM_PUBLISHED", support.SOURCE / ".." / "shared" / "published"))
        if not folder.is_dir():
            self.skipTest("the published textures are not there (NOISELOOM_PUBLISHED names their folder)")
        config = self.write("p.toml", '[texture]\nsize = { x = 128, y = 128 }\nsamples = "uniform"\n'
                            '[filter]\ngroups = [ { axes = "xy", kernel = "box", size = 5 } ]\n')
        done = self.run_program("score", folder / "real_uniform_box_5.png", "--config", config, "--json")
        self.assertAlmostEqual(json.loads(done.stdout)["relative_error"], 0.1110, delta=0.0002)


class FromLoadingToUnloadingTest(support.ProgramTest):
    def test_commands_that_open_images_end_well_in_a_process_of_their_own(self):
        config = self.write("c.toml", CONFIG % "uniform")
        for arguments in (["generate", config, "-o", "c.h5", "--quiet"], ["export", "c.h5", "-o", "images/"], ["score", "c.h5"],
                          ["analyze", "c.h5", "-o", "report"]):
            self.assertEqual(self.run_program(*arguments, afresh=True).stderr, "", arguments)
        self.run_program("score", *sorted((self.folder / "images").glob("*.png")), "--config", config, afresh=True)


class LostOutputTest(support.ProgramTest):
    """A result that nobody received is no success."""

    def test_commands_fail_when_standard_output_cannot_be_written(self):
        config = self.write("c.toml", CONFIG % "uniform")
        self.run_program("generate", config, "-o", "c.h5")
        for arguments in (["export", "c.h5", "-o", "full/"], ["score", "c.h5"], ["score", "c.h5", "--json"],
                          ["analyze", "c.h5", "-o", "report"], ["export", "--help"]):
            command = self.command(*arguments)
            with open("/dev/full", "w") as full:
                done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, cwd=self.folder)
            self.assertEqual(done.returncode, 1, arguments)
            self.assertIn("No space left on device", done.stderr, arguments)
        for number, arguments in enumerate((["export", "c.h5", "-o", "closed/"], ["score", "c.h5"])):
            done = subprocess.run(self.command(*arguments), stderr=subprocess.PIPE, text=True, cwd=self.folder,
                                  preexec_fn=lambda: os.close(1))
            self.assertEqual(done.returncode, 1, arguments)
            self.assertIn("standard output", done.stderr, arguments)
        # Nothing that was printed went into a file that was opened instead.
        for path in (self.folder / "closed").iterdir():
            self.assertNotIn(b"wrote", path.read_bytes())


    def test_messages_that_cannot_be_printed_change_no_exit_status(self):
        config = self.write("c.toml", CONFIG % "uniform")
        self.run_program("generate", config, "-o", "c.h5")
        for arguments, status in ((["score", "none.h5"], 2), (["export", "c.h5", "-o", "c.jpg"], 2), (["score", "c.h5", "--thread", "2"], 2),
                                  (["analyze", "c.h5", "-o", "-"], 2), (["export", "c.h5", "-o", "c.npy", "--overwrite"], 0)):
            command = " ".join(str(word) for word in self.command(*arguments))
            for redirection in ("2>&-", "2>/dev/full", "2>&- <&-"):
                done = subprocess.run(["bash", "-c", f"{command} {redirection}"], cwd=self.folder, capture_output=True)
                self.assertEqual(done.returncode, status, f"{arguments} {redirection}")
            done = subprocess.run(["bash", "-c", f"{command} 2>&- >&- <&-"], cwd=self.folder, capture_output=True)
            self.assertEqual(done.returncode, status if status != 0 else 1, f"{arguments}, all closed")


class UnfinishedTest(support.ProgramTest):
    def test_an_export_of_a_run_that_goes_on_says_so(self):
        config = self.write("c.toml", CONFIG.replace("iterations = 1 ", "iterations = 1000000 ") % "uniform")
        self.run_program("generate", config, "-o", "c.h5", "--time-limit", "2s", "--progress", "none", expect=75)
        done = self.run_program("export", "c.h5", "-o", "c.raw")
        self.assertRegex(done.stderr, r"warning: c.h5: not finished: [0-9]+ of 1000000 iterations done")
        self.assertIn("not finished", json.loads((self.folder / "c.json").read_text())["unfinished"])


class AnalyzeTest(support.ProgramTest):
    def test_report_is_written_whole(self):
        config = self.write("c.toml", CONFIG % "uniform")
        self.run_program("generate", config, "-o", "c.h5")
        self.run_program("analyze", "c.h5", "-o", "report")
        names = {path.name for path in (self.folder / "report").iterdir()}
        self.assertLessEqual({"report.html", "preview.png", "spectrum_xy.png", "spectrum_xt.png", "spectrum_xy.csv"}, names)
        self.assertIn("exists", self.run_program("analyze", "c.h5", "-o", "report", expect=2).stderr)
        self.run_program("analyze", "c.h5", "-o", "report", "--overwrite")
        page = (self.folder / "report/report.html").read_text()
        self.assertRegex(page, r"noiseloom [0-9]+\.[0-9]+\.[0-9]+, [0-9]{4}-[0-9]{2}-[0-9]{2}")
        self.assertIn("noiseloom analyze c.h5 -o report --overwrite", page)

    def test_a_report_is_a_folder(self):
        config = self.write("c.toml", CONFIG % "uniform")
        self.run_program("generate", config, "-o", "c.h5")
        before = set(self.folder.iterdir())
        for name, words in (("-", "standard output"), ("page.html", "give the folder's name"), ("page.pdf", "give the folder's name"), ("", "is empty")):
            self.assertIn(words, self.run_program("analyze", "c.h5", "-o", name, expect=2).stderr)
        self.assertEqual(set(self.folder.iterdir()), before)

    def test_a_group_over_x_and_a_slice_axis_is_shown(self):
        text = (CONFIG % "uniform").replace('"xy", kernel', '"xt", kernel').replace('{ axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 }', '{ axes = "y", kernel = "box", size = 3 }')
        self.run_program("generate", self.write("xt.toml", text), "-o", "xt.h5")
        self.run_program("analyze", "xt.h5", "-o", "report")
        self.assertLessEqual({"spectrum_xt.png", "spectrum_xt.csv", "spectrum_t.csv"},
                             {path.name for path in (self.folder / "report").iterdir()})


if __name__ == "__main__":
    support.main()
