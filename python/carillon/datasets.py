"""Datasets as arrays, and as PyTorch reads them."""
from __future__ import annotations

import functools
import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy
import numpy.typing
from carillon import _carillon
from carillon.errors import InputError

if TYPE_CHECKING:
    from carillon.torch_data import Samples
    from torch.utils.data import DataLoader

Rows = int | slice | Sequence[int] | numpy.typing.NDArray[Any] | tuple[Any, ...]
PARTS = ("train", "validation", "test")


class Column:
    """One value or array of each sample; read as it is indexed, by NumPy's rules: `column[7]`, `column[rows]`,
    `column[:, 0]`, `column[mask]`.
    """

    def __init__(self, dataset: Dataset, name: str):
        self._dataset, self.name = dataset, name
        opened = dataset._column(name)
        self.type: str = opened.type  #: as in docs/format.md: float32, ..., text
        self.shape: tuple[int, ...] = tuple(opened.extent)
        self._texts: numpy.typing.NDArray[Any] | None = None

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, rows: Rows) -> Any:
        """Rows in the order that they are asked for. Raises FileError: names the shard that is lost."""
        if self.type == "text":
            if self._texts is None:
                self._texts = numpy.array(self._dataset._column(self.name).texts(), object)
            found = self._texts[rows]
            return found.copy() if isinstance(found, numpy.ndarray) else found
        axes = rows if isinstance(rows, tuple) else (rows,)
        if not axes or axes[0] is None or axes[0] is Ellipsis:
            return self._read(self._numbers)[axes]
        if isinstance(axes[0], slice):
            return self._read(self._numbers[axes[0]])[(slice(None), *axes[1:])]
        first = numpy.asarray(axes[0])
        numbers = self._numbers[first if first.size else first.astype(numpy.intp)]
        # Each row that is asked for is read once; which of them, NumPy then says.
        read, places = numpy.unique(numbers, return_inverse=True)
        where = int(places[0]) if numbers.ndim == 0 else places.reshape(numbers.shape)
        return self._read(read)[(where, *axes[1:])]

    def _read(self, numbers: numpy.typing.NDArray[numpy.uint64]) -> numpy.typing.NDArray[Any]:
        return self._dataset._column(self.name).read(numbers)

    @functools.cached_property
    def _numbers(self) -> numpy.typing.NDArray[numpy.uint64]:
        return numpy.arange(len(self), dtype=numpy.uint64)

    def __array__(self, dtype: Any = None) -> numpy.typing.NDArray[Any]:
        values = numpy.asarray(self[:])
        return values if dtype is None else values.astype(dtype)

    @property
    def attributes(self) -> dict[str, Any]:
        """`unit`, and of `mel` how it was made."""
        return self._dataset._attributes(self.name)

    def __repr__(self) -> str:
        return f"<{self.name}: {self.type} {list(self.shape)} [{self.attributes.get('unit', '1')}]>"


