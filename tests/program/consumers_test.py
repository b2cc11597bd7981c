"""export --for X: read as X reads it, a texture is what the run file holds, to the quantisation."""

import json
import os
import re
import shutil
import subprocess
import unittest
import xml.etree.ElementTree

import support

try:
    import h5py
    import numpy
    from PIL import Image

    import image_readers
    from containers_test import NODE_MODULES, READ_KTX2, codes, not_tried
except ImportError as missing:
    print(f"skipped: {missing}")
    raise SystemExit(77)

CONFIG = """
[texture]
size = { x = %d, y = %d, t = %d }
samples = "%s"
[filter]
groups = [ { axes = "xy", kernel = "box", size = 3 }, { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 } ]
combine = "product"
[optimizer]
stop = { iterations = 1 }
"""
# What three.js' own loader makes of a KTX2 file. Numbers that need no decoding ask nothing of the renderer, which is left out.
LOAD_KTX2 = """
import { KTX2Loader } from '%s/three/examples/jsm/loaders/KTX2Loader.js';
import { readFileSync } from 'fs';
const bytes = readFileSync(process.argv[2]);
const loader = new KTX2Loader();
loader.workerConfig = {};
loader.parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength), texture => {
  const { data, width, height, depth } = texture.image;
  console.log(JSON.stringify({ volume: texture.isData3DTexture === true, size: [width, height, depth], format: texture.format,
    type: texture.type, data: Buffer.from(data.buffer, data.byteOffset, data.byteLength).toString('hex') }));
}, error => { throw error; });
"""
SMALL, LARGE, PBRT = (16, 16, 4), (128, 128, 64), (128, 128, 48)


