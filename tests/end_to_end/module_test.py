"""What tests of the Python module share: the module as it was built, some objects."""
import pathlib
import sys

from program import CARILLON, FolderTest

MODULE = pathlib.Path(CARILLON).parent / "python"
sys.path.insert(0, str(MODULE))
import carillon as ca  # noqa: E402

WEDGE = ([[0, 0, 0], [0.1, 0, 0], [0, 0.06, 0], [0, 0, 0.04]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
BAND = {"max_frequency": "16 kHz", "max_modes": 20}
OPTIONS = ["--max-frequency", "16 kHz", "--max-modes", "20"]

BARS = {"name": "bars", "seed": 3, "materials": ["steel", "glass"],
        "objects": [{"shape": "bar", "count": 2}],
        "modes": {"max_modes": 4, "max_frequency": "6 kHz"}, "strikes": {"per_object": 3},
        "audio": {"seconds": 0.05}}


class ModuleTest(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        ca.objects.cache = ""

    def column(self, document, name):
        return [mode[name] for mode in document["modes"]]
