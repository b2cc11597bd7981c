"""verify finds what was done to a texture, and nothing in textures that are as they were made."""

import json
import os
import pathlib
import re
import unittest

import support

try:
    import h5py
    import numpy
    from PIL import Image
except ImportError as missing:
    print(f"skipped: {missing}")
    raise SystemExit(77)

PRODUCT = """combine = "product"
groups = [ { axes = "xy", kernel = "gauss", sigma = 1.0 }, { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 } ]"""
SUM = PRODUCT.replace("product", "sum")
STBN = """combine = "sum"
groups = [ { axes = "xy", kernel = "gauss-energy", sigma = 1.9 }, { axes = "t", kernel = "gauss-energy", sigma = 1.9 } ]"""
VOLUME = 'groups = [ { axes = "xyt", kernel = "gauss-energy", sigma = 1.5 } ]'
PLANE = 'groups = [ { axes = "xy", kernel = "%s" } ]'


def config(samples, filter, size="x = 48, y = 48, t = 8", optimizer="stop = { iterations = 6 }", seed=1):
    """The tables of a config."""
    filter = ", ".join(filter.split("\n"))
    return f"{{ size = {{ {size} }}, samples = {samples}, seed = {seed} }}", f"{{ {filter} }}", f"{{ {optimizer} }}"


# As textures are made: all spaces, filters and sizes that other tests of verify take for sound.
GOOD = {
    "uniform-product": config('"uniform"', PRODUCT, optimizer=""),
    "uniform-sum": config('"uniform"', SUM, optimizer=""),
    "uniform-box": config('"uniform"', PLANE.replace('"%s"', '"box", size = 5'), "x = 128, y = 128"),
    "tent": config('"tent"', PRODUCT, optimizer=""),
    "gauss": config('"gauss"', PRODUCT, optimizer=""),
    "circle": config('"circle"', PRODUCT, "x = 32, y = 32, t = 8", ""),
    "mask": config('"uniform"', STBN, "x = 64, y = 64, t = 16", 'method = "void-and-cluster"'),
    "mask-2d": config('"uniform"', PLANE % "gauss-energy", "x = 64, y = 64", 'method = "void-and-cluster"'),
    "vector2": config('"vector2"', PRODUCT, "x = 32, y = 32, t = 8"),
    "vector2-stbn": config('"vector2"', STBN, "x = 32, y = 32, t = 8"),
    "vector3": config('"vector3"', PLANE.replace('"%s"', '"gauss", sigma = 1.0'), "x = 48, y = 48"),
    "vector4": config('"vector4"', PLANE.replace('"%s"', '"gauss", sigma = 1.0'), "x = 64, y = 64"),
    "disk": config('"disk"', PLANE.replace('"%s"', '"gauss", sigma = 1.0'), "x = 48, y = 48"),
    "sphere": config('"sphere"', PLANE.replace('"%s"', '"gauss", sigma = 1.0'), "x = 48, y = 48"),
    "hemisphere": config('"hemisphere"', PLANE.replace('"%s"', '"gauss", sigma = 1.0'), "x = 48, y = 48"),
    "cosine": config('"hemisphere-cosine"', PRODUCT, "x = 32, y = 32, t = 8"),
    "triangle": config('"triangle"', PLANE.replace('"%s"', '"gauss", sigma = 1.0'), "x = 48, y = 48"),
    "rotation": config('"rotation"', PLANE.replace('"%s"', '"gauss", sigma = 1.0'), "x = 48, y = 48"),
    "nets": config('"sobol-owen"', PLANE.replace('"%s"', '"gauss", sigma = 1.0'), "x = 64, y = 64, t = 2"),
    "averages": config('"uniform"', PRODUCT.replace('"ema", alpha = 0.1, rejection = 0.1', '"box", size = 4'), "x = 48, y = 48, t = 12", ""),
    "mask-with-ends": config('"uniform"', STBN, "x = 48, y = 48, t = 24", 'method = "void-and-cluster", bounded = "t"'),
    "mask-of-a-volume": config('"uniform"', VOLUME, "x = 48, y = 48, t = 24", 'method = "void-and-cluster", bounded = "t"'),
    "mask-with-edges": config('"uniform"', VOLUME, "x = 48, y = 48, t = 24", 'method = "void-and-cluster", bounded = "xyt", equalize = "slice"'),
    "tiles": config('"uniform"', VOLUME.replace("xyt", "xyk").replace("1.5", '1.5, tiles = "k"'), "x = 48, y = 48, k = 8", 'method = "void-and-cluster", equalize = "slice"'),
    "odd": config('"uniform"', PRODUCT, "x = 53, y = 37, t = 11", ""),
}


