"""The recipes of tools/packaging, as far as they can be tried without their tools: names that they share with the build."""

import re
import types
import sys
import unittest

from support import SOURCE, main

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
        for package in ("mpi", "hdf5@1.10:", "highway", "fmt", "xxhash", "fftw", "openimageio", "cli11", "random123", "tomlplusplus"):
            self.assertIn(package, said["depends_on"])

    def test_container_builds_with_the_packages_of_the_setup(self):
        text = (PACKAGING / "Containerfile").read_text()
        built_with = re.search(r"AS build.*?install -y --no-install-recommends(.*?)&&", text, re.S).group(1).replace("\\", " ").split()
        setup = (SOURCE / "tools" / "setup").read_text().split()
        self.assertEqual([package for package in built_with if package not in setup], [])
        self.assertEqual([name for name in re.findall(r"-D(NOISELOOM_\w+)", text) if name not in options_of_the_build()], [])


if __name__ == "__main__":
    main()
