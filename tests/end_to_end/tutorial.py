"""docs/tutorial.ipynb, cell by cell: it runs, and ends with a classifier that has learnt something."""
import ast
import contextlib
import io
import json
import os
import pathlib
import re
import sys
import unittest

from program import CARILLON, DOCS, FolderTest

sys.path.insert(0, str(pathlib.Path(CARILLON).parent / "python"))
try:
    import matplotlib
    import torch  # noqa: F401
except ImportError:
    matplotlib = None


def run_cell(code, names):
    """What a cell prints, and the value of its last expression."""
    tree = ast.parse(code)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "tutorial.ipynb", "exec"), names)
        value = eval(compile(ast.Expression(last.value), "tutorial.ipynb", "eval"), names) if last else None
    return printed.getvalue(), value


@unittest.skipIf(matplotlib is None, "needs Debian's python3-torch and python3-matplotlib")
class Tutorial(FolderTest):
    def test_runs_from_a_mesh_to_a_classifier(self):
        matplotlib.use("Agg")
        notebook = json.loads((DOCS / "tutorial.ipynb").read_text())
        cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
        self.assertGreater(len(cells), 12)
        names, printed = {}, ""
        os.chdir(self.folder)
        for code in cells:
            with self.subTest(cell=code):
                printed += run_cell(code, names)[0]
        self.assertLess(float(re.search(r"farthest feature from its mode: ([\d.]+) cents", printed)[1]), 5)
        for found, true in re.findall(r"alpha\d: (\S+) found, (\S+) true", printed):
            self.assertAlmostEqual(float(found) / float(true), 1, delta=0.2)
        accuracy, total = re.search(r"([\d.]+) % of (\d+) sounds of unheard objects", printed).groups()
        self.assertGreater(int(total), 50)
        # Three materials: guessing is right in a third.
        self.assertGreater(float(accuracy), 60)


if __name__ == "__main__":
    unittest.main()
