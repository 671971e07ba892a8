"""Builds the extension with CMake, for pip. CARILLON_BUILD names a folder in which it is built already."""
import os
import pathlib
import re
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent


class CMakeBuild(build_ext):
    def build_extension(self, extension):
        built_before = os.environ.get("CARILLON_BUILD")
        build = pathlib.Path(built_before or self.build_temp).resolve()
        package = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve().parent

        def cmake(*words):
            subprocess.run(["cmake", *map(str, words)], check=True)
        if not built_before:
            cmake("-S", ROOT, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCARILLON_JOIN_SOURCES=ON",
                  "-DCARILLON_PYTHON=ON", f"-DPython_EXECUTABLE={sys.executable}")
            cmake("--build", build)
        package.mkdir(parents=True, exist_ok=True)
        [built] = (build / "python" / "carillon").glob("_carillon*.so")
        self.copy_file(str(built), str(package / built.name))
        for component in ("carillon", "carillon-learn"):  # what the module starts, where it looks for them
            cmake("--install", build, "--prefix", package, "--component", component)


# Beside `build`, which is CMake's.
FOLDER = ROOT / "build-wheel"
FOLDER.mkdir(exist_ok=True)
version = re.search(r"project\(carillon VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
setup(version=version, ext_modules=[Extension("carillon._carillon", [])], cmdclass={"build_ext": CMakeBuild},
      options={"build": {"build_base": str(FOLDER)}, "egg_info": {"egg_base": str(FOLDER)}})
