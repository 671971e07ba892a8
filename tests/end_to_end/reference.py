"""Completion in shells, the manual page, and links of the documentation."""
import pathlib
import re
import shutil
import subprocess
import unittest

from program import run

ROOT = pathlib.Path(__file__).resolve().parents[2]


def commands():
    """Names of all commands, from `--help`."""
    text = run("--help").stdout.split("Subcommands:")[1].split("Exit codes:")[0]
    return re.findall(r"^  ([a-z][a-z-]+) ", text, re.M)


def options(command):
    lines = re.findall(r"(?m)^  (-\S+)", run(command, "--help").stdout)
    return {name for line in lines for name in line.split(",")}


class Completion(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.script = run("completion", "bash").stdout

    def complete(self, *words):
        ask = (self.script + f"\nCOMP_WORDS=(carillon {' '.join(words)})\n"
               f"COMP_CWORD={len(words)}\n_carillon\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"")
        answer = subprocess.run(["bash", "-c", ask], capture_output=True, text=True, cwd=ROOT)
        self.assertEqual(answer.stderr, "")
        return set(answer.stdout.split())

    def test_every_command_and_option(self):
        names = commands()
        self.assertGreater(len(names), 20)
        self.assertEqual(self.complete("''"), set(names))
        for name in names:
            told = self.complete(name, "-")
            self.assertLessEqual(options(name) - {"-h"}, told | {"-h"}, name)
            self.assertIn("--json", told)

    def test_words_that_an_option_takes(self):
        self.assertEqual(self.complete("export", "set", "--format", "''"), {"wav", "webdataset"})
        self.assertEqual(self.complete("strike", "bowl", "-m", "gla"), {"glass"})
        self.assertEqual(self.complete("list", "sh"), {"shapes"})
        self.assertLessEqual({"bowl", "box"}, self.complete("modes", "bo"))
        self.assertIn("configs", self.complete("build", "confi"))

    def test_other_shells(self):
        self.assertIn("bashcompinit", run("completion", "zsh").stdout)
        fish = run("completion", "fish").stdout
        for name in commands():
            self.assertRegex(fish, rf"(?m)^complete -c carillon -n __fish_use_subcommand -f -a {name} ")
        if shutil.which("fish"):
            checked = subprocess.run(["fish", "--no-execute"], input=fish, text=True,
                                     capture_output=True)
            self.assertEqual(checked.stderr, "")

    def test_a_shell_that_it_does_not_know(self):
        answer = run("completion", "tcsh")
        self.assertEqual(answer.returncode, 2)
        self.assertIn("tcsh", answer.stderr)


class Manual(unittest.TestCase):
    def test_every_command_is_in_it(self):
        page = run("manual").stdout
        for name in commands():
            self.assertIn(f".SS {name}".replace("-", "\\-"), page)
        for section in ("NAME", "SYNOPSIS", "OPTIONS", "COMMANDS", "EXIT STATUS", "ENVIRONMENT"):
            self.assertIn(f".SH {section}\n", page)
        # Nothing of a text is taken for a request.
        requests = set(re.findall(r"(?m)^[.']\w*", page))
        self.assertLessEqual(requests, {".TH", ".SH", ".SS", ".TP", ".PP", ".br", ".nf", ".fi"})

    @unittest.skipUnless(shutil.which("groff"), "no groff")
    def test_it_is_set_without_warnings(self):
        page = run("manual").stdout
        done = subprocess.run(["groff", "-man", "-ww", "-Tutf8"], input=page, text=True,
                              capture_output=True)
        self.assertEqual(done.stderr, "")
        self.assertIn("carillon strike bell -m iron -o bell.wav".split()[1], done.stdout)


class Help(unittest.TestCase):
    def test_every_command_has_examples(self):
        for name in commands():
            self.assertRegex(run(name, "--help").stdout, r"Examples?:\n.*carillon", name)


class Documentation(unittest.TestCase):
    def test_every_link_leads_to_a_file(self):
        pages = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
        self.assertGreater(len(pages), 30)
        for page in pages:
            text = re.sub(r"```.*?```", "", page.read_text(), flags=re.S)
            self.assertNotIn("@@", text, page.name)
            for link in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
                if not re.match(r"[a-z]+:", link):
                    self.assertTrue((page.parent / link).exists(), f"{page.name}: {link}")

    def test_every_page_can_be_found(self):
        listed = set(re.findall(r"\]\(([^)#\s]+)\)", (ROOT / "docs" / "README.md").read_text()))
        pages = {str(page.relative_to(ROOT / "docs")) for page in ROOT.glob("docs/**/*.md")}
        self.assertEqual(pages - listed, {"README.md"})


if __name__ == "__main__":
    unittest.main()