class Dataset(Mapping[str, Column]):
    """The samples of a dataset by column, and its objects under `shapes/`, what they look like under
    `appearances/`.

    Files are opened when they are first read and stay open; a process that is forked or spawned opens its own.
    """

    def __init__(self, folder: str | os.PathLike[str]):
        self.folder = os.path.abspath(folder)
        self._path = os.path.join(self.folder, "index.h5")
        if not os.path.exists(self._path):
            what = ("it holds a sweep: open the folder of a variant in it"
                    if os.path.exists(os.path.join(self.folder, "sweep.json"))
                    else "name the folder that a build made")
            raise InputError(f"{self.folder} is no dataset: it has no index.h5", what)
        self._close()
        self._names: list[str] = self._file().names()

    def _close(self) -> None:
        self._process = os.getpid()
        self._index: _carillon.Index | None = None
        self._opened: dict[str, _carillon.Column] = {}
        self._columns: dict[str, Column] = {}

    def _file(self) -> _carillon.Index:
        if self._process != os.getpid():  # forked: what the parent has open is not touched
            self._close()
        if self._index is None:
            self._index = _carillon.Index(self._path)
        return self._index

    def _column(self, name: str) -> _carillon.Column:
        index = self._file()
        if name not in self._opened:
            self._opened[name] = index.column(name)
        return self._opened[name]

    def _attributes(self, name: str) -> dict[str, Any]:
        def value_of(text: str) -> Any:
            if text.startswith('"'):
                return json.loads(text)
            return int(text) if text.lstrip("-").isdigit() else float(text)
        return {key: value_of(text) for key, text in self._file().attributes(name).items()}

    def __getstate__(self) -> dict[str, Any]:
        return {"folder": self.folder}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["folder"])  # type: ignore[misc]

    def __getitem__(self, name: str) -> Column:
        if name not in self._names:
            raise KeyError(f"{self.folder} has no column {name!r}; it has {', '.join(self._names)}")
        self._file()
        if name not in self._columns:
            self._columns[name] = Column(self, name)
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __len__(self) -> int:
        return len(self._names)

    @property
    def samples(self) -> int:
        """How many there are."""
        return len(self["key"]) if "key" in self._names else 0

    @property
    def rate(self) -> float:
        """Of the audio [Hz]."""
        return float(self._attributes(".")["sample_rate_hz"])

    @property
    def description(self) -> dict[str, Any]:
        """dataset.json: configuration, versions, materials, objects."""
        with open(os.path.join(self.folder, "dataset.json"), encoding="utf-8") as file:
            return dict(json.load(file))

    @property
    def failures(self) -> list[dict[str, Any]]:
        """failures.json: tasks that failed, and why; empty where all went well."""
        try:
            with open(os.path.join(self.folder, "failures.json"), encoding="utf-8") as file:
                return list(json.load(file))
        except FileNotFoundError:
            return []

    def rows(self, split: str, of: str = "shape") -> numpy.typing.NDArray[numpy.int64]:
        """Numbers of the samples of a part: `train`, `validation` or `test`.

        of: "shape" holds out whole objects; "strike" holds out strikes on objects that are in every part. Never mix
        the two: the test part of one is training material of the other.
        """
        if split not in PARTS:
            raise InputError(f"there is no part {split!r}", f"parts are {', '.join(PARTS)}")
        if f"split_{of}" not in self._names:
            raise InputError(f"there is no split of {of!r}", "splits are of \"shape\" and of \"strike\"")
        return numpy.flatnonzero(self[f"split_{of}"][:] == split)

    def torch(self, split: str = "train", label: str | None = "material", data: str = "audio", *, of: str = "shape",
              listener: int | None = None) -> Samples:
        """A map-style dataset of PyTorch: pairs (data, label) of a part; for any DataLoader.

        data: a column of numbers (`audio`, `mel`, `frames`, `touch`), or one of the objects (`shapes/voxels`)
        or of these in their materials (`appearances/frame`).
        label: a column of texts, numbered over the whole dataset (`classes` names them), or of numbers; None: data
        alone. listener: of audio and mel with several, this one alone.
        """
        from carillon.torch_data import Samples
        return Samples(self, self.rows(split, of), label, data, listener)

    def loader(self, split: str = "train", label: str | None = "material", data: str = "audio", *, of: str = "shape",
               listener: int | None = None, batch_size: int = 32, shuffle: bool | None = None,
               sampler: Iterable[int] | None = None, drop_last: bool = False, generator: Any = None,
               **options: Any) -> DataLoader[Any]:
        """A DataLoader over `torch(...)` that reads each batch in one go, which is several times as fast.

        shuffle: None shuffles the training part alone; sampler: an order of one's own instead; generator: of the
        shuffling. Further arguments are DataLoader's (num_workers, ...).
        """
        from torch.utils import data as torch_data
        samples = self.torch(split, label, data, of=of, listener=listener)
        if sampler is not None and shuffle is not None:
            raise InputError("sampler and shuffle both give the order", "leave one of them out")
        if sampler is None and (split == "train" if shuffle is None else shuffle):
            sampler = torch_data.RandomSampler(samples, generator=generator)
        elif sampler is None:
            sampler = torch_data.SequentialSampler(samples)
        return torch_data.DataLoader(samples, sampler=torch_data.BatchSampler(sampler, batch_size, drop_last),
                                     batch_size=None, generator=generator, **options)

    def table(self) -> Any:
        """The columns of one value each as pandas' DataFrame."""
        import pandas
        return pandas.DataFrame({name: self[name][:] for name in self._names
                                 if "/" not in name and len(self[name].shape) == 1})

    def __repr__(self) -> str:
        if self.samples == 0:
            return f"<dataset {self.folder}: no samples>"
        return f"<dataset {self.folder}: {self.samples} samples, {len(set(self['shape'][:]))} objects>"


def open_dataset(folder: str | os.PathLike[str]) -> Dataset:
    """The dataset in a folder that a build made.

    Raises InputError: it is none; FileError: its index cannot be read.
    """
    return Dataset(folder)
