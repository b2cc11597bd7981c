"""KTX2, DDS, half floats, atlases, headers and shaders, read by programs and compilers that are not ours."""

import json
import pathlib
import re
import shutil
import struct
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

WIDTH, HEIGHT, SLICES = 13, 11, 3  # primes: no wrong order of rows, columns or slices fits

CONFIG = """
[texture]
size = { x = 13, y = 11, t = 3 }
samples = "%s"
[filter]
groups = [ { axes = "xy", kernel = "box", size = 3 } ]
[optimizer]
stop = { iterations = 1 }
method = "anneal"
"""

NODE_MODULES = support.SOURCE / ".build/npm/node_modules"

# Prints a line for each KTX2 file: header and data as ktx-parse reads them.
READ_KTX2 = """
import { read } from '%s/ktx-parse/dist/index.mjs';
import { readFileSync } from 'fs';
for (const path of process.argv.slice(2)) {
const file = read(new Uint8Array(readFileSync(path)));
const descriptor = file.dataFormatDescriptor[0];
console.log(JSON.stringify({
  format: file.vkFormat, typeSize: file.typeSize, width: file.pixelWidth, height: file.pixelHeight,
  depth: file.pixelDepth, layers: file.layerCount, faces: file.faceCount, levels: file.levels.length,
  supercompression: file.supercompressionScheme, transfer: descriptor.transferFunction, model: descriptor.colorModel,
  samples: descriptor.samples.map(s => [s.bitOffset, s.bitLength, s.channelType]), plane: descriptor.bytesPlane[0],
  keys: file.keyValue, data: Buffer.from(file.levels[0].levelData).toString('hex') }));
}
"""


def codes(unit, bits):
    """floor(2^bits u), clamped, in double."""
    return numpy.clip(numpy.floor(unit.astype(float) * 2**bits), 0, 2**bits - 1).astype({8: "u1", 16: "<u2", 32: "<u4"}[bits])


def not_tried(what, why):
    print(f"not tried: {what}: {why}")


