"""What `cmake --install` puts under a prefix, and that it works there."""
import gzip
import pathlib
import subprocess
import unittest

from program import CARILLON, FolderTest, run


class Installed(FolderTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        # Left by a version that kept them beside the program.
        (cls.folder / "bin").mkdir()
        for name in ("carillon-mesh", "carillon-learn"):
            old = cls.folder / "bin" / name
            old.write_text("#!/bin/sh\necho an older version\nexit 1\n")
            old.chmod(0o755)
        subprocess.run(["cmake", "--install", pathlib.Path(CARILLON).parent, "--prefix", cls.folder],
                       check=True, capture_output=True)

    def run_there(self, *words):
        return subprocess.run([self.folder / "bin" / "carillon", *words], cwd=self.folder,
                              capture_output=True, text=True)

    def test_it_is_the_program_that_was_built(self):
        self.assertEqual(self.run_there("--version").stdout, run("--version").stdout)

    def test_it_meshes(self):
        done = self.run_there("modes", "bar", "-m", "steel", "--max-modes", "3", "--cache", "")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    @unittest.skipUnless(pathlib.Path(CARILLON).with_name("carillon-learn").is_file(),
                         "built without classifiers")
    def test_it_learns_where_that_was_built(self):
        (self.folder / "none.yaml").write_text("objects: [{shape: bar}]\nmaterials: [steel]\n")
        done = self.run_there("train", "none.yaml")
        self.assertNotIn("older version", done.stdout)
        self.assertEqual(done.returncode, 2, done.stdout)

    def test_manual_completion_configurations_and_scripts_come_along(self):
        share = self.folder / "share"
        manual = gzip.decompress((share / "man" / "man1" / "carillon.1.gz").read_bytes())
        self.assertEqual(manual.decode(), run("manual").stdout)
        for path in ("bash-completion/completions/carillon", "carillon/configs/smoke.yaml", "carillon/materials.yaml",
                     "carillon/walls.yaml", "carillon/scripts/plot_accuracy", "fish/vendor_completions.d/carillon.fish"):
            self.assertTrue((share / path).is_file(), path)


if __name__ == "__main__":
    unittest.main()
