"""docs/tutorial.ipynb, cell after cell, with what is installed: it runs, and ends with a classifier that has learnt
something."""
import ast
import json
import re
import unittest

from installed_module import InstalledTest
from program import DOCS

try:
    import matplotlib
    import torch  # noqa: F401
except ImportError:
    matplotlib = None

SHOW = """
def show(value):
    print(repr(value))
    if hasattr(value, "_repr_html_"):
        value._repr_html_()
"""


def script_of(cell):
    """A cell's code, its last value shown as a notebook does."""
    tree = ast.parse(cell)
    if isinstance(tree.body[-1], ast.Expr):
        shown = ast.Call(ast.Name("show", ast.Load()), [tree.body[-1].value], [])
        tree.body[-1] = ast.fix_missing_locations(ast.copy_location(ast.Expr(shown), tree.body[-1]))
    return ast.unparse(tree)


@unittest.skipIf(matplotlib is None, "needs Debian's python3-torch and python3-matplotlib")
class Tutorial(InstalledTest):
    def test_runs_from_a_mesh_to_a_classifier(self):
        notebook = json.loads((DOCS / "tutorial.ipynb").read_text())
        cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
        self.assertGreater(len(cells), 12)
        script = self.write("tutorial.py", SHOW + "\n".join(map(script_of, cells)))
        printed = self.python("-W", "ignore::UserWarning", script)
        self.assertLess(float(re.search(r"farthest feature from its mode: ([\d.]+) cents", printed)[1]), 5)
        alphas = re.findall(r"alpha\d: (\S+) found, (\S+) true", printed)
        self.assertEqual(len(alphas), 2)
        for found, true in alphas:
            self.assertAlmostEqual(float(found) / float(true), 1, delta=0.2)
        accuracy, total = re.search(r"([\d.]+) % of (\d+) sounds of unheard objects", printed).groups()
        self.assertGreater(int(total), 50)
        # Three materials: guessing is right in a third.
        self.assertGreater(float(accuracy), 60)


if __name__ == "__main__":
    unittest.main()
