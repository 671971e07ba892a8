"""Networks that `carillon train` left: their weights, and the scores that they give.

    from carillon import models
    network = models.load("carillon-rsaudio/evaluation/models/material/isnn-a/seed-0-1a2b3c4d")
    inputs = network.read("carillon-rsaudio", [0, 5, 7])
    network.scores(*inputs), network.classes

PyTorch computes them where it is installed, NumPy otherwise. docs/learning.md lists the files.
"""
from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from carillon import _carillon
from carillon.errors import FileError, InputError

_Array = npt.NDArray[np.float32]

#: Samples that NumPy computes at a time: a convolution copies what its kernel meets.
_BLOCK = 8


def load(folder: str | os.PathLike[str]) -> Network:
    """A network's folder, or its `model.safetensors`. Raises `FileError` where it is damaged."""
    path = Path(folder)
    return Network(path / "model.safetensors" if path.is_dir() else path)


class Network:
    """A trained network, or a linear support vector machine."""

    #: Labels, in the order of scores.
    classes: list[str]
    #: What it gets: of each input its modality and the extent of one sample.
    inputs: list[tuple[str, tuple[int, ...]]]
    #: All layers with the names of their weights, and the settings of the training.
    table: dict[str, Any]
    #: Weights by their names.
    weights: dict[str, _Array]

    def __init__(self, path: Path) -> None:
        self.path = path
        self.table, self.weights = _read_safetensors(path)
        self.classes = self.table["classes"]
        self.inputs = [(row["modality"], tuple(row["extent"])) for row in self.table["inputs"]]
        self._script: Any = None

    def __repr__(self) -> str:
        inputs = ", ".join(name for name, _ in self.inputs)
        return f"<network {self.table['method']['name']}: {inputs} to {len(self.classes)} classes>"

    def read(self, dataset: str | os.PathLike[str] | Any, samples: Iterable[int], listener: int = 0) -> list[_Array]:
        """Inputs of some samples of a dataset (its folder, or what `carillon.open` gave), as in training."""
        folder = os.fspath(getattr(dataset, "folder", dataset))
        rows = np.asarray(list(samples), np.uint64)
        prepared = [_carillon.prepared(folder, listener, modality, rows) for modality, _ in self.inputs]
        return [_scaled(values, self.table["method"]["spectrogram"]) if modality == "spectrogram" else values
                for values, (modality, _) in zip(prepared, self.inputs)]

    def scores(self, *inputs: npt.ArrayLike, torch: bool | None = None) -> _Array:
        """Scores, samples x classes: of networks logits, of support vector machines distances.

        `inputs`: one array for each of `inputs`, samples x extent. `torch`: by PyTorch (an error without it), or
        by NumPy; by default PyTorch where it is there.
        """
        arrays = self._checked(inputs)
        script = None if torch is False else self._torch_script(torch is True)
        if script is not None:
            module, library = script
            with library.no_grad():
                found: _Array = module(*(library.from_numpy(array) for array in arrays)).numpy()
            return found
        parts = [self._forward([array[first:first + _BLOCK] for array in arrays])
                 for first in range(0, len(arrays[0]), _BLOCK)]
        return np.concatenate(parts) if parts else np.zeros((0, len(self.classes)), np.float32)

    def probabilities(self, *inputs: npt.ArrayLike, torch: bool | None = None) -> _Array:
        """Softmax of the scores, without the temperature that `carillon identify` finds."""
        scores = self.scores(*inputs, torch=torch)
        exponentials = np.exp(scores - scores.max(1, keepdims=True))
        return np.asarray(exponentials / exponentials.sum(1, keepdims=True))

    def _checked(self, inputs: Sequence[npt.ArrayLike]) -> list[_Array]:
        arrays = [np.ascontiguousarray(values, np.float32) for values in inputs]
        found = [array.shape[1:] for array in arrays]
        expected = [extent for _, extent in self.inputs]
        if found != expected or len({len(array) for array in arrays}) != 1:
            words = ", ".join(f"{name} {('samples', *extent)}" for name, extent in self.inputs)
            raise InputError(f"inputs of {[array.shape for array in arrays]}; {self!r} takes {words}")
        return arrays

    def _torch_script(self, needed: bool) -> Any:
        """The TorchScript program with the module torch; None where there is none."""
        if self._script is None:
            program = self.path.with_name("model.pt")
            try:
                import torch
                library: Any = torch
                self._script = (library.jit.load(str(program)).eval(), library) if program.exists() else False
            except ImportError:
                if needed:
                    raise
                self._script = False
        if needed and not self._script:
            raise FileError(f"{self.path.with_name('model.pt')}: not there")
        return self._script or None

    def _forward(self, inputs: list[_Array]) -> _Array:
        features = []
        for values, rows in zip(inputs, self.table["branches"]):
            for row in rows:
                values = _LAYERS[row["kind"]](values, row, self.weights)
            features.append(values)
        return _dense(self._joined(features), self.table["classify"], self.weights)

    def _joined(self, features: list[_Array]) -> _Array:
        fusion = self.table["fusion"]
        if fusion["kind"] == "concatenate":
            return np.concatenate(features, 1)
        if fusion["kind"] == "add":
            return np.asarray(sum(features))
        projected = [_dense(values, row, self.weights) for values, row in zip(features, fusion["projections"])]
        if fusion["kind"] == "multiply":
            return np.asarray(np.prod(np.tanh(projected), 0))
        product = np.prod(projected, 0)
        sums = product.reshape(len(product), -1, fusion["factors"]).sum(2)
        root = np.sign(sums) * np.sqrt(np.abs(sums) + 1e-12)
        return np.asarray(root / np.maximum(np.linalg.norm(root, axis=1, keepdims=True), 1e-12))


