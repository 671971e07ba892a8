# ruff: noqa: F403, F405, I001 (as packages of Spack are written)
from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Soxr(CMakePackage):
    """Sample-rate conversion of sounds."""

    homepage = "https://sourceforge.net/projects/soxr/"
    url = "https://downloads.sourceforge.net/project/soxr/soxr-0.1.3-Source.tar.xz"
    license("LGPL-2.1-or-later")
    version("0.1.3", sha256="b111c15fdc8c029989330ff559184198c161100a59312f5dc19ddeb9b5a15889")

    depends_on("c", type="build")

    def cmake_args(self):
        # The oldest CMake that it names is older than those that CMake 4 knows.
        return [self.define("BUILD_TESTS", False), self.define("WITH_OPENMP", False),
                self.define("CMAKE_POLICY_VERSION_MINIMUM", "3.5")]
