# ruff: noqa: F403, F405, I001, RUF012 (as packages of Spack are written)
import os

from spack_repo.builtin.build_systems.makefile import MakefilePackage

from spack.package import *


class Liblinear(MakefilePackage):
    """Linear classification."""

    homepage = "https://www.csie.ntu.edu.tw/~cjlin/liblinear/"
    git = "https://github.com/cjlin1/liblinear.git"
    license("BSD-3-Clause")
    version("2.47", tag="v247")
    version("2.30", tag="v230")

    depends_on("c", type="build")
    depends_on("cxx", type="build")

    build_targets = ["lib"]

    def install(self, spec, prefix):
        mkdirp(prefix.include, prefix.lib)
        install("linear.h", prefix.include)
        for library in find(".", "liblinear.so.*", recursive=False):
            install(library, prefix.lib)
            os.symlink(os.path.basename(library), os.path.join(prefix.lib, "liblinear.so"))