def _read_safetensors(path: Path) -> tuple[dict[str, Any], dict[str, _Array]]:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise FileError(f"{path}: {error.strerror}; networks of `carillon train` are kept in "
                        "OUTPUT/evaluation/models/TASK/METHOD/seed-N-HASH") from error
    start = 8 + int.from_bytes(data[:8], "little")
    try:
        header = json.loads(data[8:start])
        meta = header.pop("__metadata__")
        table = json.loads(meta["carillon"])
    except (ValueError, KeyError, AttributeError) as error:
        raise FileError(f"{path}: cut short, or not written by `carillon train`") from error
    values = data[start:]
    if hashlib.sha256(values).hexdigest() != meta["sha256"]:
        raise FileError(f"{path}: cut short or changed; take it from where it was made, or train again")
    weights = {name: np.frombuffer(values[slice(*entry["data_offsets"])], "<f4").reshape(entry["shape"])
               for name, entry in header.items()}
    return table, weights


def _per_channel(weights: _Array, axes: int) -> _Array:
    return weights.reshape(-1, *[1] * (axes - 2))


def _dense(values: _Array, row: dict[str, Any], weights: dict[str, _Array]) -> _Array:
    return values @ weights[row["weight"]].T + weights[row["bias"]]


def _convolution(values: _Array, row: dict[str, Any], weights: dict[str, _Array]) -> _Array:
    kernel = weights[row["weight"]]
    axes = len(row["stride"])
    padded = np.pad(values, [(0, 0), (0, 0), *((side, side) for side in row["padding"])])
    view: Any = np.lib.stride_tricks.sliding_window_view  # whose stubs know of one axis alone
    seen = view(padded, kernel.shape[2:], tuple(range(2, 2 + axes)))
    seen = seen[(slice(None), slice(None), *(slice(None, None, step) for step in row["stride"]))]
    summed = [1, *range(2 + axes, 2 + 2 * axes)]  # channels, and all of the kernel
    found = np.moveaxis(np.tensordot(seen, kernel, (summed, range(1, 2 + axes))), -1, 1)
    return found if row["bias"] is None else found + _per_channel(weights[row["bias"]], found.ndim)


def _normalisation(values: _Array, row: dict[str, Any], weights: dict[str, _Array]) -> _Array:
    scale = weights[row["weight"]] / np.sqrt(weights[row["variance"]] + np.float32(row["epsilon"]))
    shift = weights[row["bias"]] - scale * weights[row["mean"]]
    return values * _per_channel(scale, values.ndim) + _per_channel(shift, values.ndim)


def _rectifier(values: _Array, row: dict[str, Any], weights: dict[str, _Array]) -> _Array:
    return np.where(values > 0, values, np.float32(row["slope"]) * values)


def _maximum(values: _Array, row: dict[str, Any], weights: dict[str, _Array]) -> _Array:
    for axis, window in enumerate(row["window"], 2):
        whole = values.shape[axis] // window
        kept = np.take(values, range(whole * window), axis)
        values = kept.reshape(*kept.shape[:axis], whole, window, *kept.shape[axis + 1:]).max(axis + 1)
    return values


def _adaptive_maximum(values: _Array, row: dict[str, Any], weights: dict[str, _Array]) -> _Array:
    outputs, length = row["outputs"], values.shape[2]
    return np.stack([values[:, :, i * length // outputs:math.ceil((i + 1) * length / outputs)].max(2)
                     for i in range(outputs)], 2)


def _mean(values: _Array, row: dict[str, Any], weights: dict[str, _Array]) -> _Array:
    return np.asarray(values.mean(2))


def _flatten(values: _Array, row: dict[str, Any], weights: dict[str, _Array]) -> _Array:
    return values.reshape(len(values), -1)


def _copies(values: _Array, row: dict[str, Any], weights: dict[str, _Array]) -> _Array:
    return values.reshape(-1, *row["shape"])


def _over_copies(values: _Array, row: dict[str, Any], weights: dict[str, _Array]) -> _Array:
    copies = values.reshape(-1, row["count"], *values.shape[1:])
    return np.asarray(copies.mean(1) if row["by"] == "mean" else copies.max(1))


def _scaled(powers: _Array, spectrogram: dict[str, Any]) -> _Array:
    """Powers relative to the loudest cell as the method is given them."""
    if spectrogram["scale"] == "power":
        return powers
    with np.errstate(divide="ignore"):
        decibels = 10 * np.log10(powers.astype(np.float64))
    return np.asarray(np.maximum(0, 1 + decibels / spectrogram["range_db"]), np.float32)


_LAYERS = {"dense": _dense, "convolution": _convolution, "normalisation": _normalisation, "rectifier": _rectifier,
           "maximum": _maximum, "adaptive_maximum": _adaptive_maximum, "mean": _mean, "flatten": _flatten,
           "copies": _copies, "over_copies": _over_copies}
