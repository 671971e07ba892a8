"""Completion in shells, the manual page, and links of the documentation."""
import functools
import os
import pathlib
import pty
import re
import shutil
import subprocess
import tempfile
import unittest

from program import CARILLON, run

ROOT = pathlib.Path(__file__).resolve().parents[2]


def commands():
    """Names of all commands, from `--help`."""
    text = run("--help").stdout.split("Subcommands:")[1].split("Exit codes:")[0]
    return re.findall(r"^  ([a-z][a-z-]+) ", text, re.M)


@functools.cache
def help_of(command):
    return run(command, "--help").stdout


def options(command):
    lines = re.findall(r"(?m)^  (-\S+)", help_of(command))
    return {name for line in lines for name in line.split(",")}


def typed_in_zsh(script, words):
    """What `carillon` is called with after its words and a tabulator were typed at a terminal."""
    with tempfile.NamedTemporaryFile("w") as file:
        file.write(script)
        file.flush()
        ours, its = pty.openpty()
        with subprocess.Popen(["zsh", "-f", "-i"], stdin=its, stdout=its, stderr=its, cwd=ROOT,
                              start_new_session=True, env={**os.environ, "TERM": "dumb"}):
            os.close(its)
            for line in (f"autoload -Uz compinit && compinit -D -u; source {file.name}",
                         'carillon() { print -r "<$@>" }', f"carillon {words}\t", "exit"):
                os.write(ours, f"{line}\n".encode())
            told = b""
            try:
                while block := os.read(ours, 4096):
                    told += block
            except OSError:  # the shell has ended
                pass
        os.close(ours)
    return re.search(rb"\n<(.*?)>\r", told)[1].decode()


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
        self.assertEqual(self.complete("export", "set", "--format", "''"), {"lhotse", "wav", "webdataset"})
        glasses = self.complete("strike", "bowl", "-m", "gla")
        self.assertIn("glass", glasses)
        self.assertTrue(all(name.startswith("gla") for name in glasses), glasses)
        self.assertIn("shapes", self.complete("list", "sh"))
        self.assertLessEqual({"bowl", "box"}, self.complete("modes", "bo"))
        self.assertIn("configs", self.complete("build", "confi"))

    @unittest.skipUnless(shutil.which("zsh"), "no zsh")
    def test_zsh(self):
        script = run("completion", "zsh").stdout
        for typed, meant in (("str", "strike"), ("strike bowl -m gla", "strike bowl -m glass"),
                             ("strike --liste", "strike --listener"), ("modes bow", "modes bowl"),
                             ("export set --format webd", "export set --format webdataset"),
                             ("build confi", "build configs")):
            self.assertEqual(typed_in_zsh(script, typed), meant)

    def test_fish(self):
        fish = run("completion", "fish").stdout
        for name in commands():
            self.assertRegex(fish, rf"(?m)^complete -c carillon -n __fish_use_subcommand -f -a {name} ")
        if shutil.which("fish"):
            for typed, meant in (("str", "strike"), ("strike bowl -m cera", "ceramic"),
                                 ("export set --format webd", "webdataset")):
                told = subprocess.run(["fish", "-c", fish + f"\ncomplete -C 'carillon {typed}'"],
                                      capture_output=True, text=True)
                self.assertEqual(told.stderr, "")
                self.assertEqual([line.split("\t")[0] for line in told.stdout.splitlines()], [meant])

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
        self.assertIn("\n         carillon strike bell -o bell.wav\n", done.stdout)


class Help(unittest.TestCase):
    def test_every_command_has_examples(self):
        for name in commands():
            self.assertRegex(help_of(name), r"Examples?:\n.*carillon", name)

    def test_what_stands_in_for_missing_commands_has_them_too(self):
        with tempfile.TemporaryDirectory() as folder:
            alone = shutil.copy(CARILLON, folder)  # carillon-learn does not lie beside it
            for name, *words in (["train", "x"], ["identify", "x", "-m", "y"]):
                told = subprocess.run([alone, name, "--help"], capture_output=True, text=True)
                self.assertRegex(told.stdout, rf"Examples:\n.*carillon {name}")
                refused = subprocess.run([alone, name, *words], capture_output=True, text=True)
                self.assertEqual(refused.returncode, 2)
                self.assertIn("needs carillon-learn", refused.stderr)

    def test_the_program_that_learns_begins_when_a_command_runs(self):
        with tempfile.TemporaryDirectory() as folder:
            alone = shutil.copy(CARILLON, folder)
            learner = pathlib.Path(folder) / "carillon-learn"
            learner.write_text('#!/bin/sh\necho "learns: $*"\n')
            learner.chmod(0o755)
            learning = pathlib.Path(folder) / "learning.yaml"
            learning.write_text("evaluate: {classification: {}}\n")

            def told(*words):
                return subprocess.run([alone, *map(str, words)], capture_output=True, text=True)

            for words in (["train", "x.yaml", "--search"], ["identify", "x.wav", "-m", "y"],
                          ["--quiet", "evaluate", learning], ["evaluate", learning, "--json"]):
                self.assertEqual(told(*words).stdout, f"learns: {' '.join(map(str, words))}\n")
            for words in (["train", "--help"], ["train"], ["identify", "x.wav"], ["manual"],
                          ["completion", "fish"], ["evaluate", "no-such.yaml"],
                          ["evaluate", learning, "--set", "evaluate.classification"]):
                self.assertNotIn("learns:", told(*words).stdout, words)


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

    def test_readme_names_every_command(self):
        page = (ROOT / "README.md").read_text()
        for name in commands():
            self.assertRegex(page, rf"carillon {name}\b(?!-)", name)

    def test_every_page_can_be_found(self):
        listed = set(re.findall(r"\]\(([^)#\s]+)\)", (ROOT / "docs" / "README.md").read_text()))
        pages = {str(page.relative_to(ROOT / "docs")) for page in ROOT.glob("docs/**/*.md")}
        self.assertEqual(pages - listed, {"README.md"})


if __name__ == "__main__":
    unittest.main()
