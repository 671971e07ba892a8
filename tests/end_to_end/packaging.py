"""The recipes for Spack and conda name what scripts/setup installs."""
import ast
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGING = ROOT / "scripts" / "packaging"

# Debian's package: Spack's and conda-forge's; "" where it needs none there.
NAMES = {
    "cmake": ("cmake", "cmake"), "ninja-build": ("ninja", "ninja"), "pkg-config": ("pkgconfig", "pkg-config"),
    "clang": ("cxx", "compiler"), "g++": ("cxx", "compiler"), "ccache": ("", ""),
    "libeigen3-dev": ("eigen", "eigen"), "libopenmpi-dev": ("mpi", "openmpi"), "openmpi-bin": ("mpi", "openmpi"),
    "libpetsc-real-dev": ("petsc", "petsc"), "libslepc-real-dev": ("slepc", "slepc"),
    "libmetis-dev": ("metis", "metis"), "libmumps-dev": ("mumps", "mumps-mpi"),
    "libsuitesparse-dev": ("suite-sparse", "suitesparse"), "libopenblas0-serial": ("blas", "libblas"),
    "libcgal-dev": ("cgal", "cgal-cpp"), "libgmsh-dev": ("gmsh", "gmsh"), "libassimp-dev": ("assimp", "assimp"),
    "libpugixml-dev": ("pugixml", "pugixml"), "libfftw3-dev": ("fftw", "fftw"), "libhwy-dev": ("highway", "libhwy"),
    "libsndfile1-dev": ("libsndfile", "libsndfile"), "libsoxr-dev": ("soxr", "soxr"),
    "libpng-dev": ("libpng", "libpng"), "libturbojpeg0-dev": ("libjpeg-turbo", "libjpeg-turbo"),
    "libhdf5-openmpi-dev": ("hdf5", "hdf5"), "zlib1g-dev": ("zlib-api", "zlib"),
    "libarchive-dev": ("libarchive", "libarchive"), "libosmesa6-dev": ("osmesa", ""),
    "libegl-dev": ("egl", "libegl-devel"), "libopengl-dev": ("egl", "libopengl-devel"), "libegl1": ("egl", ""),
    "libgl1-mesa-dri": ("", ""), "libbullet-dev": ("bullet", "bullet-cpp"), "libnlopt-dev": ("nlopt", "nlopt"),
    "libyaml-cpp-dev": ("yaml-cpp", "yaml-cpp"), "libmuparser-dev": ("muparser", "muparser"),
    "nlohmann-json3-dev": ("nlohmann-json", "nlohmann_json"), "libcli11-dev": ("cli11", "cli11"),
    "libspdlog-dev": ("spdlog", "spdlog"), "libfmt-dev": ("fmt", "fmt"),
    "librandom123-dev": ("random123", "random123"), "libssl-dev": ("openssl", "openssl"),
    "portaudio19-dev": ("", "portaudio"), "librtmidi-dev": ("", ""), "liblo-dev": ("", ""),
    "libcpp-httplib-dev": ("cpp-httplib", "cpp-httplib"),
    "libtorch-dev": ("py-torch", "libtorch"), "liblinear-dev": ("liblinear", "liblinear"), "nodejs": ("node-js", ""), "npm": ("npm", ""),
    "python3": ("python", "python"), "python3-dev": ("python", "python"), "pybind11-dev": ("py-pybind11", "pybind11"),
    "python3-h5py": ("py-h5py", "h5py"), "python3-numpy": ("py-numpy", "numpy"),
    "python3-matplotlib": ("py-matplotlib", "matplotlib-base"),
}
# What Debian's libcgal-dev brings along, conda's other parts of these, and the C compiler.
OTHERS = {"boost", "lapack", "c"}, {"libboost-headers", "liblapack", "libgl-devel", "stdlib"}
PARTS = "program", "learn", "report", "python"


def debian_packages():
    """Of the parts that a build may be of; where there is a choice, all of it."""
    text = (ROOT / "scripts" / "setup").read_text().replace("\\\n", " ")
    lists = re.findall(rf"(?m)^(?:.*\|\| )?part (?:{'|'.join(PARTS)}) (.*)$", text)
    return {name for words in lists for name in re.split(r"[ '|]+", words) if name}


def spack_dependencies():
    recipe = PACKAGING / "spack_repo" / "carillon" / "packages" / "carillon" / "package.py"
    calls = [node for node in ast.walk(ast.parse(recipe.read_text())) if isinstance(node, ast.Call)]
    named = {"depends_on", "generator"}
    specs = [call.args[0].value for call in calls if isinstance(call.func, ast.Name) and call.func.id in named]
    return {re.match(r"[a-z0-9-]+", spec)[0] for spec in specs}


def conda_dependencies():
    text = (PACKAGING / "conda" / "meta.yaml").read_text()
    rows = text[text.index("requirements:"):text.index("test:")]
    return {re.match(r"[\w-]+", row)[0] for row in re.findall(r"(?m)^ +- (?:\{\{ )?(.*)", rows)}


class Recipes(unittest.TestCase):
    def test_names_are_known_of_every_package(self):
        self.assertEqual(debian_packages(), set(NAMES))

    def test_recipes_have_each_and_no_other(self):
        for k, found in enumerate((spack_dependencies(), conda_dependencies())):
            wanted = {names[k] for names in NAMES.values()} - {""} | OTHERS[k]
            self.assertEqual(found, wanted)

    def test_variants_are_options_of_the_build(self):
        recipe = (PACKAGING / "spack_repo/carillon/packages/carillon/package.py").read_text()
        cmake = "".join(path.read_text() for path in (ROOT / "cmake").glob("*.cmake"))
        options = set(re.findall(r'"(CARILLON_\w+)"', recipe))
        self.assertGreater(len(options), 5)
        script = (PACKAGING / "conda" / "build.sh").read_text()
        for name in options | set(re.findall(r"-D(CARILLON_\w+)", script)):
            self.assertIn(name, cmake + (ROOT / "python" / "CMakeLists.txt").read_text(), name)


if __name__ == "__main__":
    unittest.main()
