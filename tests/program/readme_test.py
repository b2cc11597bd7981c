"""Every fenced block of README.md works as it stands, and the files and options that it names are there."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from support import BIN, SOURCE, main

README = (SOURCE / "README.md").read_text()
BLOCKS = re.findall(r"^```(\S*)\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
PROSE = re.sub(r"^```.*?^```$", "", README, flags=re.MULTILINE | re.DOTALL)

KINDS = {"sh", "python", "toml", "glsl", "hlsl", "cmake", "cpp"}

# These set up and build everything, and run by themselves.
WHOLE_SCRIPTS = {"tools/quickstart", "tools/test"}

OTHERS_OPTIONS = {"--oversubscribe"}  # Open MPI's

GLSL = """#version 450
layout(binding = 0) uniform sampler2DArray noise_texture;
layout(binding = 1) uniform Frame { uint frame_number; };
layout(location = 0) out vec4 color;
%s
void main() {
  vec4 value = load_noise(noise_texture, uvec2(gl_FragCoord.xy), frame_number, 0u);
  color = vec4(decode_direction(value), value.w);
}
"""

HLSL = """Texture2DArray<float4> noise_texture : register(t0);
cbuffer Frame : register(b1) { uint frame_number; };
%s
"""


def blocks(kind):
    return [text for name, text in BLOCKS if name == kind]


def options(words):
    """The options among the words of a command: -o, --set."""
    return re.findall(r"(?<![\w-])--?[A-Za-z][\w-]*", words)


def names_option(text, option):
    return re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", text) is not None


def command_lines():
    """Every line of shell blocks and every piece of code in the text, without comments."""
    lines = [line for block in blocks("sh") for line in block.replace("\\\n", " ").splitlines()]
    lines += [re.sub(r"\s+", " ", span) for span in re.findall(r"`([^`]+)`", PROSE)]
    return [re.sub(r"(^|\s)#.*", "", line).strip() for line in lines]


def run(*command, folder):
    environment = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}
    return subprocess.run([str(c) for c in command], cwd=folder, env=environment, capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, timeout=300)


class Readme(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """One folder for all blocks. Those of the shell run first, in their order: others read what they make."""
        holder = tempfile.TemporaryDirectory(prefix="noiseloom-test-")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        for name in ("configs", "slurm"):
            shutil.copytree(SOURCE / name, cls.folder / name)
        cls.shell = []
        cls.whole_scripts = []
        for block in blocks("sh"):
            scripts = re.findall(r"^(?:\./)?(tools/[\w-]+)", block, re.MULTILINE)
            if WHOLE_SCRIPTS.intersection(scripts):
                cls.whole_scripts += scripts
            else:
                cls.shell.append((block, run("bash", "-euo", "pipefail", "-c", block, folder=cls.folder)))

    def works(self, *command, block="", folder=None):
        done = run(*command, folder=folder or self.folder)
        self.assertEqual(done.returncode, 0, f"{command}\n{block}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    def test_every_block_is_of_a_kind_that_is_tested(self):
        fences = re.findall(r"^\s*(?:```|~~~)", README, re.MULTILINE)
        self.assertEqual(len(fences), 2 * len(BLOCKS), "a fence that is indented, longer, or not closed")
        self.assertEqual({kind for kind, _ in BLOCKS} - KINDS, set())
        for kind in KINDS:
            self.assertTrue(blocks(kind), f"no block of {kind}")

    def test_shell(self):
        self.assertTrue(self.shell)
        for block, done in self.shell:
            with self.subTest(block=block):
                self.assertEqual(done.returncode, 0, f"{block}\n{done.stdout}\n{done.stderr}")

    def test_scripts_that_run_by_themselves(self):
        self.assertEqual(set(self.whole_scripts) & WHOLE_SCRIPTS, WHOLE_SCRIPTS)
        for script in self.whole_scripts:
            self.assertTrue(os.access(SOURCE / script, os.X_OK), script)

    def test_python(self):
        for block in blocks("python"):
            with self.subTest(block=block):
                self.assertTrue(self.works(sys.executable, "-B", "-c", block, block=block).strip())

    def test_configs(self):
        import numpy

        vectors = numpy.random.default_rng(1).normal(size=(128, 128, 3))
        numpy.save(self.folder / "mine.npy", (vectors / numpy.linalg.norm(vectors, axis=2, keepdims=True)).astype("f4"))
        for number, block in enumerate(blocks("toml")):
            with self.subTest(block=block):
                config = self.folder / f"block{number}.toml"
                config.write_text(block)
                self.works("noiseloom", "plan", config, block=block)

    def test_shaders(self):
        if shutil.which("glslangValidator") is None:
            self.skipTest("glslangValidator is not installed (Debian: glslang-tools)")
        for kind, frame, arguments in (("glsl", GLSL, ()), ("hlsl", HLSL, ("-D", "-e", "main"))):
            for number, block in enumerate(blocks(kind)):
                with self.subTest(block=block):
                    source = self.folder / f"block{number}.{kind}"
                    source.write_text(frame % block)
                    self.works("glslangValidator", *arguments, "-V", "-S", "frag", "-o", source.with_suffix(".spv"), source, block=block)

    def test_program_against_the_installed_libraries(self):
        (lists,), (program,) = blocks("cmake"), blocks("cpp")
        folder = self.folder / "program"
        folder.mkdir()
        (folder / "CMakeLists.txt").write_text(lists)
        (folder / "slices.cpp").write_text(program)
        self.works("cmake", "--install", BIN.parent, "--prefix", folder / "installed")
        self.works("cmake", "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={folder / 'installed'}")
        self.works("cmake", "--build", folder / "build")
        means = re.findall(r"^slice (\d+): mean (\S+)$", self.works(folder / "build/slices", "quick.h5"), re.MULTILINE)

        import h5py

        with h5py.File(self.folder / "quick.h5") as file:
            slices = file["samples"].shape[0]
        self.assertEqual([int(index) for index, _ in means], list(range(slices)))
        for _, mean in means:
            self.assertAlmostEqual(float(mean), 0.5, delta=0.01)

    def test_files_that_are_named(self):
        roots = "configs|include|slurm|src|tests|tools"
        paths = set(re.findall(rf"(?<![\w./-])(?:{roots})/[\w./*-]*\w", README))
        paths |= {link for link in re.findall(r"\]\(([^)#\s]+)", PROSE) if "://" not in link}
        self.assertTrue(paths)
        for path in sorted(paths):
            # NAME is whatever the reader calls a new one: there are such already.
            with self.subTest(path=path):
                self.assertTrue(list(SOURCE.glob(path.replace("NAME", "*"))))
        for name in sorted(set(re.findall(r"`(\w+\.(?:h|cpp))`", PROSE))):
            with self.subTest(name=name):
                self.assertTrue([p for root in roots.split("|") for p in (SOURCE / root).rglob(name)])

    def test_sources_have_keys_that_comments_cite(self):
        body, _, sources = README.partition("## Sources")
        listed = re.findall(r"(?m)^- \[(\w+)\]", sources)
        self.assertEqual(listed, sorted(listed, key=str.lower), "the list is in the order of its keys")
        cited = set(re.findall(r"\[([A-Z][A-Za-z]+\d\d[a-z]?)\]", body))
        for folder in ("include", "src", "tests", "tools"):
            for path in (SOURCE / folder).rglob("*"):
                if path.suffix in (".h", ".cpp"):
                    text = path.read_text()
                    self.assertNotIn("doi:", text, f"{path}: a source belongs into the list, and its key here")
                    cited |= set(re.findall(r"\[([A-Z][A-Za-z]+\d\d[a-z]?)(?:, [^\]]*)?\]", text))
        self.assertEqual(set(listed), cited)

    def test_unit_tests_that_are_named(self):
        named = re.findall(r"bin/(test_\w+) --gtest_filter='([^']+)'", PROSE)
        self.assertTrue(named)
        for program, pattern in named:
            tests = self.works(BIN / program, "--gtest_list_tests", f"--gtest_filter={pattern}")
            self.assertRegex(tests, r"(?m)^  \w", pattern)

    def test_options_that_are_named(self):
        general = self.works("noiseloom", "--help")
        commands = re.findall(r"^  noiseloom ([a-z][-a-z]*) ", general, re.MULTILINE)
        self.assertIn("generate", commands)
        helps = {command: self.works("noiseloom", command, "--help") for command in commands}
        anywhere = "\n".join([general, *helps.values()])
        for line in command_lines():
            with self.subTest(line=line):
                tool = re.match(r"(tools/[\w-]+)\b(.*)", line)
                ours = re.search(r"(?<![\w./:-])noiseloom(?: ([a-z][-a-z]*))?(?= |$)([^|&;]*)", line)
                if tool and options(tool[2]):
                    text, words = (SOURCE / tool[1]).read_text(), tool[2]
                elif ours and ours[1]:
                    self.assertIn(ours[1], helps)
                    text, words = helps[ours[1]], ours[2]
                elif ours:
                    text, words = general, ours[2]
                elif line.startswith("--"):
                    text, words = anywhere, line
                else:
                    continue
                for option in options(words):
                    if option not in OTHERS_OPTIONS:
                        self.assertTrue(names_option(text, option), option)


if __name__ == "__main__":
    main()