class ContainersTest(support.ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.runs = {}

    def generate(self, samples):
        config = self.write(f"{samples}.toml", CONFIG % samples)
        if samples not in self.runs:
            self.run_program("generate", config, "-o", f"{samples}.h5")
            self.runs[samples] = (self.folder / f"{samples}.h5").read_bytes()
        (self.folder / f"{samples}.h5").write_bytes(self.runs[samples])
        with h5py.File(self.folder / f"{samples}.h5") as file:
            self.samples = file["/samples"][...]
        return f"{samples}.h5"

    def export(self, run_file, output, *arguments):
        self.run_program("export", run_file, "-o", output, *arguments)
        return self.folder / output

    def texels(self, depth, channels):
        """What a container holds: the samples with zeros, an opaque alpha, or a scalar in three channels."""
        values = self.samples
        found = values.shape[-1]
        if channels >= 3 and found == 1:
            values = numpy.repeat(values, 3, axis=-1)
        while values.shape[-1] < channels:
            fill = 1 if values.shape[-1] == 3 else 0
            values = numpy.concatenate([values, numpy.full(values.shape[:-1] + (1,), fill, values.dtype)], axis=-1)
        if depth in ("8", "16"):
            opaque = 2 ** int(depth) - 1
            stored = codes(values, int(depth))
            return numpy.where(values == 1, opaque, stored).astype(stored.dtype)
        return values.astype({"16f": "<f2", "32f": "<f4"}[depth])

    def same_halves(self, data, expected):
        """Bytes, where halves that numpy rounds to 1 may be the one below it."""
        if expected.dtype != numpy.dtype("<f2"):
            return data == expected.tobytes()
        read = numpy.frombuffer(data, "<f2").reshape(expected.shape)
        below = (expected == 1) & (read == numpy.nextafter(numpy.float16(1), numpy.float16(0)))
        return bool(((read == expected) | below).all())

    # Depth, channels asked for and found, VkFormat, DXGI format.
    FORMATS = [
        ("uniform", "8", "R", 9, 61), ("vector2", "8", "RG", 16, 49), ("vector3", "8", "RGB", 23, None),
        ("vector4", "8", "RGBA", 37, 28), ("uniform", "16", "R", 70, 56), ("vector2", "16", "RG", 77, 35),
        ("vector3", "16", "RGBA", 91, 11), ("uniform", "16f", "R", 76, 54), ("vector2", "16f", "RG", 83, 34),
        ("vector3", "16f", "RGBA", 97, 10), ("uniform", "32f", "R", 100, 41), ("vector2", "32f", "RG", 103, 16),
        ("vector3", "32f", "RGB", 106, 6), ("vector4", "32f", "RGBA", 109, 2), ("uniform", "8", "RGBA", 37, 28), ("vector2", "8", "RGBA", 37, 28),
    ]

    def test_ktx2_is_read_by_ktx_parse(self):
        if not (NODE_MODULES / "ktx-parse").is_dir() or shutil.which("node") is None:
            return not_tried("ktx-parse reads our KTX2", "node or the package is missing (tools/setup --test)")
        script = self.write("read.mjs", READ_KTX2 % NODE_MODULES)
        cases = []
        for samples, depth, channels, vulkan, _ in self.FORMATS:
            run_file = self.generate(samples)
            for layout in ("array", "volume"):
                name = f"{samples}-{depth}-{channels}-{layout}.ktx2"
                path = self.export(run_file, name, "--depth", depth, "--channels", channels, "--layout", layout)
                cases.append((path, depth, channels, layout, vulkan, self.samples))
        path = self.export(self.generate("vector2"), "one/", "--format", "ktx2", "--layout", "slices")
        paths = [case[0] for case in cases] + [path / "vector2_1.ktx2"]
        lines = subprocess.run(["node", script, *paths], check=True, capture_output=True, text=True).stdout.splitlines()
        one = json.loads(lines.pop())
        self.assertEqual((one["depth"], one["layers"]), (0, 0))
        self.assertEqual(bytes.fromhex(one["data"]), self.texels("8", 2)[1].tobytes())
        for (path, depth, channels, layout, vulkan, self.samples), line in zip(cases, lines, strict=True):
            read, name = json.loads(line), path.name
            number = {"8": 1, "16": 2, "16f": 2, "32f": 4}[depth]
            self.assertEqual(read["format"], vulkan, name)
            self.assertEqual(read["typeSize"], number, name)
            self.assertEqual((read["width"], read["height"]), (WIDTH, HEIGHT))
            self.assertEqual((read["depth"], read["layers"]), (3, 0) if layout == "volume" else (0, 3))
            self.assertEqual((read["faces"], read["levels"], read["supercompression"]), (1, 1, 0))
            self.assertEqual((read["transfer"], read["model"]), (1, 1), "linear, RGB")
            self.assertEqual(read["plane"], number * len(channels))
            kinds = {"R": 0, "G": 1, "B": 2, "A": 15}
            self.assertEqual([(offset, length) for offset, length, _ in read["samples"]],
                             [(8 * number * c, 8 * number - 1) for c in range(len(channels))])
            self.assertEqual([kind & 15 for _, _, kind in read["samples"]], [kinds[c] for c in channels])
            self.assertEqual(read["keys"]["KTXorientation"], "rdi" if layout == "volume" else "rd")
            self.assertTrue(self.same_halves(bytes.fromhex(read["data"]), self.texels(depth, len(channels))), name)

    def test_file_knows_ktx2_and_dds(self):
        if shutil.which("file") is None:
            return not_tried("file says what our KTX2 and DDS are", "the program is missing (tools/setup --test)")
        run_file = self.generate("vector2")
        say = lambda path: subprocess.run(["file", "-b", path], check=True, capture_output=True, text=True).stdout
        self.assertRegex(say(self.export(run_file, "a.ktx2")), r"KTX2.*13 x 11")
        self.assertRegex(say(self.export(run_file, "a.dds")), r"DirectDraw Surface \(DDS\).*13 x 11|11 x 13")

    def test_dds_is_read_by_nvddsinfo(self):
        if shutil.which("nvddsinfo") is None:
            return not_tried("nvddsinfo reads our DDS", "the program is missing (Debian: libnvtt-bin)")
        for samples, depth, channels, _, dxgi in self.FORMATS:
            if dxgi is None:
                continue
            run_file = self.generate(samples)
            for layout in ("array", "volume"):
                name = f"{samples}-{depth}-{channels}-{layout}.dds"
                path = self.export(run_file, name, "--depth", depth, "--channels", channels, "--layout", layout)
                said = subprocess.run(["nvddsinfo", path], check=True, capture_output=True, text=True).stdout
                self.assertRegex(said, r"Height: 11\s")
                self.assertRegex(said, r"Width: 13\s")
                self.assertRegex(said, rf"DX10 Format: .*\(?{dxgi}\)?|Format: {dxgi}\s")
                self.assertRegex(said, rf"[Aa]rray [Ss]ize: {1 if layout == 'volume' else 3}\s")
                if layout == "volume":
                    self.assertRegex(said, r"Depth: 3\s")
                data = path.read_bytes()[148:]
                self.assertTrue(self.same_halves(data, self.texels(depth, len(channels))), name)

    def test_dds_strips_are_read_by_programs_of_images(self):
        scalars = self.export(self.generate("uniform"), "l8.dds", "--layout", "strip")
        expected = {"l8": self.texels("8", 1).reshape(33, 13)}
        self.export(self.generate("vector4"), "rgba8.dds", "--layout", "strip")
        expected["rgba8"] = self.texels("8", 4).reshape(33, 13, 4)
        vectors = self.export(self.generate("vector2"), "l8a8.dds", "--layout", "strip")
        with Image.open(vectors) as image:  # luminance and alpha
            self.assertEqual((image.mode, image.size), ("LA", (13, 33)))
            numpy.testing.assert_array_equal(numpy.asarray(image), self.texels("8", 2).reshape(33, 13, 2))
        with Image.open(self.folder / "rgba8.dds") as image:
            numpy.testing.assert_array_equal(numpy.asarray(image.convert("RGBA")), expected["rgba8"])
        if not pathlib.Path("/usr/bin/convert").exists():
            return not_tried("ImageMagick reads our DDS strips", "the program is missing (Debian: imagemagick)")
        for name, pixels in expected.items():
            # Whatever the masks say, it takes four channels for blue, green, red, alpha.
            form = "gray" if name == "l8" else "bgra"
            raw = subprocess.run(["/usr/bin/convert", f"dds:{self.folder / name}.dds", "-depth", "8", f"{form}:-"],
                                 check=True, capture_output=True).stdout
            numpy.testing.assert_array_equal(numpy.frombuffer(raw, "u1").reshape(pixels.shape), pixels)
        self.assertEqual(len(scalars.read_bytes()), 128 + 13 * 33)

    def test_what_was_exported_is_scored_as_the_run_file_is(self):
        run_file = self.generate("vector3")
        def score(path, *arguments):
            done = self.run_program("score", path, "--json", *arguments)
            return json.loads(done.stdout)["relative_error"]
        own = score(run_file)
        for name, arguments in [("a.ktx2", ["--depth", "32f"]), ("b.ktx2", ["--depth", "16", "--layout", "volume"]),
                                ("c.dds", ["--depth", "16"]), ("d.dds", ["--depth", "16f", "--layout", "volume"]),
                                ("e.png", ["--layout", "atlas:2x2", "--depth", "16"]), ("f.exr", ["--layout", "row"])]:
            self.export(run_file, name, *arguments)
            reading = ["--layout", "atlas:2x2"] if name == "e.png" else []
            self.assertAlmostEqual(score(name, "--config", "vector3.toml", *reading), own, delta=2e-3, msg=name)
        self.export(run_file, "slices/", "--format", "dds", "--layout", "slices", "--depth", "32f")
        self.assertAlmostEqual(score("slices", "--config", "vector3.toml"), own, delta=1e-6)

    def test_rows_and_atlases_count_to_the_right_and_then_down(self):
        run_file = self.generate("vector3")
        pixels, _ = image_readers.read_png(self.export(run_file, "row.png", "--layout", "row"))
        self.assertEqual(pixels.shape, (11, 39, 3))
        for s in range(3):
            numpy.testing.assert_array_equal(pixels[:, 13 * s:13 * (s + 1)], codes(self.samples[s], 8))
        pixels, _ = image_readers.read_png(self.export(run_file, "atlas.png", "--layout", "atlas:2x2"))
        self.assertEqual(pixels.shape, (22, 26, 3))
        numpy.testing.assert_array_equal(pixels[:11, 13:], codes(self.samples[1], 8))
        numpy.testing.assert_array_equal(pixels[11:, :13], codes(self.samples[2], 8))
        self.assertFalse(pixels[11:, 13:].any(), "no slice, no numbers")
        for layout in ("atlas:2x1", "atlas:2x3", "atlas:0x3", "atlas:2", "row:3"):
            self.run_program("export", run_file, "-o", "bad.png", "--layout", layout, expect=2)

    def test_half_exr_holds_the_nearest_halves(self):
        run_file = self.generate("sphere")
        path = self.export(run_file, "half.exr", "--depth", "16f", "--layout", "strip")
        data = path.read_bytes()
        self.assertIn(b"channels\0chlist\0", data)
        at = data.index(b"chlist\0") + 11
        self.assertEqual(struct.unpack("<i", data[at + 2:at + 6])[0], 1, "half")
        rows = struct.unpack("<Q", data[-33 * (8 + 13 * 6) - 33 * 8:][:8])[0]
        pixels = b"".join(data[rows + y * (8 + 78) + 8:rows + (y + 1) * (8 + 78)] for y in range(33))
        read = numpy.frombuffer(pixels, "<f2").reshape(33, 3, 13)[:, ::-1].transpose(0, 2, 1)
        numpy.testing.assert_array_equal(read.reshape(self.samples.shape), self.samples.astype("<f2"))

    def test_headers_are_read_by_c_and_cpp_compilers(self):
        compilers = [(c, standard, language) for c, standard, language in [
            ("gcc", "c11", "c"), ("clang", "c11", "c"), ("g++", "c++11", "c++"), ("clang++", "c++11", "c++")]]
        program = """
#include <stdio.h>
#include "%s"
#include "%s"
int main(void) {
  fwrite(%s, sizeof(%s[0][0]) * %s_height * %s_slices, 1, stdout);
  return ((size_t)%s & 15) != 0;
}
"""
        for samples, depth, kind in [("uniform", "8", "u1"), ("vector2", "16", "<u2"), ("vector3", "32", "<u4"),
                                     ("gauss", "32f", "<f4"), ("vector5", "32f", "<f4")]:
            run_file = self.generate(samples)
            other = "uniform" if samples != "uniform" else "vector2"
            name = f"noise-{samples}"
            header = self.export(run_file, f"{name}.h", "--depth", depth)
            self.export(self.generate(other), "other.h", "--overwrite")
            self.generate(samples)
            array = name.replace("-", "_")
            source = self.write("read.c", program % (header.name, "other.h", *[array] * 5))
            expected = (self.samples.astype("<f4") if depth == "32f" else codes(self.samples, int(depth))).tobytes()
            for compiler, standard, language in compilers:
                if shutil.which(compiler) is None:
                    not_tried(f"{compiler} reads our headers", "the compiler is missing")
                    continue
                subprocess.run([compiler, "-x", language, f"-std={standard}", "-Wall", "-Wextra", "-Werror",
                                "-Wno-unused-const-variable", "-pedantic", source, "-o", self.folder / "read"],
                               check=True, cwd=self.folder)
                read = subprocess.run([self.folder / "read"], check=True, capture_output=True).stdout
                self.assertEqual(read, expected, f"{samples} {compiler}")

    SHIM = """
#include <cmath>
#include <cstdio>
typedef unsigned int uint;
struct uint2 { uint x, y; uint2(uint a, uint b) : x(a), y(b) {} };
#define OP(op) inline uint2 operator op(uint2 a, uint2 b) { return {a.x op b.x, a.y op b.y}; } \\
  inline uint2 operator op(uint2 a, uint b) { return {a.x op b, a.y op b}; }
OP(*) OP(+) OP(%%)
inline uint2 operator>>(uint2 a, int b) { return {a.x >> b, a.y >> b}; }
inline uint2& operator+=(uint2& a, uint2 b) { a = a + b; return a; }
struct float3 { float x, y, z; float3(float a, float b, float c) : x(a), y(b), z(c) {} };
inline float3 operator*(float3 a, float b) { return {a.x * b, a.y * b, a.z * b}; }
inline float3 operator+(float3 a, float b) { return {a.x + b, a.y + b, a.z + b}; }
inline float3 normalize(float3 a) { return a * (1 / std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z)); }
%s
int main() {
  for (uint frame = 0; frame < 17; ++frame)
    for (uint index = 0; index < 2; ++index)
      for (uint y = 0; y < 11; ++y)
        for (uint x = 0; x < 13; ++x) {
          float3 v = noise_load(uint2(x, y), frame, index);
          std::fwrite(&v, sizeof v, 1, stdout);
        }
}
"""

    def test_shader_code_reads_what_frames_are_exported_as(self):
        run_file = self.generate("sphere")
        hlsl = self.export(run_file, "noise.hlsl", "--depth", "8").read_text()
        source = self.write("shader.cpp", self.SHIM % hlsl)
        subprocess.run(["g++", "-std=c++11", "-Wno-narrowing", source, "-o", self.folder / "shader"], check=True)
        read = subprocess.run([self.folder / "shader"], check=True, capture_output=True).stdout
        read = numpy.frombuffer(read, "<f4").reshape(34, 11, 13, 3)
        frames = numpy.load(self.export(run_file, "frames.npy", "--frames", 17, "--values", 2)).reshape(34, 11, 13, 3)
        decoded = (codes(0.5 + 0.5 * frames.astype(float), 8) + 0.5) / 128 - 1
        decoded /= numpy.linalg.norm(decoded, axis=-1, keepdims=True)
        self.assertLess(abs(read - decoded).max(), 2e-6)

    def test_shader_code_compiles(self):
        glslang = shutil.which("glslangValidator")
        if glslang is None:
            not_tried("glslangValidator compiles our HLSL and GLSL", "the program is missing (Debian: glslang-tools)")
        reflect = NODE_MODULES / "wgsl_reflect"
        if not reflect.is_dir() or shutil.which("node") is None:
            not_tried("wgsl_reflect parses our WGSL", "node or the package is missing (tools/setup --test)")
        script = self.write("parse.mjs", f"import {{ WgslReflect }} from '{reflect}/wgsl_reflect.module.js';\n"
                            "import { readFileSync } from 'fs';\n"
                            "for (const path of process.argv.slice(2)) {\n"
                            "  const reflect = new WgslReflect(readFileSync(path, 'utf8'));\n"
                            "  console.log(reflect.functions.map(f => f.name).join(' '));\n}\n")
        shaders = []
        hlsl_main = {"array": "noise_load(uint2(p.xy), 1u, 0u)", "function": "noise_load(tex, uint2(p.xy), 1u, 0u)"}
        for samples in ("uniform", "vector2", "sphere", "vector4"):
            run_file = self.generate(samples)
            size = self.samples.shape[-1]
            fill = "".join(", 0.0" for _ in range(4 - size))
            for depth in ("16", "32f") if samples == "sphere" else ("8",):
                for layout in ("array", "function"):
                    for language in ("hlsl", "glsl", "wgsl"):
                        path = self.export(run_file, f"{samples}{depth}{layout}/noise.{language}", "--depth", depth,
                                           "--layout", layout)
                        code = path.read_text()
                        if language == "wgsl":
                            shaders.append(path)
                        if language == "wgsl" or glslang is None:
                            continue
                        if language == "hlsl":
                            main = (f"Texture2DArray<float4> tex;\nfloat4 main(float4 p : SV_Position) : SV_Target "
                                    f"{{ return float4({hlsl_main[layout]}{fill}); }}\n")
                            options = ["-D", "-V", "-S", "frag", "-e", "main", "-o", self.folder / "out.spv"]
                        else:
                            call = ("noise_load(uvec2(gl_FragCoord.xy), 1u, 0u)" if layout == "array" else
                                    "noise_load(tex, uvec2(gl_FragCoord.xy), 1u, 0u)")
                            code = "#version 330\n" + code
                            main = (f"uniform sampler2DArray tex;\nout vec4 colour;\n"
                                    f"void main() {{ colour = vec4({call}{fill}); }}\n")
                            options = ["-S", "frag"]
                        shader = self.write(f"main.{language}", code + main)
                        done = subprocess.run([glslang, *options, shader], capture_output=True, text=True)
                        self.assertEqual(done.returncode, 0, f"{path}\n{done.stdout}")
        if reflect.is_dir():
            said = subprocess.run(["node", script, *shaders], check=True, capture_output=True, text=True).stdout
            self.assertEqual([names.split()[-1] for names in said.splitlines()], ["noise_load"] * len(shaders))

    def test_wgsl_refuses_more_numbers_than_the_language_has_room_for(self):
        config = self.write("large.toml", (CONFIG % "uniform").replace("x = 13, y = 11, t = 3", "x = 64, y = 64, t = 3"))
        self.run_program("generate", config, "-o", "large.h5")
        said = self.run_program("export", "large.h5", "-o", "large.wgsl", expect=2).stderr
        self.assertIn("room for 2047", said)
        self.assertIn("--layout function", said)
        self.assertFalse((self.folder / "large.wgsl").exists())
        self.run_program("export", "large.h5", "-o", "large.wgsl", "--layout", "function")

    def test_channels_that_a_container_has_not_are_refused(self):
        run_file = self.generate("vector3")
        for name, channels in [("a.ktx2", "RG"), ("a.dds", "RGB"), ("a.png", "RG"), ("a.ktx2", "XY")]:
            said = self.run_program("export", run_file, "-o", name, "--layout", "strip" if name == "a.png" else "array",
                                    "--channels", channels, expect=2).stderr
            self.assertIn("accepted", said)


if __name__ == "__main__":
    support.main()
