"""Objects and their modes."""
from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy
import numpy.typing
from carillon import _carillon, show
from carillon.materials import Material, material_text
from carillon.sounds import Sound

if TYPE_CHECKING:
    from collections.abc import Sequence

FloatArray = numpy.typing.NDArray[numpy.float64]
Quantity = float | str  #: a number in SI units, or a text with its unit: "5 mm"
#: Meshes and modes that were made once are kept here; "": nowhere. $CARILLON_CACHE or ~/.cache/carillon by default.
cache: str = _carillon.default_cache()

_OF_MODES = ("order", "element_size", "max_elements", "edge_layers", "min_frequency", "max_frequency", "max_modes")


@dataclasses.dataclass(frozen=True)
class Certificate:
    """What is known of a mode set's completeness and accuracy."""

    modes_in_band: int  #: flexible modes between the band's ends, counted by inertia where `count_verified`
    modes_found: int  #: of them, those in the set
    complete: bool  #: every mode in the band is in the set
    complete_to_hz: float  #: no mode below is missing
    rigid_modes: int
    components: int
    max_residual: float  #: ||K x - lambda M x|| / (lambda ||M x||), worst mode
    orthonormality: float  #: max |X^T M X - I|
    unknowns: int
    mirror_planes: int
    count_verified: bool
    eigen_solver: str
    linear_solver: str


