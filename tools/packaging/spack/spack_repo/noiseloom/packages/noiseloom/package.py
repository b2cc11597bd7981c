"""noiseloom for Spack 1.0 and later, from a checkout:

    spack repo add tools/packaging/spack/spack_repo/noiseloom
    spack dev-build noiseloom@main
"""

from spack_repo.builtin.build_systems.cmake import CMakePackage, generator

from spack.package import *


class Noiseloom(CMakePackage):
    """Sampling-noise textures for renderers: FAST and spatiotemporal blue noise, on one machine or a cluster."""

    version("main")

    license("BSD-3-Clause")

    variant("images", default=True, description="Images, spectra and reports too, not the making of textures alone")
    variant("meshes", default=False, when="+images", description="Meshes in the scenes of rendering tests")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("cli11", type="build")
    depends_on("random123", type="build")
    depends_on("tomlplusplus", type="build")
    depends_on("fmt")
    depends_on("hdf5@1.10:")
    depends_on("highway")
    depends_on("mpi")
    depends_on("xxhash")
    depends_on("fftw", when="+images")
    depends_on("openimageio", when="+images")
    depends_on("assimp", when="+meshes")
    depends_on("embree@3:", when="+meshes")

    generator("ninja")

    def cmake_args(self):
        return [
            self.define_from_variant("NOISELOOM_IMAGES", "images"),
            self.define("NOISELOOM_BUILD_TESTS", self.run_tests),
            self.define("HDF5_ROOT", self.spec["hdf5"].prefix),
        ]
