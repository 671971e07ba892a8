"""Runs the program as a user does."""
import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import tempfile
import unittest

CARILLON = os.environ["CARILLON"]
# How many times longer than in a release things may take: sanitizers are slow.
TIMEOUT_FACTOR = float(os.environ.get("CARILLON_TIMEOUT_FACTOR", "1"))
CONFIGS = pathlib.Path(__file__).resolve().parents[2] / "configs"
DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"


def run(*arguments, ranks=None, cwd=None, timeout=400, environment=None):
    """The finished process of `carillon arguments`, under mpirun when ranks are given; with variables
    beside those of this process."""
    command = [CARILLON, *map(str, arguments)]
    if ranks:
        command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *command]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd,
                          env={**os.environ, **(environment or {})},
                          timeout=timeout * TIMEOUT_FACTOR)


# Sanitizers take memory of their own, and know no limits of it.
of_memory = unittest.skipIf(TIMEOUT_FACTOR > 1, "sanitizers take memory of their own")

# A program that was built with -DCARILLON_RENDER=OFF.
NO_PICTURES = os.environ.get("CARILLON_PICTURES") == "none"
pictures = unittest.skipIf(NO_PICTURES, "the program was built without pictures")


def draws_figures():
    """Whether a Python that the program tries for figures has matplotlib."""
    named = os.environ.get("CARILLON_PYTHON")
    pythons = [named] if named else [p for p in (shutil.which("python3"), "/usr/bin/python3") if p]
    return any(subprocess.run([p, "-c", "import matplotlib"], capture_output=True,
                              check=False).returncode == 0 for p in pythons)


# Minutes for what the others show on less; ctest -L slow runs them.
LONG = bool(os.environ.get("CARILLON_LONG"))
long = unittest.skipUnless(LONG, "CARILLON_LONG is not set")


def run_json(*arguments, **options):
    result = run(*arguments, "--json", **options)
    if result.returncode != 0:
        raise AssertionError(f"exit {result.returncode}: {result.stderr}")
    return json.loads(result.stdout)


def docs_block(page, language, word):
    """The one fenced block of a page of docs/ that has a word."""
    blocks = re.findall(rf"^```{language}\n(.*?)^```", (DOCS / page).read_text(), re.DOTALL | re.MULTILINE)
    found = [block for block in blocks if word in block]
    assert len(found) == 1, (page, word, len(found))
    return found[0]


def processor_seconds():
    """Of the programs that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class FolderTest(unittest.TestCase):
    """A test with a folder of its own and a cache in it."""

    maxDiff = None

    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls._folder.name)
        os.environ["CARILLON_CACHE"] = str(cls.folder / "cache")

    @classmethod
    def tearDownClass(cls):
        cls._folder.cleanup()

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path
