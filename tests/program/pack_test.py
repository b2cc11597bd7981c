"""export --pack: several run files in one texture, and what the file says of them."""

import json
import shutil
import subprocess
import unittest

import support

try:
    import numpy

    import image_readers
    from containers_test import CONFIG, NODE_MODULES, READ_KTX2, codes, not_tried
except ImportError as missing:
    print(f"skipped: {missing}")
    raise SystemExit(77)


class PackTest(support.ProgramTest):
    def setUp(self):
        super().setUp()
        self.values = {}
        for name, samples in [("lens", "vector2"), ("time", "uniform"), ("way", "sphere"), ("bell", "gauss")]:
            self.run_program("generate", self.write(f"{name}.toml", CONFIG % samples), "-o", f"{name}.h5")
            self.run_program("export", f"{name}.h5", "-o", f"{name}.npy")
            self.values[name] = numpy.load(self.folder / f"{name}.npy")

    def pack(self, output, packing, *files, arguments=(), expect=0):
        return self.run_program("export", *files, "-o", output, "--pack", packing, *arguments, expect=expect)

    def expected(self, bits):
        opaque = numpy.full((3, 11, 13, 1), 2**bits - 1)
        return numpy.concatenate([codes(self.values["lens"], bits), codes(self.values["time"], bits), opaque], axis=-1)

    def test_channels_hold_what_was_asked_for(self):
        self.pack("a.png", "RG=lens,B=time,A=1", "lens.h5", "time.h5", arguments=["--layout", "strip", "--depth", "16"])
        pixels, chunks = image_readers.read_png(self.folder / "a.png")
        numpy.testing.assert_array_equal(pixels.reshape(3, 11, 13, 4), self.expected(16))
        text = (self.folder / "a.png").read_bytes()
        self.assertTrue({"tEXt", "zTXt", "iTXt"} & set(chunks))
        for words in (b"noiseloom:R\0", b"channel 0 of lens", b"noiseloom:B\0", b"seed 1", b"config of time", b"checksum"):
            self.assertIn(words, text)
        # Directions by their range, one channel alone, and channels in another order.
        self.pack("b.npy", "B=way.2,R=time,G=0.25", "way.h5", "time.h5")
        read = numpy.load(self.folder / "b.npy")
        numpy.testing.assert_array_equal(read[..., 0], self.values["time"][..., 0])
        numpy.testing.assert_array_equal(read[..., 2], self.values["way"][..., 2])
        self.assertTrue((read[..., 1] == 0.25).all())
        self.pack("c.raw", "RGB=way", "way.h5", arguments=["--depth", "8"])
        numpy.testing.assert_array_equal(numpy.fromfile(self.folder / "c.raw", "u1").reshape(3, 11, 13, 3),
                                         codes(0.5 + 0.5 * self.values["way"].astype(float), 8))
        self.assertIn("channel 2 of way", json.loads((self.folder / "c.json").read_text())["B"])
        # A file of one run says as much.
        self.run_program("export", "time.h5", "-o", "one.raw")
        said = json.loads((self.folder / "one.json").read_text())
        self.assertEqual(said["checksum"], self.info("time.h5")["checksums"]["/samples"])
        for key in ("config", "seed", "filter", "relative_error"):
            self.assertIn(key, said)

    def test_ktx2_and_exr_and_tiff_say_what_channels_hold(self):
        for name, arguments in [("a.exr", []), ("a.tif", [])]:
            self.pack(name, "RG=lens,B=time", "lens.h5", "time.h5", arguments=["--layout", "strip", *arguments])
            data = (self.folder / name).read_bytes()
            for words in (b"channel 1 of lens", b"channel 0 of time", b"filter box 3 over xy"):
                self.assertIn(words, data, name)
        if not (NODE_MODULES / "ktx-parse").is_dir() or shutil.which("node") is None:
            return not_tried("ktx-parse reads packed KTX2", "node or the package is missing (tools/setup --test)")
        self.pack("a.ktx2", "RG=lens,B=time,A=1", "lens.h5", "time.h5")
        script = self.write("read.mjs", READ_KTX2 % NODE_MODULES)
        read = json.loads(subprocess.run(["node", script, self.folder / "a.ktx2"], check=True, capture_output=True,
                                         text=True).stdout)
        self.assertEqual(bytes.fromhex(read["data"]), self.expected(8).astype("u1").tobytes())
        # It takes values of keys that it does not know for bytes.
        keys = {key: bytes(value.values()).rstrip(b"\0").decode() for key, value in read["keys"].items() if key.startswith("noiseloom")}
        self.assertIn("channel 1 of lens; samples vector2; seed 1", keys["noiseloom.G"])
        self.assertIn('samples = "uniform"', keys["noiseloom.config of time"])
        self.assertEqual(keys["noiseloom.A"], "1")

    def test_what_does_not_fit_is_refused(self):
        small = self.write("small.toml", (CONFIG % "uniform").replace("x = 13", "x = 12"))
        self.run_program("generate", small, "-o", "small.h5")
        for packing, files, words in [
            ("RG=lens,A=1", ["lens.h5"], "none left out"), ("RG=lens,G=time", ["lens.h5", "time.h5"], "G is given twice"),
            ("RGB=lens", ["lens.h5"], "lens.h5 has 2 channels"), ("R=lens", ["lens.h5"], "lens.0"),
            ("R=lens.2", ["lens.h5"], "2 channels"), ("R=tine", ["time.h5"], "accepted: time"),
            ("R=time,G=2", ["time.h5"], "from 0 to 1"), ("R=time,G=small", ["time.h5", "small.h5"], "12 x 11 x 3"),
            ("R:time", ["time.h5"], "RG=NAME"), ("R=bell", ["bell.h5"], "no fixed range"),
        ]:
            said = self.pack("bad.ktx2", packing, *files, expect=2).stderr
            self.assertIn(words, said)
        self.assertFalse((self.folder / "bad.ktx2").exists())
        self.pack("good.ktx2", "R=bell", "bell.h5", arguments=["--depth", "32f"])
        self.assertIn("several run files are for --pack",
                      self.run_program("export", "lens.h5", "time.h5", "-o", "x/", expect=2).stderr)
        self.pack("bad.ktx2", "R=time", "time.h5", arguments=["--slices", "0:1"], expect=2)


if __name__ == "__main__":
    support.main()
