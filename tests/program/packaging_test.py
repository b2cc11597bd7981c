"""The recipes of tools/packaging, as far as they can be tried without their tools: names that they share with the build."""

import re
import shutil
import subprocess
import sys
import types
import unittest

from support import BIN, SOURCE, main

PACKAGING = SOURCE / "tools" / "packaging"


def options_of_the_build():
    return set(re.findall(r"option\((NOISELOOM_\w+)", (SOURCE / "CMakeLists.txt").read_text()))


class Spec(dict):
    def __missing__(self, name):
        return types.SimpleNamespace(prefix=f"/{name}")


class Packaging(unittest.TestCase):
    def test_spack_recipe(self):
        said = {"depends_on": [], "variant": [], "version": []}
        class CMakePackage:
            run_tests = False
            spec = Spec()
            def define(self, name, value): return f"-D{name}={value}"
            def define_from_variant(self, name, variant): return f"-D{name}={variant}"
        stand_in = types.ModuleType("spack.package")
        build_system = types.ModuleType("spack_repo.builtin.build_systems.cmake")
        for name in ("depends_on", "variant", "version", "license", "generator"):
            setattr(build_system if name == "generator" else stand_in, name, lambda *words, name=name, **further: said.setdefault(name, []).append(words[0]))
        # Since Spack 1.0 the build systems are no longer part of spack.package, but of the repository of its packages.
        build_system.CMakePackage = CMakePackage
        stand_in.__all__ = ["depends_on", "variant", "version", "license"]
        sys.modules.update({"spack": types.ModuleType("spack"), "spack.package": stand_in})
        for depth in range(1, 4):
            name = ".".join(build_system.__name__.split(".")[:depth])
            sys.modules[name] = types.ModuleType(name)
        sys.modules[build_system.__name__] = build_system
        names = {}
        # A repository lies where its namespace says, below a folder of this name.
        repository = PACKAGING / "spack" / "spack_repo" / "noiseloom"
        self.assertEqual((repository / "repo.yaml").read_text(), "repo:\n  namespace: noiseloom\n  api: v2.0\n")
        exec(compile((repository / "packages/noiseloom/package.py").read_text(), "package.py", "exec"), names)
        arguments = names["Noiseloom"]().cmake_args()
        self.assertEqual([name for name in re.findall(r"-D(NOISELOOM_\w+)", " ".join(arguments)) if name not in options_of_the_build()], [])
        for package in ("mpi", "hdf5@1.10:", "highway", "fmt", "xxhash", "fftw", "openimageio", "cli11", "random123", "tomlplusplus",
                        "assimp", "embree@3:"):
            self.assertIn(package, said["depends_on"])

    def test_module_file(self):
        """Tcl, with what a module system gives it; the folders are those that CMake installs into."""
        text = (PACKAGING / "modulefile").read_text()
        self.assertTrue(text.startswith("#%Module"))
        for folder in re.findall(r"^prepend-path \w+ \$prefix/?(\S*)$", text, re.M):
            self.assertIn(folder, ("", "bin", "share/man"))
        version = re.search(r"noiseloom VERSION ([\d.]+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)
        self.assertIn(f"noiseloom/{version}", text)
        if shutil.which("tclsh"):
            given = "foreach word {module-whatis conflict prepend-path} { proc $word args { puts $args } }\n"
            done = subprocess.run(["tclsh"], input=given + text, capture_output=True, text=True)
            self.assertEqual(done.stderr, "")
            self.assertIn("PATH /opt/noiseloom/bin", done.stdout)

    def test_container_builds_with_the_packages_of_the_setup(self):
        text = (PACKAGING / "Containerfile").read_text()
        built_with = re.search(r"AS build.*?install -y --no-install-recommends(.*?)&&", text, re.S).group(1).replace("\\", " ").split()
        setup = (SOURCE / "tools" / "setup").read_text().split()
        self.assertEqual([package for package in built_with if package not in setup], [])
        self.assertEqual([name for name in re.findall(r"-D(NOISELOOM_\w+)", text) if name not in options_of_the_build()], [])

    @unittest.skipUnless(shutil.which("dpkg-query") and shutil.which("readelf"), "not a Debian")
    def test_container_has_what_the_programs_link(self):
        """Of this build, each library that they name, be it in a package of the list or in one that those need."""
        text = (PACKAGING / "Containerfile").read_text()
        listed = text.split("AS build")[1].split("install -y --no-install-recommends")[2].split("&&")[0].replace("\\", " ").split()
        there = {"libc6", "libgcc-s1", "libstdc++6", "libopenmpi3"}  # of the base, and of openmpi-bin
        files = [path for path in BIN.iterdir() if path.name in ("noiseloom", "noiseloom-study") or path.suffix == ".so" and path.name.startswith("noiseloom")]
        self.assertGreaterEqual(len(files), 3)
        needed = set()
        for file in files:
            needed.update(re.findall(r"NEEDED.*\[(.*?)\]", subprocess.run(["readelf", "-d", file], capture_output=True, text=True, check=True).stdout))
        self.assertTrue(any(library.startswith("libhdf5") for library in needed))
        found = subprocess.run(["dpkg-query", "-S", *(f"*/{library}" for library in needed)], capture_output=True, text=True).stdout
        packages = {}  # of a library; none of one that is not Debian's
        for line in found.splitlines():
            package, path = line.split(": ", 1)
            packages.setdefault(path.split("/")[-1], set()).add(package.split(":")[0])
        missing = {library: names for library, names in packages.items() if not names & (there | set(listed))}
        self.assertEqual(missing, {})


if __name__ == "__main__":
    main()
