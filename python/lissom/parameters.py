"""Parameters of models by name: their values, and how forces and places change with them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._lissom import Model
from .sweeps import paths
from .views import is_rod

Array = NDArray[np.float64]

#: Distance of the nodes of differences, relative to the parameter. Fourth order leaves its fourth power,
#: 2e-11, times a derivative of fifth order (nothing of polynomials up to the fourth power); rounding leaves
#: as much.
STEP = 2e-3

#: Nodes and weights of the derivative by four differences, central and to one side (Fornberg 1988, tables 1
#: and 3).
CENTRAL = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))
ONE_SIDED = ((0, -25 / 12), (1, 4.0), (2, -3.0), (3, 4 / 3), (4, -1 / 4))

#: Changes of places below that part of what they are made of are rounding.
ROUNDING = 1e-13

#: The state at the start, all of it or a coordinate.
START = re.compile(r"(?P<which>q0|v0)(\[(?P<index>\d+)\])?")

Term = tuple[Model, float]

M = TypeVar("M", bound=Model)


@dataclass(frozen=True)
class OfStart:
    """A coordinate or a velocity at the start."""

    name: str
    which: str
    index: int


@dataclass(frozen=True)
class OfModel:
    """A number that a model is made from, and the derivative with respect to it as weighted models."""

    name: str
    value: float
    terms: tuple[Term, ...]


Parameter = OfStart | OfModel


def model_with(model: M, values: Mapping[str, float]) -> M:
    """The model with these values."""
    for name, value in values.items():
        model = paths.replaced(model, _path(model, name), value)
    return model


def value_of(model: Model, name: str) -> float:
    """The number that a model has for a parameter."""
    value = paths.found(model, _path(model, name))
    # A radius that is the same at both ends.
    if isinstance(value, tuple) and len(value) == 2 and value[0] == value[1]:
        value = value[0]
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(
            f"parameters: {name!r} is {value!r} in this model, expected the name of a finite number, such as "
            "'rod[0].segment[0].young_modulus' or 'gravity[2]'"
        )
    return float(value)


def _path(model: Model, name: str) -> list[paths.Part]:
    return paths.of_model(paths.parts(name), is_rod(model))


def names_of(names: object) -> list[str]:
    """The names that were given, once each."""
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise TypeError(f"parameters: got {type(names).__name__}, expected a sequence of names")
    listed = list(names)
    for i, name in enumerate(listed):
        if not isinstance(name, str):
            raise TypeError(f"parameters[{i}]: got {type(name).__name__}, expected a name")
        if name in listed[:i]:
            raise ValueError(f"parameters[{i}]: got {name!r} a second time, expected every name once")
    if not listed:
        raise ValueError("parameters: got no names, expected at least one")
    return listed


def resolved(model: Model, names: Sequence[str]) -> list[Parameter]:
    """Parameters with these names; `q0` and `v0` are as many as there are coordinates.

    Raises ValueError for a name of nothing, and for a parameter that nothing depends on.
    """
    found: list[Parameter] = []
    for name in names:
        start = START.fullmatch(name)
        if start is None:
            found.append(_of_model(model, name))
            continue
        which, index = start["which"], start["index"]
        if index is not None and int(index) >= model.n:
            raise ValueError(f"parameters: got {name!r}, expected an index below {model.n}")
        for i in range(model.n) if index is None else [int(index)]:
            if any(parameter.name == f"{which}[{i}]" for parameter in found):
                raise ValueError(f"parameters: got '{which}[{i}]' a second time, expected it once")
            found.append(OfStart(f"{which}[{i}]", which, i))
    return found


def _of_model(model: Model, name: str) -> OfModel:
    value = value_of(model, name)
    path = _path(model, name)
    step = STEP * (abs(value) or 1.0)

    def terms(nodes: Sequence[tuple[int, float]]) -> tuple[Term, ...]:
        return tuple((paths.replaced(model, path, value + k * step), w / step) for k, w in nodes)

    if value == 0.0:
        found = terms(ONE_SIDED)
    else:
        try:
            found = terms(CENTRAL)
        except ValueError:
            # At the end of what makes sense, such as a Poisson ratio of 0.5.
            step = math.copysign(step, -value)
            found = terms(ONE_SIDED)
    for other, _ in found:
        if other.n != model.n:
            raise ValueError(
                f"parameters: {name!r} changes the number of coordinates, expected one that does not"
            )
    if not _matters(found):
        raise ValueError(
            f"parameters: nothing depends on {name!r} in this model, expected one that the motion or a place "
            "depends on"
        )
    return OfModel(name, value, found)


def _matters(terms: Sequence[Term]) -> bool:
    """Whether models differ in forces or in places."""
    models = [model for model, _ in terms]
    n = models[0].n
    # Numbers without a pattern that a model could have.
    state = [0.1 * np.sin(1.7 * np.arange(n) + shift) for shift in (0.3, 1.1, 2.3)]
    # What starts later, such as a load, has a rise to be seen in.
    for t in (0.0, 0.137, 1.71):
        forces = [model.inverse_dynamics(*state, t=t) for model in models]
        if any(not np.array_equal(force, forces[0]) for force in forces):
            return True
    poses = [pose(model, state[0]) for model in models if hasattr(model, "pose")]
    return any(not np.array_equal(other, poses[0]) for other in poses)


def pose(model: Any, q: Array) -> Array:
    """Poses of the tips of all links, one after the other."""
    return np.concatenate([np.ravel(model.pose(q, link=link.name)) for link in model.links])


def place_derivative(
    parameter: OfModel, q: Array, X: float | None, t: float, place: Mapping[str, Any]
) -> Array | None:
    """How lengths and placements move a place while the coordinates stay; None where they do not."""
    moved = [
        weight * model.pose(q, X, t=t, **place)[..., :3, 3]  # type: ignore[attr-defined]
        for model, weight in parameter.terms
    ]
    total = np.sum(moved, axis=0)
    is_rounding = np.abs(total).max() <= ROUNDING * np.abs(moved).sum(axis=0).max()
    return None if is_rounding else np.asarray(total)