class ConsumersTest(support.ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.runs = {}

    def exported(self, consumer, samples, size, *arguments):
        """Files that an export wrote, by their names, and the samples [slice, y, x, channel]."""
        name = f"{samples}{size[2]}"
        if (samples, size) not in self.runs:
            config = self.write(f"{name}.toml", CONFIG % (*size, samples))
            # What is read does not depend on how good it is: the large ones are made in a moment.
            quickly = [] if size == SMALL else ["--set", 'filter.groups=[{ axes = "xy", kernel = "box", size = 2 }]',
                                                "--set", "filter.combine=sum", "--set", "optimizer.method=anneal"]
            self.run_program("generate", config, "-o", f"{name}.h5", "--overwrite", *quickly)
            self.runs[samples, size] = (self.folder / f"{name}.h5").read_bytes()
        run_file = self.folder / f"{name}.h5"
        run_file.write_bytes(self.runs[samples, size])
        with h5py.File(run_file) as file:
            values = file["/samples"][...]
        folder = self.folder / "-".join([consumer, name, *arguments])
        self.run_program("export", run_file, "-o", f"{folder}/", "--for", consumer, *arguments)
        return {path.name: path for path in folder.iterdir()}, values

    def only(self, files, name):
        self.assertEqual(list(files), [name])
        return files[name]

    def test_unreal_reads_squares_of_a_strip(self):
        files, values = self.exported("unreal", "uniform", SMALL)
        with Image.open(self.only(files, "FastBlueNoise_scalar_16x16x4.png")) as image:
            self.assertEqual(image.mode, "L")
            pixels = numpy.asarray(image)
        size_y = pixels.shape[1]  # slices are squares: their height is the width of the image
        self.assertEqual(pixels.shape[0] // size_y, 4)
        for z in range(4):
            numpy.testing.assert_array_equal(pixels[z * size_y:(z + 1) * size_y], codes(values[z, ..., 0], 8))
        files, values = self.exported("unreal", "vector2", SMALL)
        pixels, _ = image_readers.read_png(self.only(files, "FastBlueNoise_vec2_16x16x4.png"))
        numpy.testing.assert_array_equal(pixels.reshape(4, 16, 16, 3)[..., :2], codes(values, 8))

    def test_rtxtf_reads_128_by_8192(self):
        files, values = self.exported("rtxtf", "vector2", LARGE)
        pixels, _ = image_readers.read_png(self.only(files, "STBlueNoise_vec2_128x128x64.PNG"))
        self.assertEqual(pixels.shape, (8192, 128, 3))
        numpy.testing.assert_array_equal(pixels.reshape(64, 128, 128, 3)[..., :2], codes(values, 8))

    def test_slices_of_unity_nvidia_and_gigi(self):
        for consumer, samples, depth, name, channels in [
            ("unity", "uniform", 16, "stbn_vec1_2Dx1D_16x16x4_{}.png", 1),
            ("unity", "vector2", 16, "stbn_vec2_2Dx1D_16x16x4_{}.png", 4),
            ("nvidia", "uniform", 8, "stbn_vec1_2Dx1D_16x16x4_{}.png", 1),
            ("nvidia", "vector2", 8, "stbn_vec2_2Dx1D_16x16x4_{}.png", 4),
            ("gigi", "uniform", 8, "real_uniform_box3x3_exp0101_product_{}.png", 4),
            ("gigi", "vector2", 8, "vector2_uniform_box3x3_exp0101_product_{}.png", 4),
        ]:
            files, values = self.exported(consumer, samples, SMALL)
            self.assertEqual(set(files), {name.format(z) for z in range(4)}, consumer)
            for z in range(4):
                pixels, _ = image_readers.read_png(files[name.format(z)])
                self.assertEqual(pixels.shape[2], channels, consumer)
                numpy.testing.assert_array_equal(pixels[..., :values.shape[-1]], codes(values[z], depth))
                if consumer == "gigi" and samples == "uniform":
                    for channel in (1, 2):
                        numpy.testing.assert_array_equal(pixels[..., channel], pixels[..., 0])
                if channels == 4:
                    self.assertTrue((pixels[..., 3] == 2**depth - 1).all(), "opaque")

    def test_ea_reads_one_strip_of_rgba(self):
        files, values = self.exported("ea", "vector2", SMALL)
        pixels, _ = image_readers.read_png(self.only(files, "vector2_uniform_box3x3_exp0101_product.png"))
        self.assertEqual(pixels.shape, (64, 16, 4))
        numpy.testing.assert_array_equal(pixels.reshape(4, 16, 16, 4)[..., :2], codes(values, 8))
        self.assertFalse(pixels[..., 2].any())

    def test_godot_cuts_the_atlas_as_its_import_file_says(self):
        files, values = self.exported("godot", "vector2", SMALL)
        self.assertEqual(set(files), {"vector24.png", "vector24.png.import"})
        settings = dict(re.findall(r"^([a-z/_]+)=(.*)$", files["vector24.png.import"].read_text(), re.MULTILINE))
        self.assertEqual(settings["importer"], '"2d_array_texture"')
        self.assertEqual((settings["mipmaps/generate"], settings["compress/mode"]), ("false", "0"))
        self.assertEqual(settings["compress/channel_pack"], "1")
        columns, rows = int(settings["slices/horizontal"]), int(settings["slices/vertical"])
        pixels, _ = image_readers.read_png(files["vector24.png"])
        height, width = pixels.shape[0] // rows, pixels.shape[1] // columns
        for z in range(4):
            y, x = z // columns * height, z % columns * width
            numpy.testing.assert_array_equal(pixels[y:y + height, x:x + width, :2], codes(values[z], 8))

    def test_bevy_and_three_read_ktx2(self):
        if not (NODE_MODULES / "ktx-parse").is_dir() or shutil.which("node") is None:
            return not_tried("ktx-parse (as three.js has it) reads KTX2", "node or the package is missing (tools/setup --test)")
        script = self.write("read.mjs", READ_KTX2 % NODE_MODULES)
        for consumer, name, samples, format, sizes, channels in [
            ("bevy", "stbn.ktx2", "vector2", 37, (0, 4), 4), ("three", "uniform4.ktx2", "uniform", 9, (4, 0), 1)]:
            files, values = self.exported(consumer, samples, SMALL)
            read = json.loads(subprocess.run(["node", script, self.only(files, name)], check=True, capture_output=True,
                                             text=True).stdout)
            self.assertEqual(read["format"], format)
            self.assertEqual((read["depth"], read["layers"]), sizes)
            texels = numpy.frombuffer(bytes.fromhex(read["data"]), "u1").reshape(4, 16, 16, channels)
            numpy.testing.assert_array_equal(texels[..., :values.shape[-1]], codes(values, 8))

    def test_the_loader_of_three_makes_volumes(self):
        if not (NODE_MODULES / "three").is_dir() or shutil.which("node") is None:
            return not_tried("three.js' KTX2Loader", "node or the package is missing (tools/setup --test)")
        script = self.write("three.mjs", LOAD_KTX2 % NODE_MODULES)
        for samples, depth, channels, format, kind in [("uniform", "8", 1, 1028, 1009), ("vector2", "8", 2, 1030, 1009),
                                                       ("vector2", "16f", 2, 1030, 1016), ("vector2", "32f", 2, 1030, 1015)]:
            files, values = self.exported("three", samples, SMALL, "--depth", depth)
            (path,) = files.values()
            read = json.loads(subprocess.run(["node", script, path], check=True, capture_output=True, text=True).stdout)
            self.assertEqual((read["volume"], read["size"]), (True, [16, 16, 4]))
            self.assertEqual((read["format"], read["type"]), (format, kind))  # RedFormat, RGFormat; bytes, halves, floats
            numbers = numpy.frombuffer(bytes.fromhex(read["data"]), {"8": "u1", "16f": "<f2", "32f": "<f4"}[depth])
            numbers = numbers.reshape(4, 16, 16, channels)
            expected = codes(values, 8) if depth == "8" else values.astype(numbers.dtype)
            if depth == "16f":  # samples stay below 1, where rounding would take them there
                expected = numpy.minimum(expected, numpy.nextafter(numpy.float16(1), numpy.float16(0)))
            numpy.testing.assert_array_equal(numbers, expected)

    def test_remix_reads_bytes_of_64_bit_numbers(self):
        files, values = self.exported("remix", "uniform", LARGE)
        header = self.only(files, "util_blueNoise_128x128x64.h")
        source = self.write("remix.cpp", f'#include <cstdio>\n#include "{header}"\nint main() {{ for (int z = 0; z < 64; ++z) '
                            "for (int i = 0; i < 128 * 128; ++i) "
                            "std::putchar(static_cast<int>(blueNoise_128x128x64[z][i / 8] >> (i % 8 * 8) & 255)); }\n")
        subprocess.run(["g++", "-O0", "-w", source, "-o", self.folder / "remix"], check=True)
        read = subprocess.run([self.folder / "remix"], check=True, capture_output=True).stdout
        self.assertEqual(read, codes(values, 8).tobytes())

    def test_pbrt_looks_a_pixel_up_by_x_first(self):
        files, values = self.exported("pbrt", "uniform", PBRT)
        code = re.sub(r"#include.*", "", self.only(files, "bluenoise.cpp").read_text())
        source = self.write("pbrt.cpp", "#include <cstdint>\n#include <cstdio>\n#define PBRT_CONST const\n" + code +
                            "int main() { for (int t = 0; t < 48; ++t) for (int y = 0; y < 128; ++y) for (int x = 0; x < 128; "
                            "++x) { float v = pbrt::BlueNoiseTextures[t][x][y] / 65535.f; std::fwrite(&v, 4, 1, stdout); } }\n")
        subprocess.run(["g++", "-O0", source, "-o", self.folder / "pbrt"], check=True)
        read = subprocess.run([self.folder / "pbrt"], check=True, capture_output=True).stdout
        self.assertLess(abs(numpy.frombuffer(read, "f4").reshape(48, 128, 128) - values[..., 0]).max(), 1.001 * 2**-16)

    def test_iris_and_skyrim_read_bytes(self):
        files, values = self.exported("iris", "vector2", LARGE)
        self.assertEqual(files["stbnVec2Tex.bin"].read_bytes(), codes(values, 8).tobytes())
        files, values = self.exported("skyrim-cs", "vector2", LARGE)
        with Image.open(self.only(files, "vector264.dds")) as image:
            self.assertEqual((image.mode, image.size), ("LA", (128, 8192)))
            numpy.testing.assert_array_equal(numpy.asarray(image).reshape(values.shape), codes(values, 8))

    def test_mpv_reads_digits_behind_a_head(self):
        for samples, depth, kind, dtype in [("uniform", "8", "r8", "u1"), ("vector2", "16", "rg16", "<u2"),
                                            ("vector2", "32f", "rg32f", "<f4"), ("vector2", "16f", "rg16f", "<f2")]:
            files, values = self.exported("mpv", samples, SMALL, "--depth", depth)
            lines = self.only(files, f"{samples}4.glsl").read_text().splitlines()
            lines = [line for line in lines if not line.startswith("// ")]
            self.assertEqual(lines[:5], [f"//!TEXTURE {samples}4", "//!SIZE 16 16 4", f"//!FORMAT {kind}",
                                         "//!FILTER NEAREST", "//!BORDER REPEAT"])
            read = numpy.frombuffer(bytes.fromhex(lines[5]), dtype).reshape(values.shape)
            if depth.endswith("f"):
                self.assertLess(abs(read - values).max(), {"16f": 2**-11, "32f": 0}[depth] + 1e-9)
            else:
                numpy.testing.assert_array_equal(read, codes(values, int(depth)))

    def test_imagemagick_dithers_with_the_map(self):
        files, values = self.exported("imagemagick", "uniform", SMALL)
        maps = xml.etree.ElementTree.parse(self.only(files, "thresholds.xml")).getroot()
        self.assertEqual([m.get("map") for m in maps], [f"uniform4-{z}" for z in range(4)])
        for z, threshold in enumerate(maps):
            self.assertNotIn("value =", threshold.find("description").text)  # levels are no codes
            levels = threshold.find("levels")
            self.assertEqual([levels.get(a) for a in ("width", "height", "divisor")], ["16", "16", "257"])
            read = numpy.array(levels.text.split(), int).reshape(16, 16)
            numpy.testing.assert_array_equal(read - 1, codes(values[z, ..., 0], 8))
        if not os.path.exists("/usr/bin/convert"):
            return not_tried("ImageMagick dithers with our map", "the program is missing (Debian: imagemagick)")
        for grey in (0.25, 0.6):
            raw = subprocess.run(["/usr/bin/convert", "-size", "16x16", f"xc:gray({100 * grey}%)", "-colorspace", "Gray",
                                  "-ordered-dither", "uniform4-2", "-depth", "8", "gray:-"], check=True,
                                 capture_output=True, env={**os.environ,
                                                           "MAGICK_CONFIGURE_PATH": str(files["thresholds.xml"].parent)}).stdout
            white = numpy.frombuffer(raw, "u1").reshape(16, 16) > 0
            differs = white != (values[2, ..., 0] < grey)
            self.assertLessEqual(differs.sum(), 1, grey)  # the pixel whose level is the grey itself

    def test_ghostscript_screens_with_the_halftone(self):
        files, values = self.exported("ghostscript", "uniform", SMALL)
        self.assertEqual(set(files), {f"uniform4_{z}.ps" for z in range(4)})
        read = re.search(r"sethalftone\n([0-9a-f\s]*)>", files["uniform4_2.ps"].read_text())[1]
        read = numpy.frombuffer(bytes.fromhex(read), ">u2").reshape(16, 16)
        self.assertLess(abs((read - 0.5) / 65535 - values[2, ..., 0]).max(), 1 / 65535)
        if shutil.which("gs") is None:
            return not_tried("Ghostscript screens with our halftone", "the program is missing (Debian: ghostscript)")
        for grey in (0.25, 0.6):
            page = files["uniform4_2.ps"].read_text() + f"{grey} setgray 0 0 16 16 rectfill showpage\n"
            raw = subprocess.run(["gs", "-q", "-dBATCH", "-dNOPAUSE", "-sDEVICE=pbmraw", "-g16x16", "-r72",
                                  f"-sOutputFile={self.folder}/page.pbm", self.write("page.ps", page)], check=True)
            with Image.open(self.folder / "page.pbm") as image:
                white = numpy.asarray(image).astype(bool)
            self.assertLessEqual((white != (values[2, ..., 0] < grey)).sum(), 1, grey)

    def test_gimp_is_given_bytes_above_zero(self):
        files, values = self.exported("gimp", "uniform", SMALL)
        call = re.search(r"\(gimp-image-convert-set-dither-matrix 16 16 256 #\(([\d\s]*)\)\)", files["uniform4_3.scm"].read_text())
        read = numpy.array(call[1].split(), int).reshape(16, 16)
        self.assertGreaterEqual(read.min(), 1)
        self.assertLess(abs((read - 0.5) / 255 - values[3, ..., 0]).max(), 1 / 255)

    def test_help_is_a_table_of_all(self):
        table = self.run_program("export", "--for", "help").stdout
        names = [line.split()[0] for line in table.splitlines()[1:] if line and not line.startswith("The")]
        self.assertEqual(names, "unreal unity godot bevy three rtxtf remix nvidia ea gigi mpv imagemagick ghostscript gimp "
                         "pbrt iris skyrim-cs".split())
        lines = table.splitlines()
        reader = lines[0].rindex("for")  # the last column begins at one place
        self.assertTrue(all(line[reader - 1] == " " and line[reader] != " " for line in lines[:18]), table)

    def test_what_a_consumer_cannot_take_is_refused_with_the_nearest_that_works(self):
        config = self.write("odd.toml", CONFIG % (24, 12, 3, "vector3"))
        self.run_program("generate", config, "-o", "odd.h5")
        for consumer, words in [
            ("unreal", "the nearest that works: 16 x 16 x 4"), ("unreal", "3 channels; accepted: 1, 2"),
            ("bevy", "x, y powers of two; the nearest that works: 32 x 16 x 3"),
            ("rtxtf", "the nearest that works: 128 x 128 x 64"), ("pbrt", "128 x 128 x 48"),
            ("imagemagick", "3 channels; accepted: 1"), ("unrael", 'did you mean "unreal"?'), ("skyrim-cs", "accepted: 2"),
        ]:
            said = self.run_program("export", "odd.h5", "-o", "out/", "--for", consumer, expect=2).stderr
            self.assertIn(words, said)
            self.assertFalse((self.folder / "out").exists())
        said = self.run_program("export", "odd.h5", "-o", "out/", "--for", "three", "--depth", "16", expect=2).stderr
        self.assertIn("accepted: 8, 16f, 32f", said)
        said = self.run_program("export", "odd.h5", "-o", "out/", "--for", "three", "--layout", "array", expect=2).stderr
        self.assertIn("--for three decides that", said)
        self.run_program("export", "odd.h5", "--for", "three", expect=2)


if __name__ == "__main__":
    support.main()
