"""What a shell does to a program: readers that go, outputs that are full or closed, terminals, Ctrl-C."""
import errno
import os
import pty
import re
import signal
import subprocess
import time
import unittest

from interrupted import descendants, wait_for
from mistakes import LONG, NEVER, SMALL, TILE
from program import CARILLON, TIMEOUT_FACTOR, FolderTest, run


def at_a_terminal(folder, *words, plain):
    """What a command shows on a terminal, and its exit code."""
    ours, theirs = pty.openpty()
    environment = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
    environment |= {"TERM": "xterm-256color", **({"NO_COLOR": "1"} if plain else {})}
    process = subprocess.Popen([CARILLON, *words], stdin=theirs, stdout=theirs, stderr=theirs, cwd=folder, env=environment)
    os.close(theirs)
    shown = b""
    while True:
        try:
            block = os.read(ours, 65536)
        except OSError as error:  # Linux' way to say that nobody holds the other end
            if error.errno != errno.EIO:
                raise
            block = b""
        if not block:
            break
        shown += block
    os.close(ours)
    return shown.decode(), process.wait(timeout=60)


class Streams(FolderTest):
    """Standard output that is closed, full or read by nobody, and terminals."""

    COMMANDS = (("list", "materials"), ("--help",), ("modes", "--help"), ("manual",), ("plan", "small.yaml"),
                ("plan", "small.yaml", "--json"), ("modes", *TILE))

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        (cls.folder / "small.yaml").write_text(SMALL)

    def ends(self, words, **streams):
        """Exit code and standard error."""
        process = subprocess.run([CARILLON, *words], stderr=subprocess.PIPE, text=True, cwd=self.folder, timeout=60,
                                 **streams)
        for part in NEVER:
            self.assertNotIn(part, process.stderr, words)
        return process.returncode, process.stderr

    def test_a_reader_that_goes_ends_it_quietly(self):
        for words in self.COMMANDS:
            ours, theirs = os.pipe()
            os.close(ours)
            # As a shell would say of any program: 128 + SIGPIPE.
            self.assertEqual(self.ends(words, stdout=theirs), (-signal.SIGPIPE, ""), words)
            os.close(theirs)

    def test_a_reader_that_goes_where_the_signal_is_ignored(self):
        ignored = signal.signal(signal.SIGPIPE, signal.SIG_IGN)
        try:
            for words in self.COMMANDS:
                ours, theirs = os.pipe()
                os.close(ours)
                code = self.ends(words, stdout=theirs, restore_signals=False)
                os.close(theirs)
                self.assertEqual(code, (128 + signal.SIGPIPE, ""), words)
        finally:
            signal.signal(signal.SIGPIPE, ignored)

    def test_a_full_output_is_told(self):
        for words in self.COMMANDS:
            with open("/dev/full", "w") as full:
                code, error = self.ends(words, stdout=full)
            self.assertEqual(code, 2, words)
            self.assertIn("carillon: standard output: cannot be written: No space left on device", error)
            self.assertLessEqual(len(error.splitlines()), 2)

    def test_a_closed_output_is_told(self):
        for words in self.COMMANDS:
            code, error = self.ends(words, preexec_fn=lambda: os.close(1))
            self.assertEqual(code, 2, words)
            self.assertIn("carillon: standard output: cannot be written: Bad file descriptor", error)

    def test_no_file_takes_the_place_of_a_closed_output(self):
        for stream in (0, 1, 2):
            wav = self.folder / f"closed-{stream}.wav"
            command = [CARILLON, "strike", *TILE, "-o", wav, "--seconds", "0.1"]
            subprocess.run(command, preexec_fn=lambda stream=stream: os.close(stream), stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL, cwd=self.folder, timeout=60, check=False)
            self.assertEqual(wav.read_bytes()[:4], b"RIFF", stream)
            self.assertEqual(wav.stat().st_size, (self.folder / "closed-0.wav").stat().st_size)

    def test_escape_codes_are_for_terminals_of_those_who_want_them(self):
        for plain in (False, True):
            output = f"seen-{plain}"
            shown, code = at_a_terminal(self.folder, "--cache", "", "build", "small.yaml", "-o", output, plain=plain)
            self.assertEqual(code, 0, shown)
            self.assertIn("100 %", shown)
            self.assertEqual("\x1b" in shown, not plain, shown)
        result = run("build", "small.yaml", "-o", "unseen", cwd=self.folder)
        self.assertNotIn("\x1b", result.stdout + result.stderr)


