"""Builds, and what they would run."""
from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import re
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

from carillon import _carillon, arguments
from carillon.datasets import Dataset
from carillon.errors import CarillonWarning, Error, FileError, error_class

Configuration = str | os.PathLike[str] | Mapping[str, Any]


def _text_and_name(configuration: Configuration) -> tuple[str, str]:
    """The text of a configuration, and what it is called."""
    if isinstance(configuration, Mapping):
        return json.dumps(configuration, default=arguments.plain), "configuration"
    path = os.fspath(configuration)
    try:
        with open(path, encoding="utf-8") as file:
            return file.read(), path
    except OSError as error:
        raise FileError(f"{path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise FileError(f"{path} is no text", "name a YAML file") from error


def _assignments(changes: Mapping[str, Any] | None) -> list[str]:
    return [f"{key}={json.dumps(value, default=arguments.plain)}"
            for key, value in arguments.mapping(changes, "set").items()]


@dataclasses.dataclass(frozen=True, repr=False)
class Plan:
    """What a build would run, and why."""

    text: str  #: for a person, as `carillon plan` prints it
    document: dict[str, Any]  #: all that `carillon plan --json` prints

    @property
    def samples(self) -> int:
        return int(self.document["samples"])

    @property
    def effects(self) -> dict[str, str]:
        """Those that would run, with the reason; of a sweep, in which variants."""
        if "effects" in self.document:
            return {effect["name"]: effect["reason"] for effect in self.document["effects"] if effect["enabled"]}
        found: dict[str, list[str]] = {}
        for variant in self.document["variants"]:
            for name in variant["effects"]:
                found.setdefault(name, []).append(variant["variant"])
        return {name: f"of {', '.join(variants)}" for name, variants in found.items()}

    @property
    def seconds(self) -> float:
        """Estimated, of one rank [s]."""
        return float(self.document["estimate"]["rank_seconds"])

    def __repr__(self) -> str:
        return f"<plan: {self.samples} samples, about {self.seconds:.3g} s of one rank, {', '.join(self.effects)}>"

    def __str__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        import html
        return f"<pre>{html.escape(self.text)}</pre>"


def plan(configuration: Configuration, *, set: Mapping[str, Any] | None = None, ranks: Sequence[int] = ()) -> Plan:
    """What a build of a configuration would run; runs nothing.

    configuration: a YAML file, or a mapping of its keys (paths in it are meant from the current folder).
    set: other values of some keys: `{"audio.seconds": 2}`. ranks: also simulate the schedule on so many.
    Raises ConfigError with file, line and key.
    """
    text, name = _text_and_name(configuration)
    counts = [arguments.whole(number, "ranks", 1, 10**7) for number in ranks]
    with arguments.arguments_of("configuration"):
        made = json.loads(_carillon.plan(text, name, _assignments(set), counts))
    return Plan(made["text"], made["document"])


def build(configuration: Configuration, *, ranks: int = 1, output: str | os.PathLike[str] | None = None,
          set: Mapping[str, Any] | None = None, retry_failed: bool = False, quiet: bool = True,
          mpirun: Sequence[str] = ("mpirun", "--oversubscribe")) -> Any:
    """Builds a dataset, or carries on where an earlier build of the same configuration stopped.

    The program `carillon` does it, on `ranks` by mpirun; Ctrl-C stops it, and the same call goes on. Its progress
    goes to standard error unless `quiet`; its warnings are CarillonWarnings.
    configuration: a YAML file, or a mapping of its keys (paths in it are meant from the current folder); output:
    folder, by default the configuration's `name`; set: other values of some keys.
    Returns the Dataset, or of a sweep those of its variants by their names. Where tasks failed, a CarillonWarning
    says so, and a dataset's `failures` why.
    Raises the errors of the command line with its words: ConfigError, InputError, ...
    """
    ranks = arguments.whole(ranks, "ranks", 1, 10**7)
    program = _carillon.program()
    if not program:
        raise Error("the program carillon was not found", "install it, or add its folder to PATH")
    text, name = _text_and_name(configuration)
    is_file = not isinstance(configuration, Mapping)
    command = [program, "--json", *(["--quiet"] if quiet else []), "build", name if is_file else "-"]
    if output is not None:
        command += ["--output", os.fspath(output)]
    for assignment in _assignments(set):
        command += ["--set", assignment]
    if retry_failed:
        command.append("--retry-failed")
    if ranks > 1:
        command = [*mpirun, "-n", str(ranks), *command]
    code, printed, said = _run(command, "" if is_file else text, quiet)
    for line in said:
        if warning := _WARNING.search(line):
            warnings.warn(warning[1], CarillonWarning, stacklevel=2)
    try:
        summary = json.loads(printed)
    except json.JSONDecodeError:
        raise Error("\n".join(said).strip() or f"carillon ended with code {code} and said nothing") from None
    if error := summary.get("error"):
        raise error_class(error["kind"])(*(_without_place(error.get(part, "")) for part in ("message", "hint")))
    if code == 130:
        raise Error("the build was interrupted from outside", "the same call goes on where it stopped")
    if failed := summary["failed_tasks"]:
        warnings.warn(f"{summary['output']}: {failed} tasks failed; failures.json says why", CarillonWarning,
                      stacklevel=2)
    if variants := summary.get("variants"):
        folders = [variant["variant"] for variant in variants]
        return {folder: Dataset(os.path.join(summary["output"], folder)) for folder in folders}
    return Dataset(summary["output"])


def _without_place(text: str) -> str:
    """Places in the text of a mapping, which nobody has written."""
    return re.sub(r"(?:stdin|configuration):\d+:\d+: ", "configuration: ", text)


_WARNING = re.compile(r"^[-\d]+ [:\d]+ warning: (.*)")


def _run(command: Sequence[str], given: str, quiet: bool) -> tuple[int, str, list[str]]:
    """Runs a program. Returns its exit code, standard output, and lines of standard error."""
    said: list[str] = []
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True) as running:
        assert running.stdin and running.stdout and running.stderr

        def listen() -> None:
            assert running.stderr
            for line in running.stderr:
                said.append(line.rstrip("\n"))
                if not quiet and not _WARNING.search(line):
                    sys.stderr.write(line)

        listener = threading.Thread(target=listen)
        listener.start()
        try:
            with contextlib.suppress(BrokenPipeError):  # it may have refused its options
                running.stdin.write(given)
                running.stdin.close()
            printed = running.stdout.read()
            running.wait()
        except KeyboardInterrupt:
            running.send_signal(signal.SIGTERM)  # a terminal has sent SIGINT to it, a notebook has not
            running.wait()
            raise
        finally:
            listener.join()
    return running.returncode, printed, said
