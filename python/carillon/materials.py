"""Materials: the presets, and one's own."""
from __future__ import annotations

import dataclasses
import functools
import json
from collections.abc import Iterator, Mapping
from typing import Any

from carillon import _carillon
from carillon.arguments import quantity
from carillon.errors import InputError


@dataclasses.dataclass(frozen=True)
class Material:
    """An elastic solid and its damping.

    `damping` is a model (`rayleigh`, `caughey`, `power`, `hybrid`) or a formula of `lambda`, `omega`, `f` and
    `alpha1`, `alpha2`, ...; `alphas` are its numbers, of c = 2 d [1/s]. An anisotropic solid has its `stiffness`,
    6 x 6 [Pa] in Voigt's order 11 22 33 23 13 12; its Young's modulus is then the isotropic mean.
    """

    name: str
    youngs_modulus: float  #: [Pa]
    poisson_ratio: float
    density: float  #: [kg/m^3]
    damping: str = "rayleigh"
    alphas: tuple[float, ...] = (0.0, 0.0)
    stiffness: tuple[tuple[float, ...], ...] | None = None
    source: str = ""
    group: str = ""  #: metal, wood, stone, ceramic, glass, plastic, rubber or other; "": not said

    def __post_init__(self) -> None:
        for name, dimension in (("youngs_modulus", "pressure"), ("poisson_ratio", "none"), ("density", "density")):
            object.__setattr__(self, name, quantity(getattr(self, name), dimension, name))
        object.__setattr__(self, "alphas", tuple(map(float, self.alphas)))
        if self.stiffness is not None:
            object.__setattr__(self, "stiffness", tuple(tuple(map(float, row)) for row in self.stiffness))

    def replace(self, **changes: Any) -> Material:
        """The same material with other values, as `dataclasses.replace`; texts may have units.

        Raises InputError: an elastic constant of an anisotropic solid, whose stiffness alone counts.
        """
        if self.stiffness is not None and "stiffness" not in changes:
            for name in changes.keys() & {"youngs_modulus", "poisson_ratio"}:
                raise InputError(f"{name} of {self.name} follows from its stiffness", "give another stiffness")
        return dataclasses.replace(self, **changes)

    def text(self) -> str:
        """As the command line and configurations take it: `youngs_modulus=7.2e+10,...`."""
        if self.stiffness is None:
            elastic = f"youngs_modulus={self.youngs_modulus!r},poisson_ratio={self.poisson_ratio!r}"
        else:
            elastic = "stiffness=" + " ".join(repr(entry) for row in self.stiffness for entry in row)
        alphas = "".join(f",alpha{i + 1}={alpha!r}" for i, alpha in enumerate(self.alphas))
        return f"{elastic},density={self.density!r},damping={self.damping}{alphas}"


def _from_json(entry: dict[str, Any]) -> Material:
    damping = entry["damping"]
    alphas = tuple(damping[f"alpha{i}"] for i in range(1, 1 + sum(key.startswith("alpha") for key in damping)))
    stiffness = entry.get("stiffness_pa")
    return Material(entry["name"], entry["youngs_modulus_pa"], entry["poisson_ratio"], entry["density_kg_m3"],
                    damping.get("expression", damping["model"]), alphas,
                    stiffness and tuple(map(tuple, stiffness)), entry["source"], entry.get("group", ""))


@functools.cache
def _presets() -> dict[str, Material]:
    return {material.name: material for material in stored_materials(_carillon.materials())}


def stored_materials(text: str) -> list[Material]:
    """Of the library's JSON."""
    return [_from_json(entry) for entry in json.loads(text)]


class _Presets(Mapping[str, Material]):
    """Materials by name."""

    def __getitem__(self, name: str) -> Material:
        return _presets()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(_presets())

    def __len__(self) -> int:
        return len(_presets())

    def __repr__(self) -> str:
        return f"materials: {', '.join(self)}"


#: The presets by name, with their sources.
materials: Mapping[str, Material] = _Presets()


def material(description: str | Material, name: str | None = None) -> Material:
    """A preset by name, or one's own by its constants.

    description: `"ceramic"`, or `"youngs_modulus=72 GPa,poisson_ratio=0.19,density=2700,alpha1=6,alpha2=1e-7"`.
    Raises InputError where it is unknown (names the nearest), malformed or unphysical.
    """
    if isinstance(description, Material):
        return description
    found = _presets().get(description) or _from_json(json.loads(_carillon.parse_material(description)))
    return found if name is None else found.replace(name=name)


def material_text(description: str | Material) -> str:
    """What the library reads: presets keep their names."""
    if isinstance(description, str):
        return description
    if not isinstance(description, Material):
        raise InputError(f"a material is a name, constants or a Material, not {description!r}")
    return description.name if _presets().get(description.name) == description else description.text()