class Interrupted(FolderTest):
    """Ctrl-C: gone within seconds, with a word how to go on and nothing left behind."""

    ALLOWED_S = 3 * TIMEOUT_FACTOR

    def setUp(self):
        self.temporary = self.folder / self._testMethodName
        self.temporary.mkdir()

    def start(self, *words, ranks=None):
        command = [CARILLON, "--cache", "", *words]
        if ranks:
            command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *command]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=self.folder,
                                env={**os.environ, "TMPDIR": str(self.temporary)},
                                preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))

    def left(self):
        """Of Carillon; MPI's own folders are its own matter."""
        return [path.name for path in self.temporary.iterdir() if path.name.startswith("carillon")]

    def interrupt(self, process, ranks=None):
        family = descendants(process.pid)
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
        self.assertLess(time.monotonic() - begin, self.ALLOWED_S)
        # mpirun has a code of its own where it was told to end.
        self.assertIn(process.returncode, (130,) if ranks is None else (130, 1), err)
        for part in NEVER:
            self.assertNotIn(part, err)
        self.assertTrue(wait_for(lambda: not any(os.path.exists(f"/proc/{pid}") for pid in family[1:]), 5))
        self.assertEqual(self.left(), [])
        return out, err

    def test_while_it_meshes(self):
        for ranks in (None, 2):
            process = self.start("modes", *LONG, ranks=ranks)
            self.assertTrue(wait_for(self.left, 30))
            _, err = self.interrupt(process, ranks)
            if ranks is None:
                self.assertIn("carillon: interrupted\n  hint: run the same command again", err)
                self.assertEqual(len(err.strip().splitlines()), 2, err)

    def test_while_it_solves(self):
        wav = self.folder / "never.wav"
        words = ("strike", "block:length=20cm,width=20cm,height=20cm", "-m", "steel", "--order", "3", "--element-size",
                 "2cm", "--mirror-planes", "off", "--max-modes", "300", "-o", wav)
        for ranks in (None, 2):
            process = self.start(*map(str, words), ranks=ranks)
            self.assertTrue(wait_for(self.left, 30))
            self.assertTrue(wait_for(lambda: not self.left(), 60))  # the mesh is there
            time.sleep(1)
            self.assertIsNone(process.poll())
            self.interrupt(process, ranks)
            self.assertFalse(wav.exists())

    def test_while_it_builds(self):
        config = self.write("long.yaml", SMALL.replace("per_object: 2", "per_object: 2000").replace("0.1 s", "4 s"))
        output = self.folder / "long"
        for ranks in (None, 2):
            process = self.start("build", str(config), "-o", str(output), ranks=ranks)
            self.assertTrue(wait_for(lambda: (output / "journal.jsonl").exists(), 60))
            time.sleep(1)
            out, err = self.interrupt(process, ranks)
            if ranks is None:
                self.assertRegex(out + err, re.compile("same command|run .*again"))
            # A shard that was being written is not kept; what is left of it goes when the build goes on.
            left = list(output.rglob(".*.tmp*"))
            self.assertLessEqual(len(left), ranks or 1)
            process = self.start("build", str(config), "-o", str(output), ranks=ranks)
            self.assertTrue(wait_for(lambda left=left: not any(path.exists() for path in left), 60))
            time.sleep(1)
            self.interrupt(process, ranks)


if __name__ == "__main__":
    unittest.main()
