"""Objects and their modes."""
from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import tempfile
from collections.abc import Mapping, Sequence
from typing import Any

import numpy
import numpy.typing
from carillon import _carillon, arguments, show
from carillon.arguments import FloatArray, Quantity
from carillon.errors import InputError
from carillon.materials import Material, material_text, stored_materials
from carillon.sounds import Sound, rate_of

#: Meshes and modes that were made once are kept here; "": nowhere. $CARILLON_CACHE or ~/.cache/carillon by default.
cache: str | os.PathLike[str] = _carillon.default_cache()


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


def _stored_modes(data: bytes, name: str, materials: list[Material], document: dict[str, Any]) -> Modes:
    """Modes that were pickled."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "modes.h5")
        path.write_bytes(data)
        texts = [material.text() for material in materials]
        return Modes(_carillon.load_modes(os.fspath(path), "", name, texts, os.fspath(cache)), document, materials)


class Modes:
    """Free vibration modes of an object in its material, ascending.

    Frequencies are undamped; shapes are mass-normalised, at the nodes of the surface.
    """

    def __init__(self, solved: _carillon.Solved, document: dict[str, Any] | None = None,
                 materials: Sequence[Material] | None = None):
        self._solved = solved
        self._materials = stored_materials(solved.materials) if materials is None else materials
        self._document: dict[str, Any] = json.loads(solved.json()) if document is None else document

    @classmethod
    def load(cls, path: str | os.PathLike[str], material: str | Material | Sequence[str | Material] | None = None, *,
             group: str = "", node: str = "") -> Modes:
        """Modes that `save`, `carillon modes -o` or a build stored, in the material that they were solved for; or those
        that a glTF file holds (KHR_audio_rigid_bodies), which need none.

        material: one, or one for each region. group: of the file; a build stores the sets of an object's materials
        as `set-000`, `set-001`, ... node: of a glTF file with several that sound.
        """
        name = os.fspath(path)
        if pathlib.Path(name).suffix.lower() in (".glb", ".gltf"):
            if material is not None:
                raise InputError(f"{name} brings its own material along",
                                 "leave material out; or Object.load(path).modes(material) solves its mesh anew")
            return cls(_carillon.load_sounding_gltf(name, node, os.fspath(cache)))
        if material is None:
            raise InputError(f"{name} does not say its material", "give the one that the modes were solved for")
        several = [material] if isinstance(material, (str, Material)) else list(material)
        return cls(_carillon.load_modes(name, group, name, [material_text(one) for one in several], os.fspath(cache)))

    def __reduce__(self) -> Any:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "modes.h5")
            self.save(path)
            return _stored_modes, (path.read_bytes(), self._solved.name, self.materials, self._document)

    @property
    def materials(self) -> list[Material]:
        """Of each region."""
        return list(self._materials)

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
        """All that `carillon modes --json` prints; of stored modes without what was not stored."""
        return self._document

    def __len__(self) -> int:
        return len(self._document["modes"])

    def in_material(self, material: str | Material, size: float = 1) -> Modes:
        """The same shape in another material of the same Poisson's ratio, and at another size: exact, and free."""
        return Modes(self._solved.in_material(material_text(material), float(size)))

    def strike(self, at: Sequence[float] | FloatArray | None = None, *,
               direction: Sequence[float] | FloatArray | None = None, impulse: Quantity | None = None,
               contact_time: Quantity | None = None, force: numpy.typing.ArrayLike | None = None,
               force_rate: Quantity | None = None, seconds: Quantity | None = None, rate: Quantity | None = None,
               gain: float | None = None, listeners: Sequence[Sequence[float] | FloatArray] = (),
               room: Mapping[str, Any] | None = None, supports: Mapping[str, Any] | None = None,
               noise: Mapping[str, Any] | None = None, striker: Mapping[str, Any] | None = None,
               scene: Mapping[str, Any] | None = None, seed: int = 1, repeat: int = 1,
               interval: Quantity = 0.2) -> Sound:
        """The sound of a strike: the velocity of the point [m/s], or the pressure at listeners [Pa].

        at: point [m]; the nearest one of the surface is struck. None: drawn by `seed`.
        direction: of the force; None: inward along the normal.
        impulse: 0.02 N s; contact_time: 0.2 ms, 0 an ideal impulse. A `striker` gives both instead, or
        force: [samples] N, straight lines between; force_rate: its samples per second [Hz], of a Sound its own.
        seconds: of the clip, 1; rate: 44100 Hz; gain: full scale per m/s or Pa, 1.
        listeners: positions [m] from the centre of the object's box, one channel each.
        room, supports, noise, striker: as the keys of a configuration (docs/configuration.md); `scene` has any
        further ones: `{"radiation": {...}, "effects": {...}}`. repeat: strikes, `interval` [s] apart.
        Returns [samples], or [listeners, samples] for several, float32, 1 at full scale.
        Raises ConfigError (names the key), InputError.
        """
        keys: dict[str, Any] = json.loads(arguments.settings(**arguments.mapping(scene, "scene")))
        positions = [{"position": arguments.point(listener, f"listener {i}")} for i, listener in enumerate(listeners)]
        keys = arguments.joined({"room": room, "supports": supports, "noise": noise, "striker": striker,
                                 "listeners": positions or None}, keys, "scene")
        keys["audio"] = arguments.joined({"seconds": seconds, "sample_rate": rate, "gain": gain},
                                         keys.get("audio"), "scene's audio")
        if force is not None and (impulse is not None or contact_time is not None):
            raise InputError("force and impulse or contact_time both say how hard is struck", "keep one of them")
        if "striker" in keys:
            if impulse is not None or contact_time is not None:
                raise InputError("a striker gives impulse and contact_time", "leave them out, or the striker")
        else:
            is_ideal = contact_time is not None and arguments.quantity(contact_time, "time", "contact_time") == 0
            strikes = arguments.joined({"impulse": impulse, "contact_time": None if is_ideal else contact_time},
                                       keys.get("strikes"), "scene's strikes")
            keys["strikes"] = {"impulse": _carillon.default_impulse, "contact_time": _carillon.default_contact_time,
                               **strikes}
            if is_ideal:
                keys["effects"] = arguments.joined({"contact": "off"}, keys.get("effects"), "scene's effects")
                del keys["strikes"]["contact_time"]
        names = {} if rate is None else {"audio.sample_rate": "rate", "sample_rate": "rate"}
        with arguments.arguments_of("strike()", names):
            samples, description = _carillon.strike(
                self._solved, arguments.settings(**keys), None if at is None else arguments.numbers(at, "at"),
                None if direction is None else arguments.numbers(direction, "direction"),
                None if force is None else arguments.numbers(force, "force"),
                0.0 if force is None else rate_of(force, force_rate, "force_rate"),
                arguments.whole(seed, "seed", 0, 2**64 - 1), arguments.whole(repeat, "repeat", 1, 10000),
                arguments.quantity(interval, "time", "interval"))
        document = json.loads(description)
        return Sound(samples[0] if len(samples) == 1 else samples, document["sample_rate_hz"], document)

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


