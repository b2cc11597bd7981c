"""Includes hold to src/layers.txt, and the programs to what they may be linked with."""

import pathlib
import re
import subprocess
import unittest

from support import BIN, SOURCE, main

# The headers of the libraries that the table names.
HEADERS = {
    "random123": ("Random123/",),
    "fmt": ("fmt/",),
    "threads": ("thread", "mutex", "condition_variable", "barrier", "latch", "future"),
    "hdf5": ("hdf5.h", "H5"),
    "xxhash": ("xxhash.h",),
    "mpi": ("mpi.h",),
    "highway": ("hwy/",),
    "toml": ("toml++/",),
    "oiio": ("OpenImageIO/",),
    "fftw": ("fftw3.h",),
    "assimp": ("assimp/",),
    "embree": ("embree3/", "embree4/"),
}
EVERYWHERE = {"fmt", "threads"}


def read_table():
    """folder -> (what it may use, its libraries)"""
    table = {}
    for line in (SOURCE / "src/layers.txt").read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            name, uses, libraries, sentence = (column.strip() for column in line.split("|"))
            assert sentence, f"{name} has no sentence"
            table[name] = (uses.split(), libraries.split())
    return table


def whole(name):
    """The folder that a part is of, or the folder itself."""
    return name.split("/")[0]


def closure(table, name):
    """Folders, parts and single headers that a folder may include: what its row says and what those may use."""
    seen = {name}
    waiting = list(table[name][0])
    if whole(name) != name:  # public headers stand in the whole folder, whose other parts are not meant
        seen.add(whole(name))
        waiting += [use for use in table[whole(name)][0] if whole(use) != whole(name)]
    while waiting:
        use = waiting.pop()
        if use not in seen:
            seen.add(use)
            waiting += table.get(use, ([], []))[0]
    return seen


def includes(path):
    return re.findall(r'^\s*#\s*include\s*["<]([^">]+)[">]', path.read_text(), re.MULTILINE)


def sources(*roots):
    for root in roots:
        for path in sorted((SOURCE / root).rglob("*")):
            if path.suffix in (".h", ".cpp"):
                yield path


class Layers(unittest.TestCase):
    def setUp(self):
        self.table = read_table()

    def folder(self, path):
        for root in ("include/noiseloom", "src", "tests"):
            if (SOURCE / root) in path.parents:
                parts = path.relative_to(SOURCE / root).parts
                part = "/".join(parts[:2])
                return part if root == "src" and part in self.table else parts[0]
        return None

    def target(self, include):
        """The folder of ours that an include names, or the part of one, and the header within it; or None."""
        parts = pathlib.PurePosixPath(include).with_suffix("").parts
        parts = parts[1:] if parts[0] == "noiseloom" else parts
        if "/".join(parts[:2]) in self.table:
            return "/".join(parts[:2]), "/".join(parts)
        return (parts[0], "/".join(parts)) if parts and parts[0] in self.table else None

    def check(self, path, allowed):
        checked = 0
        for include in includes(path):
            target = self.target(include)
            if target:
                checked += 1
                self.assertTrue(allowed & set(target), f"{path} includes {include}")
        return checked

    def test_rows_name_rows_above_them(self):
        known = set()
        for name, (uses, libraries) in self.table.items():
            for use in uses:
                self.assertTrue({use, whole(use)} & known, f"{name} uses {use}")
            self.assertLessEqual(set(libraries), set(HEADERS), name)
            known.add(name)

    def test_every_folder_has_a_row(self):
        for root in ("include/noiseloom", "src"):
            for path in (SOURCE / root).iterdir():
                if path.is_dir():
                    self.assertIn(path.name, self.table, f"{path} has no row in src/layers.txt")
        for name in {whole(name) for name in self.table if "/" in name}:
            for path in (SOURCE / "src" / name).iterdir():
                if path.is_dir() and path.name != "library":  # of a module
                    self.assertIn(f"{name}/{path.name}", self.table, f"{path} has no row in src/layers.txt")

    def test_includes_hold_to_the_table(self):
        checked = 0
        for path in sources("include/noiseloom", "src"):
            checked += self.check(path, closure(self.table, self.folder(path)))
        self.assertGreater(checked, 300)

    def test_tests_use_what_their_folder_may(self):
        checked = 0
        for path in sources("tests"):
            if self.folder(path) in self.table:
                checked += self.check(path, closure(self.table, self.folder(path)))
        self.assertGreater(checked, 100)

    def test_tools_reach_through_public_headers(self):
        for path in sources("tools"):
            for include in includes(path):
                parts = pathlib.PurePosixPath(include).parts
                self.assertNotIn(parts[0], self.table, f"{path} includes {include}")

    def test_private_headers_stay_in_their_folder(self):
        for path in sources("include/noiseloom", "src"):
            for include in includes(path):
                first = pathlib.PurePosixPath(include).parts[0]
                if first in self.table:
                    self.assertNotIn("include", path.relative_to(SOURCE).parts, f"{path} includes {include}")
                    self.assertEqual(first, whole(self.folder(path)), f"{path} includes {include}")

    def test_libraries_stay_in_their_folders(self):
        for path in sources("include/noiseloom", "src"):
            allowed = set(self.table[whole(self.folder(path))][1]) | EVERYWHERE
            for include in includes(path):
                for library, headers in HEADERS.items():
                    if library not in allowed:
                        self.assertFalse(include.startswith(headers), f"{path} includes {include}")

    def test_folders_of_images_know_no_ranks(self):
        for folder in ("image", "measure", "render", "report"):
            self.assertNotIn("dist", closure(self.table, folder))


class Programs(unittest.TestCase):
    def libraries(self, program):
        return subprocess.run(["ldd", BIN / program], check=True, capture_output=True, text=True).stdout

    def test_the_generator_links_no_image_library(self):
        listed = self.libraries("noiseloom")
        self.assertIn("libmpi", listed)
        self.assertNotIn("OpenImageIO", listed)
        self.assertNotIn("libfftw3", listed)

    def test_image_library_is_loaded_when_it_is_needed(self):
        # 270 shared libraries, a quarter of a second: no command waits for them that opens no image.
        self.assertNotIn("OpenImageIO", self.libraries("noiseloom-study"))
        self.assertIn("OpenImageIO", self.libraries("noiseloom-images.so"))

    def test_meshes_are_loaded_when_a_scene_has_one(self):
        for program in ("noiseloom-study", "noiseloom-images.so"):
            self.assertNotIn("libembree", self.libraries(program))
            self.assertNotIn("libassimp", self.libraries(program))


if __name__ == "__main__":
    main()
