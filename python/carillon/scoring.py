"""Anyone's answers for a dataset's test samples, held against the truth."""
from __future__ import annotations

import csv
import json
import os
import tempfile
from collections.abc import Iterable, Mapping
from typing import Any

from carillon import _carillon, objects
from carillon.errors import InputError

Path = str | os.PathLike[str]


class Scores:
    """Where answers stand (docs/service.md). `entries`: what was handed in now, with recalls, confusions and
    calibration; `rows`: the leaderboard, the best first; `folder`: where both are kept.
    """

    def __init__(self, document: dict[str, Any]):
        self.entries: list[dict[str, Any]] = document["entries"]
        self.leaderboard: dict[str, Any] = document["leaderboard"]
        self.rows: list[dict[str, Any]] = self.leaderboard["rows"]
        self.folder: str = document["folder"]
        self._text: str = document["text"]

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<{self.leaderboard['task']}: {len(self.rows)} entries>"


def score(dataset: Path, task: str, answers: Path | Mapping[str, Iterable[Any]] | Any = None, *, name: str = "",
          tasks: Path = "", sealed: Path = "", output: Path = "") -> Scores:
    """Scores answers as `carillon score` does, and keeps them on the task's leaderboard.

    answers: a file (CSV, .npz, .npy, .parquet), or columns by name: a dictionary of arrays, a pandas DataFrame.
    `sample` and `class`, or one column of probabilities for each class; without answers the board is told as it
    stands. name: of the entry; columns need one. tasks: a configuration with `train.tasks`; sealed: what
    `carillon export --hide test` kept; output: a folder in place of the dataset's.

    Raises InputError: names what is missing, double or none of the classes.
    """
    rest = (os.fspath(tasks), os.fspath(sealed), os.fspath(output), os.fspath(objects.cache))
    folder = os.fspath(dataset)
    if answers is None:
        return Scores(json.loads(_carillon.score(folder, task, [], *rest)))
    if isinstance(answers, str | os.PathLike):
        return Scores(json.loads(_carillon.score(folder, task, [(os.fspath(answers), name)], *rest)))
    if not name:
        raise InputError("columns of answers have no name", "score(..., name=\"mine\")")
    with tempfile.TemporaryDirectory() as place:
        path = os.path.join(place, "answers.csv")
        _write(answers, path)
        return Scores(json.loads(_carillon.score(folder, task, [(path, name)], *rest)))


def _write(answers: Any, path: str) -> None:
    columns = {str(key): list(answers[key]) for key in answers}
    lengths = {key: len(values) for key, values in columns.items()}
    if len(set(lengths.values())) > 1:
        raise InputError(f"columns of different lengths: {lengths}", "one value for each sample")
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values(), strict=True))
