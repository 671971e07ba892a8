"""CMake against a site's own PETSc and SLEPc: Debian's files under prefixes that pkg-config does not
know, with Debian's own hidden."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def pkg_config(*arguments):
    return subprocess.run(["pkg-config", *arguments], capture_output=True, text=True,
                          check=True).stdout.strip()


def link_all(source, target):
    """Links to every file of a folder and of those below, as `cp -rs` makes them."""
    target.mkdir(parents=True)
    subprocess.run(["cp", "-rs", f"{source}/.", target], check=True)


class SiteLibraries(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = pathlib.Path(self._folder.name)
        for name in ("PETSc", "SLEPc"):
            self.own_prefix(name)
        self.environment = {key: value for key, value in os.environ.items()
                            if key not in ("PETSC_DIR", "PETSC_ARCH", "SLEPC_DIR")}
        self.hide(re.compile("petsc|slepc", re.IGNORECASE))

    def own_prefix(self, name):
        """PETSc's or SLEPc's files in a folder of their own, with a .pc file that says so."""
        prefix = self.folder / "site" / name.lower()
        link_all(pkg_config("--variable=includedir", name), prefix / "include")
        (prefix / "lib/pkgconfig").mkdir(parents=True)
        libraries = pathlib.Path(pkg_config("--variable=libdir", name))
        for library in libraries.glob("lib*.so"):
            (prefix / "lib" / library.name).symlink_to(library.resolve())
        text = (libraries / f"pkgconfig/{name}.pc").read_text()
        text = re.sub("^prefix=.*", f"prefix={prefix}", text, flags=re.MULTILINE)
        (prefix / f"lib/pkgconfig/{name}.pc").write_text(text)

    def hide(self, pattern):
        """Everything that pkg-config knows but what matches."""
        known = self.folder / "pkgconfig"
        known.mkdir(exist_ok=True)
        for folder in pkg_config("--variable=pc_path", "pkg-config").split(":"):
            for file in pathlib.Path(folder).glob("*.pc"):
                link = known / file.name
                if not pattern.search(file.name) and not link.exists():
                    link.symlink_to(file.resolve())
                elif pattern.search(file.name):
                    link.unlink(missing_ok=True)
        self.environment["PKG_CONFIG_LIBDIR"] = str(known)

    def configure(self, *arguments, **environment):
        build = tempfile.mkdtemp(dir=self.folder)
        result = subprocess.run(
            ["cmake", "-G", "Ninja", "-S", SOURCE, "-B", build, "-DCARILLON_TESTS=OFF", *arguments],
            capture_output=True, text=True, env={**self.environment, **environment}, timeout=200)
        result.cache = (pathlib.Path(build) / "CMakeCache.txt").read_text()
        result.message = " ".join(result.stderr.split())
        return result

    def test_takes_the_libraries_that_the_variables_name(self):
        site = self.folder / "site"
        by_environment = self.configure(PETSC_DIR=str(site), PETSC_ARCH="petsc",
                                        SLEPC_DIR=str(site / "slepc"))
        by_options = self.configure(f"-DPETSC_DIR={site}/petsc", f"-DSLEPC_DIR={site}/slepc")
        for result in (by_environment, by_options):
            self.assertEqual(result.returncode, 0, result.stderr)
            found = re.findall("^pkgcfg_lib_SLEPC_.*:FILEPATH=(.*)$", result.cache, re.MULTILINE)
            self.assertEqual({os.path.dirname(path) for path in found},
                             {f"{site}/petsc/lib", f"{site}/slepc/lib"})

    def test_names_the_variables_to_set(self):
        nothing = self.configure()
        self.assertIn("Set PETSC_DIR, SLEPC_DIR and", nothing.message)
        nowhere = self.configure("-DPETSC_DIR=/nowhere")
        self.assertIn("PETSC_DIR=/nowhere holds no lib/pkgconfig/*.pc", nowhere.message)
        for result in (nothing, nowhere):
            self.assertNotEqual(result.returncode, 0)

    def test_a_missing_library_is_named_with_what_to_set(self):
        self.hide(re.compile("sndfile|petsc|slepc", re.IGNORECASE))
        site = self.folder / "site"
        own = [f"-DPETSC_DIR={site}/petsc", f"-DSLEPC_DIR={site}/slepc"]
        sndfile = self.configure(*own)
        self.assertIn("sndfile is missing", sndfile.message)
        self.assertIn("CMAKE_PREFIX_PATH", sndfile.message)


if __name__ == "__main__":
    unittest.main()