class Modes:
    """Free vibration modes of an object in its material, ascending.

    Frequencies are undamped; shapes are mass-normalised, at the nodes of the surface.
    """

    def __init__(self, solved: _carillon.Solved):
        self._solved = solved
        self._document: dict[str, Any] = json.loads(solved.json())

    @classmethod
    def load(cls, path: str | os.PathLike[str], material: str | Material) -> Modes:
        """Modes that `save`, `carillon modes -o` or a build stored, in the material that they were solved for."""
        return cls(_carillon.load_modes(os.fspath(path), material_text(material)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """An HDF5 file as `carillon modes -o` writes it."""
        self._solved.save(os.fspath(path))

    @property
    def frequencies(self) -> FloatArray:
        """[modes] Hz, undamped."""
        return self._solved.frequencies

    @property
    def errors(self) -> FloatArray:
        """[modes] cents: estimated distance to the pitch of the body itself; empty where it was not estimated."""
        return self._solved.errors

    @property
    def decay_rates(self) -> FloatArray:
        """[modes] 1/s, of the material's damping."""
        return self._solved.decay_rates

    @property
    def residuals(self) -> FloatArray:
        """[modes] ||K x - lambda M x|| / (lambda ||M x||)."""
        return self._solved.residuals

    @property
    def shapes(self) -> numpy.typing.NDArray[numpy.float32]:
        """[modes, nodes, 3] kg^-1/2."""
        return self._solved.shapes

    @property
    def nodes(self) -> FloatArray:
        """[nodes, 3] m, of the surface."""
        return self._solved.nodes

    @property
    def triangles(self) -> numpy.typing.NDArray[numpy.int32]:
        """[triangles, 3] indices of nodes; curved faces are cut into flat ones."""
        return self._solved.triangles

    @property
    def mass(self) -> float:
        """kg."""
        return self._solved.mass

    @property
    def certificate(self) -> Certificate:
        return Certificate(**self._document["certificate"])

    @property
    def document(self) -> dict[str, Any]:
        """All that `carillon modes --json` prints."""
        return self._document

    def __len__(self) -> int:
        return len(self._document["modes"])

    def in_material(self, material: str | Material, size: float = 1) -> Modes:
        """The same shape in another material of the same Poisson's ratio, and at another size: exact, and free."""
        return Modes(self._solved.in_material(material_text(material), size))

    def strike(self, at: Sequence[float] | FloatArray | None = None, *,
               direction: Sequence[float] | FloatArray | None = None, impulse: Quantity = 0.02,
               contact_time: Quantity = 0.0002, seconds: Quantity = 1, rate: float = 44100, gain: float = 1,
               listeners: Sequence[Sequence[float] | FloatArray] = (),
               room: Mapping[str, Any] | None = None, supports: Mapping[str, Any] | None = None,
               noise: Mapping[str, Any] | None = None, striker: Mapping[str, Any] | None = None,
               scene: Mapping[str, Any] | None = None, seed: int = 1, repeat: int = 1,
               interval: float = 0.2) -> Sound:
        """The sound of a strike: the velocity of the point [m/s], or the pressure at listeners [Pa].

        at: point [m]; the nearest one of the surface is struck. None: drawn by `seed`.
        direction: of the force; None: inward along the normal.
        impulse: [N s]; contact_time: [s], 0 an ideal impulse. A `striker` gives both instead.
        listeners: positions [m] from the centre of the object's box, one channel each.
        room, supports, noise, striker: as the keys of a configuration (docs/configuration.md); `scene` has any
        further ones: `{"radiation": {...}, "effects": {...}}`.
        Returns [samples], or [listeners, samples] for several, float32, 1 at full scale.
        Raises ConfigError (names the key), InputError.
        """
        keys: dict[str, Any] = json.loads(json.dumps(dict(scene or {}), default=show.plain))
        audio = {"seconds": seconds, "sample_rate": rate, "gain": gain}
        keys["audio"] = audio | keys.get("audio", {})
        strikes = keys.setdefault("strikes", {})
        if striker is None and "striker" not in keys:
            strikes.setdefault("impulse", impulse)
            if contact_time == 0:
                keys.setdefault("effects", {}).setdefault("contact", "off")
            else:
                strikes.setdefault("contact_time", contact_time)
        if len(listeners) > 0:
            keys["listeners"] = [{"position": [float(x) for x in listener]} for listener in listeners]
        for name, value in (("room", room), ("supports", supports), ("noise", noise), ("striker", striker)):
            if value is not None:
                keys[name] = value
        with show.arguments_of("strike()"):
            samples, description = _carillon.strike(
                self._solved, json.dumps(keys, default=show.plain), None if at is None else numpy.asarray(at, float),
                None if direction is None else numpy.asarray(direction, float), seed, repeat, interval)
        return Sound(samples[0] if len(samples) == 1 else samples, rate, json.loads(description))

    def plot(self, axes: Any = None) -> Any:
        """Decay rates over frequencies, with matplotlib; returns the axes."""
        axes = show.axes(axes)
        axes.plot(self.frequencies, self.decay_rates, "o", ms=4)
        axes.set(xlabel="frequency [Hz]", ylabel="decay rate [1/s]", xscale="log", yscale="log",
                 title=self._solved.name)
        return axes

    def plot_shape(self, mode: int, scale: float = 0.1, axes: Any = None) -> Any:
        """The surface moved by a mode, coloured by how far, with matplotlib; `scale` of the longest side."""
        shape = self.shapes[mode].astype(float)
        size = numpy.ptp(self.nodes, axis=0).max()
        moved = self.nodes + shape * (scale * size / numpy.linalg.norm(shape, axis=1).max())
        axes = show.axes(axes, projection="3d")
        surface = axes.plot_trisurf(*moved.T, triangles=self.triangles, cmap="viridis", lw=0)
        surface.set_array(numpy.linalg.norm(shape, axis=1)[self.triangles].mean(1))
        axes.set_box_aspect(numpy.ptp(moved, axis=0))
        axes.set_axis_off()
        axes.set(title=f"{self.frequencies[mode]:.1f} Hz, moved {scale:g} of the longest side at most")
        return axes

    def _rows(self) -> list[list[str]]:
        errors = self.errors if len(self.errors) else numpy.full(len(self), numpy.nan)
        return [[str(i), f"{f:.2f}", f"{e:.2g}", f"{d:.3g}"]
                for i, (f, e, d) in enumerate(zip(self.frequencies, errors, self.decay_rates))]

    def __repr__(self) -> str:
        c = self.certificate
        whole = f"complete to {c.complete_to_hz:.0f} Hz" if c.complete_to_hz else "not known to be complete"
        worst = f", within {self.errors.max():.2g} cents" if len(self.errors) else ""
        span = f", {self.frequencies[0]:.1f} to {self.frequencies[-1]:.1f} Hz" if len(self) else ""
        return f"<{len(self)} modes of {self._solved.name}{span}{worst}, {whole}>"

    def _repr_html_(self) -> str:
        return show.table(["mode", "frequency [Hz]", "error [cents]", "decay [1/s]"], self._rows(), repr(self))


class Object:
    """A shape to be solved: triangles in memory, a file, or a generated body."""

    def __init__(self, vertices: numpy.typing.ArrayLike, faces: numpy.typing.ArrayLike, *, length: float = 0,
                 unit: str = "", thickness: float = 0, any_size: bool = False, name: str = "object"):
        """Triangles that bound a body.

        vertices: [n, 3], in metres or `unit` ("mm"); faces: [m, 3] indices, counter-clockwise from outside.
        length: longest side that the object is scaled to [m]; thickness: [m] given to open sheets.
        Faults of a surface are repaired when it is meshed, and warned of.
        """
        settings = _carillon.ObjectSettings(length, thickness, unit, any_size)
        self._shape = _carillon.shape_from_arrays(numpy.asarray(vertices, float), numpy.asarray(faces), name, settings)

    @classmethod
    def _of(cls, shape: _carillon.Shape) -> Object:
        made = cls.__new__(cls)
        made._shape = shape
        return made

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, length: float = 0, unit: str = "", thickness: float = 0,
             any_size: bool = False) -> Object:
        """A mesh file (OBJ, OFF, PLY, STL, MSH), or a profile (SVG, CSV) that is turned about an axis."""
        settings = _carillon.ObjectSettings(length, thickness, unit, any_size)
        return cls._of(_carillon.shape_from_text(os.fspath(path), settings))

    @property
    def name(self) -> str:
        return self._shape.name

    def modes(self, material: str | Material | Mapping[str, str | Material], *, pitch_cents: float | str | None = None,
              min_frequency: Quantity | None = None, max_frequency: Quantity | None = None,
              max_modes: int | None = None, order: int | None = None, element_size: Quantity | None = None,
              max_elements: int | None = None, edge_layers: int | None = None, solver: str | None = None,
              eigen_solver: str | None = None, linear_solver: str | None = None, mirror_planes: str | None = None,
              max_unknowns: int | None = None, memory_limit: Quantity | None = None) -> Modes:
        """Finds the modes; what is left out is chosen as `carillon modes` does.

        material: a preset's name, constants, or a Material; of an MSH file's physical groups a mapping.
        pitch_cents: refine until the worst mode's estimated error is below it (5 by default, "off").
        The others are the keys of `modes` and `solver` in docs/configuration.md; `solver` is its `kind`.
        Works without `mpirun`; under it, each process solves its own. Ctrl-C ends it.
        Raises InputError, SolverError, ResourceError; CarillonWarning where a mesh was doubtful.
        """
        given = {"pitch_cents": pitch_cents, "min_frequency": min_frequency, "max_frequency": max_frequency,
                 "max_modes": max_modes, "order": order, "element_size": element_size, "max_elements": max_elements,
                 "edge_layers": edge_layers, "kind": solver, "eigen_solver": eigen_solver,
                 "linear_solver": linear_solver, "mirror_planes": mirror_planes, "max_unknowns": max_unknowns,
                 "memory_limit": memory_limit}
        known = {key: value for key, value in given.items() if value is not None}
        settings = {"modes": {key: value for key, value in known.items() if key in _OF_MODES},
                    "solver": {key: value for key, value in known.items() if key not in _OF_MODES}}
        if isinstance(material, Mapping):
            materials: Any = {group: material_text(value) for group, value in material.items()}
        else:
            materials = material_text(material)
        with show.arguments_of("modes()"):
            solved = self._shape.solve(json.dumps(materials), json.dumps(settings, default=show.plain), cache)
        show.warn(f"{self.name}: {warning}" for warning in solved.warnings())
        return Modes(solved)

    def __repr__(self) -> str:
        return f"<object {self.name}>"


def shape(family: str, *, length: float = 0, profile: numpy.typing.ArrayLike | None = None,
          any_size: bool = False, **parameters: Quantity) -> Object:
    """A generated body: `shape("bowl", radius=0.07)`; parameters [m] that are left out lie in the middle of their
    ranges (`shapes()` lists them).

    profile: of the family "turned", a closed polygon of (radius, height), [n, 2] m.
    length: longest side that it is scaled to [m].
    Raises InputError: unknown family or parameter, sizes that contradict each other.
    """
    settings = _carillon.ObjectSettings(length, 0, "", any_size)
    if profile is not None:
        return Object._of(_carillon.turned_shape(numpy.asarray(profile, float), settings))
    values = ",".join(f"{name}={value}" for name, value in parameters.items())
    return Object._of(_carillon.shape_from_text(f"{family}:{values}" if values else family, settings))


def shapes() -> dict[str, dict[str, Any]]:
    """Families of generated bodies by name: what they are, and their parameters with default ranges [m]."""
    return {family.pop("name"): family for family in json.loads(_carillon.families())}
