"""Struck objects: shapes and materials to modes, sounds and datasets, and back.

    import carillon as ca
    bowl = ca.shape("bowl", radius=0.07)
    modes = bowl.modes("ceramic")
    sound = modes.strike(at=(0.07, 0, 0.05))
    damping = ca.fit(ca.features(sound))

Arrays go in and come out; nothing needs a file or `mpirun`. Units are SI. docs/python.md is the guide.
"""
import json as _json

from carillon import _carillon
from carillon.builds import Plan, build, plan
from carillon.datasets import Column, Dataset
from carillon.datasets import open_dataset as open
from carillon.errors import (
    CarillonWarning,
    ConfigError,
    Error,
    FileError,
    InputError,
    LimitError,
    ResourceError,
    SolverError,
)
from carillon.materials import Material, material, materials
from carillon.objects import Certificate, Modes, Object, shape, shapes
from carillon.scoring import Scores, score
from carillon.sounds import (
    Comparison,
    Estimate,
    Features,
    Fit,
    Sound,
    compare,
    estimate,
    features,
    fit,
    mel,
)

#: Versions of Carillon and of every library that values depend on.
versions: dict[str, str] = _json.loads(_carillon.versions())
__version__: str = versions["carillon"]

__all__ = [
    "CarillonWarning", "Certificate", "Column", "Comparison", "ConfigError", "Dataset", "Error", "Estimate", "Features",
    "FileError", "Fit", "InputError", "LimitError", "Material", "Modes", "Object", "Plan", "ResourceError",
    "Scores", "SolverError", "Sound", "build", "compare", "estimate", "features", "fit", "material", "materials", "mel",
    "open", "plan", "score", "shape", "shapes", "versions",
]
