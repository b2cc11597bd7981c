"""A folder is a layer: includes point downward, mpi.h is seen by dist alone, HDF5 by io and images by study."""

import pathlib
import re
import unittest

from support import SOURCE, main

LAYERS = ["core", "problem", "dist", "optimize", "io", "study"]
LIBRARIES = {
    "mpi.h": {"dist"},
    "hdf5.h": {"io"},
    "H5": {"io"},
    "OpenImageIO/": {"study"},
    "fftw3.h": {"study"},
    "hwy/": {"problem", "optimize"},
    "toml++/": {"io"},
    "xxhash.h": {"io"},
    "Random123/": {"core"},
}


class Layers(unittest.TestCase):
    def files(self):
        for root in ("include/noiseloom", "src"):
            for path in sorted((SOURCE / root).rglob("*")):
                if path.suffix in (".h", ".cpp"):
                    yield path, path.relative_to(SOURCE / root).parts[0]

    def includes(self, path):
        return re.findall(r'^\s*#\s*include\s*["<]([^">]+)[">]', path.read_text(), re.MULTILINE)

    def test_includes_point_downward(self):
        checked = 0
        for path, layer in self.files():
            for include in self.includes(path):
                parts = pathlib.PurePosixPath(include).parts
                target = parts[1] if parts[0] == "noiseloom" else parts[0]
                if target in LAYERS:
                    checked += 1
                    self.assertLessEqual(LAYERS.index(target), LAYERS.index(layer), f"{path} includes {include}")
        self.assertGreater(checked, 50)

    def test_libraries_stay_in_their_layer(self):
        for path, layer in self.files():
            for include in self.includes(path):
                for library, homes in LIBRARIES.items():
                    if include.startswith(library):
                        self.assertIn(layer, homes, f"{path} includes {include}")

    def test_public_headers_do_not_show_private_ones(self):
        for path, layer in self.files():
            if "include" not in path.relative_to(SOURCE).parts:
                continue
            for include in self.includes(path):
                self.assertNotIn(pathlib.PurePosixPath(include).parts[0], LAYERS, f"{path} includes {include}")


if __name__ == "__main__":
    main()
