"""What `cmake --install` installed, run where nothing else of Carillon can be found."""
import os
import pathlib
import subprocess
import sys

from program import CARILLON, FolderTest

BUILD = pathlib.Path(CARILLON).parent


class InstalledTest(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.prefix = cls.folder / "installed"
        for component in ("carillon", "carillon-learn", "python3-carillon"):
            subprocess.run(["cmake", "--install", BUILD, "--prefix", cls.prefix, "--component", component],
                           capture_output=True, check=True)
        [package] = (path.parent for path in cls.prefix.rglob("carillon/__init__.py"))
        cls.modules = package.parent

    def python(self, *words, modules=None):
        """What a program prints that has nothing but the installed module; no carillon is in its PATH."""
        environment = {name: value for name, value in os.environ.items() if name != "CARILLON"}
        done = subprocess.run([sys.executable, *map(str, words)], cwd=self.folder, capture_output=True, text=True,
                              env={**environment, "PYTHONPATH": str(modules or self.modules), "MPLBACKEND": "Agg"})
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout
