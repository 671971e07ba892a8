"""PyTorch's view of a dataset; imported when it is asked for."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy
import torch
import torch.utils.data
from carillon.errors import InputError

if TYPE_CHECKING:
    import numpy.typing
    from carillon.datasets import Dataset


class Samples(torch.utils.data.Dataset[Any]):
    """Pairs (data, label) of some samples.

    `samples[3]` is one pair; `samples[[3, 7, 1]]` reads many in one go. 16-bit audio comes as float, 1 at full
    scale.
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
            self.labels = torch.from_numpy(numpy.ascontiguousarray(values[rows]))
        #: Rows of the data: the samples' own, or those of their objects.
        self._places = (numpy.asarray(dataset["shape_index"][:])[rows] if data.startswith("shapes/") else rows
                        ).astype(numpy.uint64)

    def __len__(self) -> int:
        return len(self.rows)

    def _read(self, places: numpy.typing.NDArray[numpy.uint64]) -> torch.Tensor:
        values = torch.from_numpy(self.dataset._column(self.data).read(places))
        if self.listener is not None:
            values = values[:, self.listener]
        return values.float() / 32768 if values.dtype == torch.int16 else values

    def __getitem__(self, which: int | Sequence[int]) -> Any:
        if isinstance(which, int):
            if not -len(self) <= which < len(self):
                raise IndexError(which)
            data = self._read(self._places[which:which + 1] if which >= 0 else self._places[which:][:1])[0]
            return data if self.labels is None else (data, int(self.labels[which]))
        numbers = torch.as_tensor(which)
        data = self._read(self._places[numbers.numpy()])
        return data if self.labels is None else (data, self.labels[numbers])

    def __getitems__(self, which: Sequence[int]) -> list[Any]:
        """For DataLoaders that fetch many samples in one go."""
        batch = self[which]
        return list(batch) if self.labels is None else [(data, int(label)) for data, label in zip(*batch)]