Axis = Sequence[float] | FloatArray | None


def _settings(length: Quantity, thickness: Quantity, unit: str, any_size: bool, first_axis: Axis, second_axis: Axis,
              **profile: str) -> str:
    """What may be said of an object beside its shape."""
    axes = {name: None if axis is None else arguments.point(axis, name)
            for name, axis in (("first_axis", first_axis), ("second_axis", second_axis))}
    return arguments.settings(
        length=arguments.quantity(length, "length", "length"),
        thickness=arguments.quantity(thickness, "length", "thickness"), unit=arguments.word(unit, "unit"),
        any_size=bool(any_size), **axes, **profile)


class Object:
    """A shape to be solved: triangles in memory, a file, or a generated body."""

    def __init__(self, vertices: numpy.typing.ArrayLike, faces: numpy.typing.ArrayLike, *, length: Quantity = 0,
                 unit: str = "", thickness: Quantity = 0, any_size: bool = False, first_axis: Axis = None,
                 second_axis: Axis = None, name: str = "object"):
        """Triangles that bound a body.

        vertices: [n, 3], in metres or `unit` ("mm"); faces: [m, 3] indices, counter-clockwise from outside.
        length: longest side that the object is scaled to [m]; thickness: [m] given to open sheets; first_axis,
        second_axis: of an anisotropic material, in the object's coordinates.
        Faults of a surface are repaired when it is meshed: `modes.document["repair"]` tells. Raises InputError.
        """
        self._make("shape_from_arrays", arguments.numbers(vertices, "vertices"), arguments.indices(faces, "faces"),
                   arguments.word(name, "name"),
                   _settings(length, thickness, unit, any_size, first_axis, second_axis))

    def _make(self, maker: str, *shape: Any) -> None:
        self._made_of = (maker, *shape)
        self._shape: _carillon.Shape = getattr(_carillon, maker)(*shape)

    @classmethod
    def _of(cls, maker: str, *shape: Any) -> Object:
        made = cls.__new__(cls)
        made._make(maker, *shape)
        return made

    def __reduce__(self) -> Any:
        return Object._of, self._made_of

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, length: Quantity = 0, unit: str = "", thickness: Quantity = 0,
             any_size: bool = False, first_axis: Axis = None, second_axis: Axis = None, profile_axis: str = "",
             profile_id: str = "", node: str = "") -> Object:
        """A mesh file, or a profile (SVG, CSV) that is turned about an axis.

        Files are OBJ, OFF, PLY, STL, glTF, DAE, FBX, 3MF, X3D, STEP, IGES, BREP and MSH; a unit that is given counts
        more than the file's.
        node: of a file that has several, or of a CAD file's solids, this one alone; "": all as one body.
        profile_axis, profile_id: of a drawing, its axis (left, right or x=NUMBER) and its outline. The others are
        those of Object.
        """
        return cls._of("shape_from_text", os.fspath(path),
                       _settings(length, thickness, unit, any_size, first_axis, second_axis,
                                 profile_axis=profile_axis, profile_id=profile_id, node=arguments.word(node, "node")))

    @property
    def name(self) -> str:
        return self._shape.name

    def modes(self, material: str | Material | Mapping[str, str | Material] | None = None, *,
              pitch_cents: Quantity | None = None, min_frequency: Quantity | None = None,
              max_frequency: Quantity | None = None, max_modes: int | None = None, order: int | None = None,
              element_size: Quantity | None = None, max_elements: int | None = None, edge_layers: int | None = None,
              solver: str | None = None, eigen_solver: str | None = None, linear_solver: str | None = None,
              mirror_planes: str | None = None, max_unknowns: int | None = None,
              memory_limit: Quantity | None = None, tune: Quantity | None = None, tune_mode: int = 1) -> Modes:
        """Finds the modes; what is left out is chosen as `carillon modes` does.

        material: a preset's name, constants, or a Material; of an MSH file's physical groups a mapping. None: the
        usual one of a family that has one (`shapes()`; a bell is of bell bronze).
        pitch_cents: refine until the worst mode's estimated error is below it (5 by default, "off").
        tune: scale the object so that its mode `tune_mode`, counted from the lowest as 1, is at this pitch [Hz];
        `modes.document["size"]` is the factor of every length. Not with a length.
        The others are the keys of `modes` and `solver` in docs/configuration.md; `solver` is its `kind`.
        Works without `mpirun`; under it, each process solves its own. After Ctrl-C the call ends at once and the solve
        at its next step.
        Raises InputError, SolverError, ResourceError; CarillonWarning where a mesh was doubtful.
        """
        of_modes = {"order": order, "element_size": element_size, "max_elements": max_elements,
                    "edge_layers": edge_layers, "min_frequency": min_frequency, "max_frequency": max_frequency,
                    "max_modes": max_modes}
        of_solver = {"pitch_cents": pitch_cents, "kind": solver, "eigen_solver": eigen_solver,
                     "linear_solver": linear_solver, "mirror_planes": mirror_planes, "max_unknowns": max_unknowns,
                     "memory_limit": memory_limit}
        settings = {"modes": arguments.given(of_modes), "solver": arguments.given(of_solver)}
        if material is None:
            if not self._shape.usual_material:
                raise InputError(f"no material of {self.name} is given; a material is a name, constants or a Material",
                                 "name one of carillon.materials")
            material = self._shape.usual_material
        if isinstance(material, Mapping):
            materials: Any = {group: material_text(value) for group, value in material.items()}
        else:
            materials = material_text(material)
        with arguments.arguments_of("modes()", {"kind": "solver"}):
            pitch = 0.0 if tune is None else arguments.quantity(tune, "frequency", "tune")
            if tune is not None and not pitch > 0:
                raise InputError(f"tune: {tune} is no pitch", "write it as \"440 Hz\"")
            solved = self._shape.solve(json.dumps(materials), json.dumps(settings, default=arguments.plain),
                                       pitch, arguments.whole(tune_mode, "tune_mode", 1, 100000),
                                       os.fspath(cache))
        made = Modes(solved)
        warnings = list(solved.warnings())
        target = made.document.get("pitch_target")
        if target and not target["met"]:
            warnings.append(f"the pitch target of {target['asked_cents']:g} cents is missed, "
                            f"{target['reached_cents']:.3g} cents are reached: {target['reason']}")
        show.warn(f"{self.name}: {warning}" for warning in warnings)
        return made

    def __repr__(self) -> str:
        return f"<object {self.name}>"


