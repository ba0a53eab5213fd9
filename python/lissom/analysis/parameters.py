"""Model parameters by name: their values, and derivatives of forces and places."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .._lissom import Model, has_one_sided_forces
from ..model import paths
from ..model.views import is_rod
from . import differences
from .materials import Materials, OfMaterial, nodes_of

Array = NDArray[np.float64]

#: The initial state: all of it, or one coordinate.
START = re.compile(r"(?P<which>q0|v0)(\[(?P<index>\d+)\])?")

#: Inputs: all, those of one control step, or a single one.
INPUT = re.compile(r"u(\[(?P<step>\d+)\](\[(?P<input>\d+)\])?)?")

#: The name of an entry in brackets.
NAMED = re.compile(r"\[[^\W\d]")

#: Path components of effects that act in some states only.
ONE_SIDED = frozenset(("contact", "contacts", "limits", "limit_stiffness", "limit_dissipation"))

#: Prefix of paths to actuators; some of them, such as tendons of given length, act in some states only.
OF_ACTUATORS = frozenset(("actuator", "actuators", "tendon", "tendons", "motor", "motors"))

#: Arguments that may be a single number if they are equal in all three directions.
OF_ALL_DIRECTIONS = frozenset(
    ("friction", "stiffness", "damping", "rotational_stiffness", "rotational_damping")
)

Term = tuple[Model, float]

M = TypeVar("M", bound=Model)


@dataclass(frozen=True)
class OfStart:
    """An initial coordinate or velocity."""

    name: str
    which: str
    index: int


@dataclass(frozen=True)
class OfInput:
    """An input of a control step."""

    name: str
    step: int
    input: int


@dataclass(frozen=True)
class OfModel:
    """A parameter of the model.

    Attributes
    ----------
    material : OfMaterial or None
        Set if only a segment's stiffness, damping and inertia depend on it.
    length_of : int or None
        Index of the segment whose length it is, if nothing else depends on that length and the adjoint is
        requested.
    """

    name: str
    value: float
    material: OfMaterial | None
    _model: Model = field(repr=False)
    length_of: int | None = None

    @property
    def path(self) -> list[paths.Part]:
        """Its path in the model."""
        return _path(self._model, self.name)

    @property
    def terms(self) -> tuple[Term, ...]:
        """The derivative with respect to the parameter, as weighted models."""
        return tuple((model, weight) for (model, _), weight in self.nearby)

    @functools.cached_property
    def nearby(self) -> tuple[tuple[tuple[Model, float], float], ...]:
        """These models with their values of the parameter, and the weights."""

        def with_value(value: float) -> tuple[Model, float]:
            try:
                other = self.with_value(value)
            except ValueError as error:
                raise ValueError(
                    f"parameters: got {self.name!r}, expected a number that can change by itself: with "
                    f"{value:.10g} in place of {self.value:.10g} the model is refused ({error})"
                ) from None
            if other.n != self._model.n:
                raise ValueError(
                    f"parameters: {self.name!r} changes the number of coordinates, expected one that does not"
                )
            return other, value

        if has_one_sided_forces(self._model):
            return differences.terms(
                with_value, self.value, differences.OF_LINEAR, relative=differences.FINE_STEP
            )
        return differences.terms(with_value, self.value, self.nodes)

    def with_value(self, value: float) -> Model:
        """The model with another value."""
        other: Model = paths.replaced(self._model, self.path, value)
        return other

    @property
    def nodes(self) -> differences.Nodes:
        """Where models are built for the derivative."""
        return nodes_of(self.path)


@dataclass(frozen=True)
class OfArgument(OfModel):
    """An argument of a function that makes the model."""

    make: Callable[[float], Model] = field(kw_only=True, repr=False)

    def with_value(self, value: float) -> Model:
        """See `OfModel`."""
        return self.make(value)

    @property
    def nodes(self) -> differences.Nodes:
        """See `OfModel`."""
        return differences.CENTRAL


Parameter = OfStart | OfInput | OfModel


def model_with(model: M, values: Mapping[str, float]) -> M:
    """The model with these values."""
    for name, value in values.items():
        model = paths.replaced(model, _path(model, name), value)
    return model


def value_of(model: Model, name: str) -> float:
    """The value of a parameter in a model."""
    found = {_number(value, name) for value in values_at(model, _path(model, name))}
    if len(found) > 1:
        listed = ", ".join(f"{value:g}" for value in sorted(found))
        raise ValueError(
            f"parameters: {name!r} has the values {listed}, expected equal ones, as they share one: "
            "make them equal, or name each by its index"
        )
    return found.pop()


def values_at(model: Model, path: Sequence[paths.Part]) -> list[Any]:
    """The values at a path: several if it has stars."""
    return [paths.found(model, one) for one in paths.each_of(model, path)]


def check_shared(model: Model, name: str) -> None:
    """Raise ValueError unless there are finite numbers at a path, which need not be equal."""
    for value in values_at(model, _path(model, name)):
        _number(value, name)


def _number(value: Any, name: str) -> float:
    # A single number: a constant radius, or a stiffness that is equal in all directions.
    of_all = 3 if name.rpartition(".")[2] in OF_ALL_DIRECTIONS else 2
    if isinstance(value, tuple) and len(value) == of_all and len(set(value)) == 1:
        value = value[0]
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(
            f"parameters: {name!r} is {value!r} in this model, expected the name of a finite number, such as "
            "'rod[0].segment[0].young_modulus' or 'gravity[2]'"
        )
    return float(value)


def _path(model: Model, name: str) -> list[paths.Part]:
    path = paths.of_model(paths.parts(name), is_rod(model))
    return paths.with_numbers(model, path) if NAMED.search(name) else path


def names_of(names: object) -> list[Any]:
    """The given names, without repetition."""
    if isinstance(names, str) or not isinstance(names, Iterable):
        raise TypeError(f"parameters: got {type(names).__name__}, expected a sequence of names")
    listed = list(names)
    for i, name in enumerate(listed):
        if isinstance(name, OfModel):
            # Those that `fit` makes of the arguments of a function.
            continue
        if not isinstance(name, str):
            raise TypeError(f"parameters[{i}]: got {type(name).__name__}, expected a name")
        if name in listed[:i]:
            raise ValueError(f"parameters[{i}]: {name!r} is listed twice: give each name once")
    if not listed:
        raise ValueError("parameters: got no names, expected at least one")
    return listed


def resolved(
    model: Model,
    names: Sequence[str | OfModel],
    inputs: tuple[int, int] | None = None,
    *,
    by_adjoint: bool = False,
) -> list[Parameter]:
    """Parameters with these names; `q0` and `v0` are expanded to one per coordinate.

    `inputs` are the numbers of control steps and of inputs; None if inputs are not parameters. `by_adjoint`
    requests the adjoint of a run, which needs no other models for some lengths.

    Raises ValueError for unknown names, and for parameters on which nothing depends.
    """
    found: list[Parameter] = []
    known: dict[object, str] = {}
    materials = Materials(model)
    for name in names:
        if isinstance(name, OfModel):
            found.append(name)
            continue
        start, held = START.fullmatch(name), INPUT.fullmatch(name)
        if start is not None:
            new: list[Parameter] = list(_of_start(model, name, start))
        elif held is not None:
            new = list(_of_inputs(name, held, inputs))
        else:
            new = [_of_model(model, name, materials, by_adjoint)]
        for parameter in new:
            keys: list[object] = [parameter.name]
            if isinstance(parameter, OfModel):
                keys = [paths.written_out(model, one) for one in paths.each_of(model, parameter.path)]
            for key in keys:
                if key in known:
                    also = "" if known[key] == parameter.name else f", first as {known[key]!r}"
                    raise ValueError(f"parameters: {parameter.name!r} is listed twice{also}: give it once")
                known[key] = parameter.name
        found += new
    return found


def _of_start(model: Model, name: str, start: re.Match[str]) -> Iterator[OfStart]:
    which, index = start["which"], start["index"]
    if index is not None and int(index) >= model.n:
        raise ValueError(f"parameters: got {name!r}, expected an index below {model.n}")
    for i in range(model.n) if index is None else [int(index)]:
        yield OfStart(f"{which}[{i}]", which, i)


def _of_inputs(name: str, held: re.Match[str], inputs: tuple[int, int] | None) -> Iterator[OfInput]:
    if inputs is None:
        raise ValueError(
            f"parameters: got {name!r}, expected numbers of the model: inputs are not among them. By inputs "
            "an equilibrium changes by -solve(K, model.input_tangent(q, u=u)) with the stiffness "
            "K = model.tangent(q, 0 * q, 0 * q, u=u)[0]; for dynamics there is linearise(model, q, u=u, "
            "inputs='inputs')"
        )
    chosen = []
    for index, count, what in zip((held["step"], held["input"]), inputs, ("steps", "inputs"), strict=True):
        if index is not None and int(index) >= count:
            raise ValueError(
                f"parameters: got {name!r}, expected an index below {count}, the number of {what}"
            )
        chosen.append(range(count) if index is None else [int(index)])
    for step in chosen[0]:
        for i in chosen[1]:
            yield OfInput(f"u[{step}][{i}]", step, i)


def _of_model(model: Model, name: str, materials: Materials, by_adjoint: bool) -> OfModel:
    path = _path(model, name)
    if paths.EVERY in path:
        material = materials.shared(paths.each_of(model, path))
        return _that_matters(OfModel(name, value_of(model, name), material, model))
    length_of = materials.free_length(path) if by_adjoint else None
    if length_of is not None:
        # A longer rod has more mass, and a longer reach.
        return OfModel(name, _number(paths.found(model, path), name), None, model, length_of)
    material = materials.derivative(path)
    value = _number(paths.found(model, path), name) if material is None else material.value
    return _that_matters(OfModel(name, value, material, model))


def _that_matters(parameter: OfModel) -> OfModel:
    """The parameter; raises ValueError if nothing depends on it."""
    name, model, material, path = parameter.name, parameter._model, parameter.material, parameter.path
    if material is None:
        acts_in_some_states = not ONE_SIDED.isdisjoint(path) or (
            path[0] in OF_ACTUATORS and has_one_sided_forces(model)
        )
        matters = acts_in_some_states or _matters(parameter.terms)
    else:
        # The inertia of everything that moves matters.
        has_inertia = material.section is not None and path[-1] != "shear_correction"
        matters = has_inertia or bool(material.stiffness.any() or material.damping.any())
    if matters:
        return parameter
    raise ValueError(
        f"parameters: nothing depends on {name!r} in this model, expected one that the motion or a place "
        "depends on"
    )


def _matters(terms: Sequence[Term]) -> bool:
    """Whether models differ in forces or in places."""
    models = [model for model, _ in terms]
    n = models[0].n
    # Arbitrary numbers, so that no symmetry of a model hides a difference.
    state = [0.1 * np.sin(1.7 * np.arange(n) + shift) for shift in (0.3, 1.1, 2.3)]
    # At later times, because loads may start at zero; with nonzero inputs, because defaults may be zero.
    inputs = len(models[0].inputs)
    of_inputs = [None, 1.0 + 0.1 * np.sin(1.7 * np.arange(inputs))] if inputs else [None]
    for t in (0.0, 0.137, 1.71):
        for u in of_inputs:
            forces = [model.inverse_dynamics(*state, t=t, u=u) for model in models]
            if any(not np.array_equal(force, forces[0]) for force in forces):
                return True
    poses = [pose(model, state[0]) for model in models if hasattr(model, "pose")]
    return any(not np.array_equal(other, poses[0]) for other in poses)


def pose(model: Any, q: Array) -> Array:
    """Poses of the tips of all links, one after the other."""
    return np.concatenate([np.ravel(model.pose(q, link=link.name)) for link in model.links])


def place_derivative(
    parameter: OfModel, q: Array, X: float | None, t: Array, place: Mapping[str, Any]
) -> Array | None:
    """Derivative of a position with respect to lengths, placements and motions at fixed coordinates.

    For coordinates (k, n) at times (k,), shape (k, 3); None if the parameter does not move the place.
    """
    if parameter.material is not None:
        return None
    moved = [
        weight * model.pose(q, X, t=t, **place)[..., :3, 3]  # type: ignore[attr-defined]
        for model, weight in parameter.terms
    ]
    total = np.sum(moved, axis=0)
    is_rounding = np.abs(total).max() <= differences.ROUNDING * np.abs(moved).sum(axis=0).max()
    return None if is_rounding else np.asarray(total)