class VerifyTest(support.ProgramTest):
    runs = {}

    def run_of(self, name):
        if not self.runs:  # all of them in one process, as members of a bank
            self.write("base.toml", "".join(f"{table} = {value}\n" for table, value in zip(("texture", "filter", "optimizer"), GOOD["mask"])))
            tables = (f'"{table}" = [{", ".join(values)}]\n' for table, values in zip(("texture", "filter", "optimizer"), zip(*GOOD.values())))
            self.write("bank.toml", 'base = "base.toml"\ncombine = "side-by-side"\n[vary]\n' + "".join(tables))
            self.run_program("bank", "bank.toml", "-o", "bank", "--threads", "1", "--quiet")
            for number, made in enumerate(GOOD, 1):
                self.runs[made] = (self.folder / "bank" / f"texture-{number}_filter-{number}_optimizer-{number}.h5").read_bytes()
        path = self.folder / f"{name}.h5"
        path.write_bytes(self.runs[name])
        return path

    def values(self, name):
        """[slice, y, x, channel]"""
        with h5py.File(self.run_of(name)) as file:
            return file["/samples"][...]

    def verified(self, *arguments, expect):
        done = self.run_program("verify", *arguments, "--json", expect=expect)
        return json.loads(done.stdout)

    def faults(self, array, *arguments, name="texture.npy"):
        """Kinds of fault in a file of 8 bits that holds `array` [slice, y, x, channel] of 0 to 1 (or of codes)."""
        codes = array if array.dtype == numpy.uint8 else numpy.clip(numpy.floor(array * 256), 0, 255).astype("u1")
        if codes.shape[-1] == 4:  # the last of an image is alpha
            name = "texture.png"
            Image.fromarray(codes.reshape(-1, *codes.shape[2:])).save(self.folder / name)
        else:
            numpy.save(self.folder / name, codes)
            arguments = ["--type", "uint8", "--axes", "tyxc", *arguments]
        self.verified_as = [name, *arguments]
        done = self.run_program("verify", name, "--json", *arguments, expect=None)
        self.assertIn(done.returncode, (0, 3), done.stderr)
        result = json.loads(done.stdout)
        self.assertEqual(result["sound"], done.returncode == 0)
        self.assertEqual(result["sound"], not result["faults"])
        self.result = result
        self.words = " ".join(fault["text"] for fault in result["faults"])
        return [fault["kind"] for fault in result["faults"]]

    def test_nothing_is_found_in_what_was_made(self):
        paths = [self.run_of(name) for name in GOOD]
        for result in self.verified(*paths, expect=0):
            self.assertTrue(result["sound"])
            self.assertFalse(result["faults"])
            self.assertEqual(result["taken_for"]["why"], "the file says so")

    def write_strip(self, name, file_name, low, high, with_density=False):
        """The PNG that export makes, without what it says of its run."""
        values = self.values(name)
        channels = [(value - low) / (high - low) for value in numpy.moveaxis(values, -1, 0)]
        if len(channels) == 2:
            channels.append(numpy.zeros_like(channels[0]))
        if with_density:
            with h5py.File(self.folder / f"{name}.h5") as file:
                channels.append(file["/pdf"][...].reshape(channels[0].shape) / file["/pdf"][...].max())
        codes = numpy.clip(numpy.floor(256 * numpy.stack(channels, axis=-1)), 0, 255).astype("u1")
        strip = codes.reshape(-1, codes.shape[-2], codes.shape[-1])
        Image.fromarray(strip[..., 0] if strip.shape[-1] == 1 else strip).save(self.folder / file_name)
        return file_name

    def test_files_that_say_nothing_are_taken_for_what_they_are(self):
        unit, signed = (0, 1), (-1, 1)
        strips = [
            ("uniform-product", "uniform", unit, False), ("tent", "tent", unit, False), ("vector2", "vector2", unit, False),
            ("disk", "disk", signed, False), ("vector3", "vector3", unit, False), ("sphere", "sphere", signed, False),
            ("hemisphere", "hemisphere", signed, False), ("mask", "uniform", unit, False),
            ("cosine", "hemisphere-cosine", signed, False), ("cosine", "hemisphere-cosine", signed, True),
            ("rotation", "rotation", signed, False), ("vector4", "vector4", unit, False), ("gauss", "gauss", (-4, 4), False),
            ("triangle", "triangle", signed, False)]
        files = [self.write_strip(name, f"{i}.png", *limits, density) for i, (name, _, limits, density) in enumerate(strips)]
        for (name, space, _, _), result in zip(strips, self.verified(*files, expect=0)):
            self.assertEqual(result["taken_for"]["samples"], space)
            self.assertNotIn("says", result["taken_for"]["why"], name)
            self.assertEqual(result["faults"], [], name)

    def test_published_textures_are_sound(self):
        folder = pathlib.Path(os.environ.get("NOISELOOM_PUBLISHED", support.SOURCE / ".." / "shared" / "published"))
        if not folder.is_dir():
            self.skipTest("the published textures are not there (NOISELOOM_PUBLISHED names their folder)")
        # The one of many slices takes seconds.
        files = [path for path in sorted(folder.glob("*.png")) if support.THOROUGH or path.stat().st_size < 500_000]
        for result in self.verified(*files, expect=0):
            self.assertFalse(result["faults"], result["file"])

    def test_bent_and_stretched_values(self):
        values = self.values("uniform-product")
        srgb = numpy.where(values < 0.0031308, 12.92 * values, 1.055 * values ** (1 / 2.4) - 0.055)
        for bent, words in [(values ** 2.2, "decoded from sRGB"), (values ** (1 / 2.2), "encoded as sRGB"), (srgb, "encoded as sRGB"),
                            (0.2 + 0.6 * values, "0 to 1 became 0.2")]:
            self.assertEqual(self.faults(bent, "--set", "texture.samples=uniform"), ["gamma"])
            self.assertIn(words, self.words)
        self.assertIn(words, self.run_program("verify", *self.verified_as, expect=3).stdout)
        self.assertIn("levels", self.faults((values > 0.5).astype(float), "--set", "texture.samples=uniform"))
        self.assertIn("unit-length", self.faults((0.5 + 0.5 * self.values("cosine")) ** 1.5,
                                                  "--set", "texture.samples=hemisphere-cosine"))

    def test_a_slice_with_a_histogram_of_its_own(self):
        values = self.values("uniform-product").copy()
        values[5] = values[5] ** 1.5
        self.assertIn("slice-distribution", self.faults(values))

    def test_samples_outside_of_their_space(self):
        disk = 0.5 + 0.5 * self.values("disk").reshape(1, 48, 48, 2)
        disk[0, 5, 7] = [0.99, 0.98]
        self.assertEqual(self.faults(disk, "--set", "texture.samples=disk"), ["support"])
        self.assertIn("1 of 2304", self.words)
        cosine = 0.5 + 0.5 * self.values("cosine")
        cosine[0, 0, 0] = 0.5
        self.assertEqual(self.faults(cosine), ["unit-length"])

    def test_alpha(self):
        colours = numpy.floor(self.values("vector3").reshape(1, 48, 48, 3) * 256).astype("u1")
        alpha = numpy.floor(self.values("uniform-product")[:1] * 256).astype("u1")
        multiplied = (colours.astype(int) * alpha // 255).astype("u1")
        kinds = []
        for number, (first, last) in enumerate(((multiplied, alpha), (colours, colours[..., :1]), (colours, alpha))):
            Image.fromarray(numpy.concatenate([first, last], axis=-1)[0]).save(self.folder / f"{number}.png")
        for result in self.verified("0.png", "1.png", "2.png", "--set", "texture.samples=vector3", expect=3):
            kinds.append([fault["kind"] for fault in result["faults"]])
        self.assertIn("alpha", kinds[0])
        self.assertEqual(kinds[1:], [["alpha"], []])

    def test_slices_that_repeat_or_are_mirrored_missing_or_swapped(self):
        for name in ("uniform-product", "vector2"):
            values = self.values(name)
            self.assertEqual(self.faults(values), [])
            repeated = values.copy()
            repeated[6] = repeated[3]
            self.assertIn("repeated-slices", self.faults(repeated))
            mirrored = values.copy()
            mirrored[6] = mirrored[3][:, ::-1]
            self.assertIn("mirrored-slices", self.faults(mirrored))
        # Neighbours in time that push each other off firmly: those of stacking frames, and averages of few.
        values = self.values("mask")
        self.assertEqual(self.faults(values), [])
        self.assertEqual(self.faults(numpy.delete(values, 7, axis=0)), ["slice-order"])
        swapped = values[[0, 1, 2, 3, 8, 5, 6, 7, 4, 9, 10, 11, 12, 13, 14, 15]]
        self.assertEqual(self.faults(swapped), ["slice-order"])
        self.assertEqual(self.faults(values[:13]), ["slice-loop"])
        # A filter over x, y and time leaves little of that at the same pixel: their spectra show it.
        values = self.values("averages")
        self.assertEqual(self.faults(values), [])
        self.assertEqual(self.faults(numpy.delete(values, 5, axis=0)), ["slice-order"])
        self.assertIn("slices are missing after slice 4", self.words)

    def test_edges_that_do_not_tile(self):
        values = self.values("uniform-product")
        self.assertEqual(self.faults(values), [])
        self.assertEqual(self.faults(values[:, :, :41]), ["border"])
        self.assertEqual(self.faults(values[:, :41]), ["border"])
        values = self.values("mask-2d").reshape(1, 64, 64, 1)
        self.assertEqual(self.faults(values[:, :, :53]), ["border"])
        # One slice, made for a box: a Gauss sees no border of it, a box does.
        values = self.values("uniform-box").reshape(1, 128, 128, 1)
        self.assertEqual(self.faults(values), [])
        self.assertEqual(self.faults(values[:, :, :113]), ["border"])
        self.assertIn("a box of 5 leaves", self.words)
        self.assertEqual(self.faults(values[:, 11:]), ["border"])
        tiled = numpy.tile(self.values("mask-2d").reshape(1, 64, 64, 1), (1, 2, 2, 1))
        self.assertIn("repeats-inside", self.faults(tiled))

    def test_noise_that_is_white(self):
        random = numpy.random.default_rng(5).random((16, 64, 64, 1))
        self.assertIn("white", self.faults(random))
        slices = [self.values("mask-2d")]
        random = numpy.random.default_rng(2)
        for _ in range(15):  # each blue in space, unrelated in time
            slices.append(numpy.roll(slices[0], tuple(random.integers(0, 64, 2)), (-3, -2)))
        stack = numpy.concatenate([s.reshape(1, 64, 64, 1) for s in slices])
        self.assertEqual(self.faults(stack), [])
        self.assertRegex(self.remark("time"), r"t is white: .* power .*, and an exponential average .* leaves")
        self.assertEqual(self.faults(stack, name="stbn_scalar_2Dx1D_64x64x16.npy"), ["white-in-time"])
        # A third of one slice is opposite to the slice before it: too little to be sure of, too much to be called a fault.
        hardly = stack.copy()
        opposite = random.random(hardly[5].shape) < 0.35
        hardly[5] = numpy.where(opposite, 1 - hardly[4], hardly[5])
        self.assertEqual(self.faults(hardly, name="stbn_scalar_2Dx1D_64x64x16.npy"), [])
        self.assertIn("t is white, or hardly blue", self.remark("time"))

    def test_what_is_said_of_time_is_what_it_was_decided_by(self):
        self.assertEqual(self.faults(self.values("mask")), [])
        said = re.fullmatch(r"t is blue: the lower quarter of its frequencies has the power ([\d.]+) \(white noise: within "
                            r"([\d.]+) of 1\)", self.remark("time"))
        self.assertLess(float(said[1]), 1 - float(said[2]))
        self.assertEqual(self.faults(self.values("uniform-product")), [])
        said = re.fullmatch(r"t is blue where a Gauss looks: .* leaves ([\d.]+) times .* no less than ([\d.]+)\)",
                            self.remark("time"))
        self.assertLess(float(said[1]), float(said[2]))

    def remark(self, kind):
        (text,) = [remark["text"] for remark in self.result["remarks"] if remark["kind"] == kind]
        return text

    def test_a_pattern_that_is_seen(self):
        values = self.values("uniform-box").reshape(128, 128)
        wave = values + 0.15 * numpy.sin(2 * numpy.pi * (11 * numpy.arange(128)[None] + 5 * numpy.arange(128)[:, None]) / 128)
        ranks = numpy.argsort(numpy.argsort(wave, axis=None)).reshape(1, 128, 128, 1)
        self.assertEqual(self.faults((ranks + 0.5) / 16384), ["peaks"])

    def test_codes_of_8_bits_in_16(self):
        codes = numpy.floor(self.values("uniform-product") * 256).astype("<u2") * 257
        numpy.save(self.folder / "codes.npy", codes[..., 0])
        result = self.verified("codes.npy", "--type", "uint16", "--set", "texture.samples=uniform", "--axes", "tyx", expect=3)
        self.assertEqual([fault["kind"] for fault in result["faults"]], ["levels"])

    def test_ktx2_that_is_marked_as_colours(self):
        self.run_program("export", self.run_of("vector2"), "-o", "a.ktx2")
        self.verified("a.ktx2", expect=0)
        data = bytearray((self.folder / "a.ktx2").read_bytes())
        data[12:16] = (22).to_bytes(4, "little")  # R8G8 sRGB
        (self.folder / "b.ktx2").write_bytes(data)
        self.assertEqual([f["kind"] for f in self.verified("b.ktx2", expect=3)["faults"]], ["srgb"])

    def test_a_file_that_is_none_is_refused(self):
        self.write("text.png", "no image")
        self.run_program("verify", "text.png", expect=2)
        self.run_program("verify", "none.png", expect=2)


if __name__ == "__main__":
    support.main()