def shape(family: str, *, profile: numpy.typing.ArrayLike | None = None, longest_side: Quantity = 0,
          any_size: bool = False, first_axis: Axis = None, second_axis: Axis = None, **parameters: Quantity) -> Object:
    """A generated body: `shape("bowl", radius=0.07)`; parameters [m] that are left out lie in the middle of their
    ranges (`shapes()` lists them).

    profile: of the family "turned", a closed polygon of (radius, height), [n, 2] m.
    longest_side: that the body is scaled to [m]; first_axis, second_axis: as of Object.
    Raises InputError: unknown family or parameter, sizes that contradict each other.
    """
    side = arguments.quantity(longest_side, "length", "longest_side")
    settings = _settings(side, 0, "", any_size, first_axis, second_axis)
    if profile is not None:
        if family != "turned" or parameters:
            raise InputError("a profile is all that there is to say of the family \"turned\"",
                             "leave out the parameters, or the profile")
        return Object._of("turned_shape", arguments.numbers(profile, "profile"), settings)
    values = ",".join(f"{name}={arguments.quantity_text(value)}" for name, value in parameters.items())
    family = arguments.word(family, "family")
    return Object._of("shape_from_text", f"{family}:{values}" if values else family, settings)


def shapes() -> dict[str, dict[str, Any]]:
    """Families of generated bodies by name: what they are, their parameters with default ranges [m], and the material
    that they are usually made of ("": none)."""
    return {family["name"]: {"description": family["description"], "usual_material": family.get("usual_material", ""),
                             "parameters": {parameter.pop("name"): parameter for parameter in family["parameters"]}}
            for family in json.loads(_carillon.families())}
