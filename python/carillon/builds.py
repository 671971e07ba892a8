"""Builds, and what they would run."""
from __future__ import annotations

import dataclasses
import json
import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from typing import Any

from carillon import _carillon, show
from carillon.datasets import Dataset
from carillon.errors import ConfigError, Error, FileError, InputError

Configuration = str | os.PathLike[str] | Mapping[str, Any]


def _text_and_name(configuration: Configuration) -> tuple[str, str]:
    """The text of a configuration, and what it is called."""
    if isinstance(configuration, Mapping):
        return json.dumps(configuration, default=show.plain), "configuration"
    path = os.fspath(configuration)
    try:
        with open(path, encoding="utf-8") as file:
            return file.read(), path
    except OSError as error:
        raise FileError(f"{path}: {error.strerror}") from error


def _assignments(changes: Mapping[str, Any] | None) -> list[str]:
    return [f"{key}={value if isinstance(value, str) else json.dumps(value, default=show.plain)}"
            for key, value in (changes or {}).items()]


@dataclasses.dataclass(frozen=True)
class Plan:
    """What a build would run, and why."""

    text: str = dataclasses.field(repr=False)  #: for a person, as `carillon plan` prints it
    document: dict[str, Any] = dataclasses.field(repr=False)  #: all that `carillon plan --json` prints

    @property
    def samples(self) -> int:
        return int(self.document["samples"])

    @property
    def effects(self) -> dict[str, str]:
        """Those that would run, with the reason."""
        return {effect["name"]: effect["reason"] for effect in self.document["effects"] if effect["enabled"]}

    @property
    def seconds(self) -> float:
        """Estimated, of one rank [s]."""
        return float(self.document["estimate"]["rank_seconds"])

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
    made = json.loads(_carillon.plan(text, name, _assignments(set), list(ranks)))
    return Plan(made["text"], made["document"])


def build(configuration: Configuration, *, ranks: int = 1, output: str | os.PathLike[str] | None = None,
          set: Mapping[str, Any] | None = None, retry_failed: bool = False, quiet: bool = True,
          mpirun: Sequence[str] = ("mpirun", "--oversubscribe")) -> Dataset:
    """Builds a dataset, or carries on where an earlier build of the same configuration stopped.

    The program `carillon` does it, on `ranks` by mpirun; Ctrl-C stops it, and the same call goes on.
    configuration: a YAML file, or a mapping of its keys (paths in it are meant from the current folder); output:
    folder, by default the configuration's `name`; set: other values of some keys.
    Returns the dataset; its `failures` lists the tasks that failed. Sweeps give the first variant.
    Raises ConfigError, InputError with the words of the command line.
    """
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
    running = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True)
    try:
        printed, said = running.communicate("" if is_file else text)
    except KeyboardInterrupt:
        running.send_signal(signal.SIGTERM)  # a terminal has sent SIGINT to it, a notebook has not
        running.communicate()
        raise
    if running.returncode in (130, -signal.SIGINT, -signal.SIGTERM):
        raise KeyboardInterrupt
    try:
        summary = json.loads(printed)
    except json.JSONDecodeError:
        raise _error_of(said, running.returncode) from None
    return Dataset(summary["output"])


def _error_of(said: str, code: int) -> Error:
    """What the program said on standard error, as an exception."""
    lines = said.splitlines()
    first = next((i for i, line in enumerate(lines) if line.startswith("carillon: ")), None)
    if first is None:
        return Error(said.strip() or f"carillon ended with code {code}")
    message, hint = lines[first].removeprefix("carillon: "), ""
    for line in lines[first + 1:]:
        if line.startswith("  hint: "):
            hint = line.removeprefix("  hint: ")
            break
    kind = ConfigError if code == 2 and message.count(":") >= 3 else InputError if code == 2 else Error
    return kind(message, hint)
