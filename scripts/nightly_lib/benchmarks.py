"""What a nightly run runs: lines of a list, and one run of one of them."""
import hashlib
import os
import pathlib
import re
import shlex
import signal
import subprocess
import threading
import time
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMANDS = ("build", "evaluate", "accuracy")
FINISHED = (0, 3)  # 3: some tasks failed; how many is a measure


class Unusable(Exception):
    """The nightly run cannot run at all; says why."""


@dataclass
class Benchmark:
    name: str
    words: list  # command, configuration, options, as after `carillon`
    hash: str    # of the words and of every file that decides what they do


@dataclass
class Run:
    ok: bool
    code: int | None
    seconds: float
    processor_s: float  # of the process and all that it waited for
    resident: int       # most bytes of one of them
    message: str


def read_list(path):
    """Benchmarks of a list: a line each, `[NAME:] COMMAND CONFIG [OPTION...]`; # begins a comment."""
    try:
        lines = pathlib.Path(path).read_text().splitlines()
    except OSError as error:
        raise Unusable(f"{path}: {error.strerror}") from error
    found = []
    for number, line in enumerate(lines, 1):
        words = shlex.split(line, comments=True)
        if words:
            found.append(_benchmark(words, f"{path}:{number}", found))
    if not found:
        raise Unusable(f"{path}: no benchmarks in it")
    return found


def of_configurations(paths):
    """Benchmarks of configurations alone: their sections say which command they are for."""
    found = []
    for path in paths:
        found.append(_benchmark([_command_for(path), path], path, found))
    return found


def _command_for(path):
    try:
        keys = set(re.findall(r"^(\w+):", pathlib.Path(path).read_text(), re.MULTILINE))
    except OSError as error:
        raise Unusable(f"{path}: {error.strerror}") from error
    if "evaluate" in keys:
        return "evaluate"
    study = {"orders", "tolerances", "pitch_cents", "reference", "repeats"}
    return "accuracy" if keys & study else "build"


def _benchmark(words, place, earlier):
    name = words.pop(0)[:-1] if words[0].endswith(":") else None
    if len(words) < 2 or words[0] not in COMMANDS:
        raise Unusable(f"{place}: expected {', '.join(COMMANDS)} and a configuration")
    path = pathlib.Path(words[1])
    path = path if path.exists() else ROOT / words[1]
    if not path.is_file():
        raise Unusable(f"{place}: there is no {words[1]}")
    name = name or path.stem
    if "/" in name or ": " in name or name in (one.name for one in earlier):
        raise Unusable(f"{place}: {name}: another line has this name; begin the line with `NAME:`")
    digest = hashlib.sha256(repr([words[0], *words[2:]]).encode())
    for part in [path, *_named_files(path)]:
        digest.update(part.read_bytes())
    return Benchmark(name, [words[0], str(path.resolve()), *words[2:]], digest.hexdigest()[:16])


def _named_files(path):
    """Files beside a configuration that it names: materials, strikes, meshes."""
    names = sorted(set(re.findall(r"[\w./-]+\.\w+", path.read_text())))
    return [part for name in names if (part := path.parent / name).is_file() and part != path]


def command(benchmark, output, program, ranks):
    """The whole line, with the words that start several ranks."""
    own = [program, "--cache", "", "--quiet", *benchmark.words, "-o", str(output)]
    if "CARILLON_LAUNCH" in os.environ:
        return [*shlex.split(os.environ["CARILLON_LAUNCH"]), *own]
    start = 'source scripts/environment; cd "$1"; shift; exec {} "$@"'
    words = f'"${{mpirun[@]}}" -n {ranks}' if ranks > 1 else ""
    return ["bash", "-c", f'cd {shlex.quote(str(ROOT))}; ' + start.format(words), "nightly",
            os.getcwd(), *own]


def run(words, log, timeout):
    """Runs a command to its end, or for so many seconds; what it says goes to the file `log`."""
    begin = time.monotonic()
    with open(log, "a") as file:
        file.write(f"$ {shlex.join(words)}\n")
        file.flush()
        process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=file, stderr=file,
                                   start_new_session=True)
        late = threading.Event()
        timer = threading.Timer(timeout, lambda: (late.set(), _end(process.pid)))
        timer.start()
        try:
            _, status, used = os.wait4(process.pid, 0)
        except BaseException:
            _end(process.pid)
            raise
        finally:
            timer.cancel()
    code = os.waitstatus_to_exitcode(status)
    process.returncode = code  # it is waited for; Popen need not
    message = (f"took longer than {timeout:g} s" if late.is_set() else
               "" if code in FINISHED else f"ended with {_end_of(code)}: {last_words(log)}")
    return Run(code in FINISHED and not late.is_set(), code, time.monotonic() - begin,
               used.ru_utime + used.ru_stime, used.ru_maxrss * 1024, message)


def _end(group):
    """mpirun ends its ranks when it is asked to; what is left is killed."""
    for word, wait in ((signal.SIGTERM, 10), (signal.SIGKILL, 0)):
        try:
            os.killpg(group, word)
        except ProcessLookupError:
            return
        for _ in range(wait * 10):
            time.sleep(0.1)
            try:
                os.killpg(group, 0)
            except ProcessLookupError:
                return


def _end_of(code):
    return f"signal {-code}" if code < 0 else f"exit code {code}"


def last_words(log):
    """The last line that a program wrote, without its hints, for a message of one line."""
    lines = [line.strip() for line in pathlib.Path(log).read_text(errors="replace").splitlines()]
    lines = [line for line in lines if line and not line.startswith(("hint:", "$ "))]
    return lines[-1][:200] if lines else "it said nothing"
