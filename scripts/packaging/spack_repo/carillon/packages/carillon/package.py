# ruff: noqa: F403, F405, I001 (as packages of Spack are written)
import pathlib

from spack_repo.builtin.build_systems.cmake import CMakePackage, generator

from spack.package import *


class Carillon(CMakePackage):
    """Datasets of struck objects (modes, sounds, voxels and pictures) from shapes and materials."""

    # The checkout that this recipe lies in.
    git = pathlib.Path(__file__).resolve().parents[6].as_uri()
    license("GPL-3.0-or-later")
    version("main", branch="main")

    variant("learn", default=True, description="Classifiers: train, evaluate, identify (libtorch, liblinear)")
    variant("render", default=True, description="Pictures of objects and scenes (OpenGL)")
    variant("offscreen", default="osmesa", values=("osmesa", "egl"), description="What pictures are drawn with",
            when="+render")
    variant("python", default=False, description="Python module")
    variant("report", default=False, description="Page of carillon report (npm and the network while it is built)")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    generator("ninja")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")

    # Finite elements.
    depends_on("mpi")
    depends_on("eigen@3.4:3")
    depends_on("petsc@3.18:3.22 +mpi+metis+mumps+suite-sparse~complex+double~int64")
    depends_on("slepc@3.18:3.22")
    depends_on("metis@5:")
    depends_on("mumps+mpi+double")
    depends_on("suite-sparse")
    depends_on("blas")
    depends_on("lapack")
    # One thread a rank.
    requires("^[virtuals=blas,lapack] openblas threads=none", when="^[virtuals=blas] openblas")

    # Geometry. Of Boost headers alone.
    depends_on("cgal@5.5:6")
    depends_on("boost@1.74:")
    depends_on("gmsh@4.8:4 +shared~fltk")
    depends_on("assimp@5.2:5")
    depends_on("pugixml")

    # Sound, pictures and files.
    depends_on("fftw@3 precision=double")
    depends_on("highway@1:")
    depends_on("libsndfile")
    depends_on("soxr")
    depends_on("libpng")
    depends_on("libjpeg-turbo")
    depends_on("hdf5@1.10.7:")
    depends_on("zlib-api")
    depends_on("libarchive")
    with when("+render"):
        depends_on("osmesa", when="offscreen=osmesa")
        # Mesa's: on most systems an external package.
        depends_on("egl", when="offscreen=egl")

    # Motion; searches without derivatives.
    depends_on("bullet")
    depends_on("nlopt")

    # Configuration, expressions, random numbers, checksums, command line.
    depends_on("yaml-cpp@0.7:")
    depends_on("muparser@2.3:")
    depends_on("nlohmann-json@3.11:")
    depends_on("cli11@2.1:")
    depends_on("spdlog@1.10:+fmt_external")
    depends_on("fmt@9:")
    depends_on("random123")
    depends_on("openssl@3:")

    depends_on("py-torch@1.13:", when="+learn")
    depends_on("liblinear", when="+learn")
    depends_on("cpp-httplib", when="+report")
    depends_on("node-js", type="build", when="+report")
    depends_on("npm", type="build", when="+report")
    # The program's own scripts, which draw its findings.
    depends_on("python@3.10:", type=("build", "link", "run"))
    depends_on("py-numpy", type="run")
    depends_on("py-h5py", type="run")
    depends_on("py-matplotlib", type="run")
    with when("+python"):
        extends("python")
        depends_on("py-pybind11@2.9:", type=("build", "link"))

    def cmake_args(self):
        arguments = [self.define_from_variant("CARILLON_LEARN", "learn"),
                     self.define_from_variant("CARILLON_RENDER", "render"),
                     self.define_from_variant("CARILLON_PYTHON", "python"),
                     self.define_from_variant("CARILLON_REPORT", "report"),
                     self.define_from_variant("CARILLON_SERVE", "report"),
                     self.define("CARILLON_JOIN_SOURCES", True), self.define("PETSC_DIR", self.spec["petsc"].prefix),
                     self.define("SLEPC_DIR", self.spec["slepc"].prefix), self.define("PETSC_ARCH", "")]
        if self.spec.satisfies("+render"):
            arguments.append(self.define_from_variant("CARILLON_OFFSCREEN", "offscreen"))
        if self.spec.satisfies("+python"):
            arguments += [self.define("Python_EXECUTABLE", python.path), self.define("CARILLON_PYTHON_DIR", python_platlib)]
        return arguments
