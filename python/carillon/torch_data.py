"""PyTorch's view of a dataset; imported when it is asked for."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy
import numpy.typing
import torch
import torch.utils.data
from carillon.errors import InputError

if TYPE_CHECKING:
    from carillon.datasets import Dataset

Which = int | slice | Sequence[int] | numpy.typing.NDArray[Any] | torch.Tensor


class Samples(torch.utils.data.Dataset[Any]):
    """Pairs (data, label) of some samples.

    `samples[3]` is one pair; `samples[[3, 7, 1]]` reads many in one go. 16-bit audio comes as float, 1 at full
    scale; unsigned numbers come as signed ones of 64 bits, `id` with its bits.
    """

    def __init__(self, dataset: Dataset, rows: numpy.typing.NDArray[numpy.int64], label: str | None, data: str,
                 listener: int | None):
        self.dataset, self.rows, self.data, self.listener = dataset, rows, data, listener
        self._axes = dataset[data].shape[1:]
        if dataset[data].type == "text":
            raise InputError(f"{data} holds texts", "data is a column of numbers; labels may be texts")
        if listener is not None:
            heard = self._axes[0] if len(dataset["audio"].shape) == 3 and data in ("audio", "mel") else 0
            if not 0 <= listener < heard:
                raise InputError(f"{data} has no listener {listener}",
                                 f"it has {heard}, counted from 0" if heard else "leave listener out")
        #: Names of the labels, which are numbered over the whole dataset.
        self.classes: list[str] = []
        self.labels: torch.Tensor | None = None
        if label is not None:
            values = numpy.asarray(dataset[label][:])
            if dataset[label].type == "text":
                names, values = numpy.unique(values.astype(str), return_inverse=True)
                self.classes = names.tolist()
            self.labels = _tensor(values[self._places(label)])
        self._data_places = self._places(data).astype(numpy.uint64)
        self._numbers = numpy.arange(len(rows))

    def _places(self, column: str) -> numpy.typing.NDArray[numpy.int64]:
        """Rows of a column: the samples' own, or those of their objects, or of these in their materials."""
        shared = {"shapes": "shape_index", "appearances": "appearance_index"}.get(column.split("/")[0])
        if shared is None:
            return self.rows
        return numpy.asarray(self.dataset[shared][:])[self.rows].astype(numpy.int64)

    def __len__(self) -> int:
        return len(self.rows)

    def _read(self, places: numpy.typing.NDArray[numpy.uint64]) -> torch.Tensor:
        values = _tensor(self.dataset._column(self.data).read(places))
        if self.listener is not None:
            values = values[:, self.listener]
        return values.float() / 32768 if values.dtype == torch.int16 else values

    def __getitem__(self, which: Which) -> Any:
        numbers = self._numbers[which if isinstance(which, (int, slice)) else numpy.asarray(which)]
        if numbers.ndim == 0:
            return self._singles(numbers[None])[0]
        data = self._read(self._data_places[numbers])
        return data if self.labels is None else (data, self.labels[torch.from_numpy(numbers)])

    def __getitems__(self, which: Sequence[int]) -> list[Any]:
        """For DataLoaders that fetch many samples in one go."""
        return self._singles(self._numbers[numpy.asarray(which)])

    def _singles(self, numbers: numpy.typing.NDArray[numpy.int64]) -> list[Any]:
        data = list(self._read(self._data_places[numbers]))
        if self.labels is None:
            return data
        labels = self.labels[torch.from_numpy(numbers)]
        single: list[Any] = labels.tolist() if labels.ndim == 1 else list(labels)
        return list(zip(data, single))


def _tensor(values: numpy.typing.NDArray[Any]) -> torch.Tensor:
    """PyTorch has no unsigned numbers but bytes: these become signed ones of 64 bits, `id` with its bits."""
    if values.dtype.kind == "u" and values.dtype.itemsize > 1:
        values = values.view(numpy.int64) if values.dtype.itemsize == 8 else values.astype(numpy.int64)
    return torch.from_numpy(numpy.ascontiguousarray(values))
