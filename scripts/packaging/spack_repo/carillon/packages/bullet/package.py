# ruff: noqa: F403, F405, I001 (as packages of Spack are written)
from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Bullet(CMakePackage):
    """Collision detection and motion of rigid bodies, in double precision."""

    homepage = "https://pybullet.org"
    url = "https://github.com/bulletphysics/bullet3/archive/refs/tags/3.25.tar.gz"
    license("Zlib")
    version("3.25", sha256="c45afb6399e3f68036ddb641c6bf6f552bf332d5ab6be62f7e6c54eda05ceb77")

    depends_on("c", type="build")
    depends_on("cxx", type="build")

    def cmake_args(self):
        off = ("BUILD_BULLET2_DEMOS", "BUILD_CPU_DEMOS", "BUILD_OPENGL3_DEMOS", "BUILD_UNIT_TESTS", "BUILD_EXTRAS",
               "BUILD_PYBULLET")
        # The oldest CMake that it names is older than those that CMake 4 knows.
        return [*(self.define(name, False) for name in off), self.define("USE_DOUBLE_PRECISION", True),
                self.define("BUILD_SHARED_LIBS", True), self.define("CMAKE_POLICY_VERSION_MINIMUM", "3.5")]
