"""The version stands in CMakeLists.txt; everything else says the same, and which commit was built."""
import json
import pathlib
import re
import shutil
import subprocess
import unittest

from program import CARILLON, FolderTest, run, run_json

ROOT = pathlib.Path(__file__).resolve().parents[2]
VERSION = re.search(r"project\(carillon VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]


class Version(FolderTest):
    def test_the_citation_has_it(self):
        self.assertIn(f"version: {VERSION}", (ROOT / "CITATION.cff").read_text().splitlines())

    def test_the_changelog_has_it(self):
        self.assertRegex((ROOT / "CHANGELOG.md").read_text(),
                         rf"(?m)^## \[{re.escape(VERSION)}\] - \d{{4}}-\d\d-\d\d$")

    def test_program_and_dataset_say_what_was_built(self):
        first = run("--version").stdout.splitlines()[0]
        self.assertRegex(first, rf"^carillon {re.escape(VERSION)}(\+\S+)?$")
        written = (pathlib.Path(CARILLON).parent / "revision.cpp").read_text()
        self.assertIn(f'"{first.removeprefix("carillon ")}"', written)
        config = self.write("one.yaml", "objects: [{shape: bar, count: 1}]\nmaterials: [steel]\n"
                            "modes: {max_modes: 4}\nstrikes: {per_object: 1}\naudio: {seconds: 0.1 s}\n")
        run_json("build", config, "-o", self.folder / "one")
        dataset = json.loads((self.folder / "one" / "dataset.json").read_text())
        self.assertEqual("carillon " + dataset["versions"]["carillon"], first)


@unittest.skipUnless(shutil.which("git"), "git is not installed")
class Revision(FolderTest):
    """What a build would write of a source in a folder of its own."""

    def setUp(self):
        self.source = self.folder / self.id().rsplit(".", 1)[1]
        self.output = self.source.with_suffix(".cpp")
        self.template = self.source / "core" / "revision.cpp.in"
        self.template.parent.mkdir(parents=True)
        shutil.copy(ROOT / "core" / "revision.cpp.in", self.template)

    def git(self, *words):
        named = ("-c", "user.name=nobody", "-c", "user.email=nobody@localhost")
        return subprocess.run(["git", *named, *words], cwd=self.source, check=True,
                              capture_output=True, text=True).stdout.strip()

    def commit(self, subject):
        """Its nine digits."""
        self.git("add", ".")
        self.git("commit", "--allow-empty", "-m", subject)
        return self.git("rev-parse", "--short=9", "HEAD")

    def revision(self):
        subprocess.run(["cmake", "-D", f"SOURCE={self.source}", "-D", "VERSION=1.2.3", "-D",
                        f"OUTPUT={self.output}", "-P", ROOT / "cmake" / "CarillonRevision.cmake"],
                       check=True)
        return re.search(r'revision\(\) { return "(.*)"', self.output.read_text())[1]

    def test_commits_are_counted_from_the_tag_of_the_version(self):
        self.git("init", "-q")
        commit = self.commit("before any tag")
        self.assertEqual(self.revision(), f"1.2.3+1.g{commit}")
        self.git("tag", "v1.2.2")
        self.assertEqual(self.revision(), f"1.2.3+1.g{commit}")
        self.git("tag", "v1.2.3")
        self.assertEqual(self.revision(), "1.2.3")
        self.commit("one")
        commit = self.commit("two")
        self.assertEqual(self.revision(), f"1.2.3+2.g{commit}")
        with self.template.open("a") as file:
            file.write("// changed\n")
        self.assertEqual(self.revision(), f"1.2.3+2.g{commit}.dirty")

    def test_a_tarball_is_a_release_whatever_git_lies_around_it(self):
        self.git("-C", "..", "init", "-q")
        self.git("-C", "..", "commit", "--allow-empty", "-m", "another project's")
        self.assertEqual(self.revision(), "1.2.3")

    def test_nothing_is_compiled_anew_where_nothing_changed(self):
        self.revision()
        before = self.output.stat().st_mtime_ns
        self.revision()
        self.assertEqual(self.output.stat().st_mtime_ns, before)


if __name__ == "__main__":
    unittest.main()
